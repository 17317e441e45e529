"""Bullet behind the interface of `gaitlab.simulation.engine`: the reference.

The only room that imports pybullet. Facts about Bullet that decide correctness stand beside the
calls they concern.
"""
