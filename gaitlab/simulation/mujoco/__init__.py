"""MuJoCo behind the interface of `gaitlab.simulation.engine`: the fast engine.

The only room that imports mujoco. A whole trial is one call of compiled code that calls MuJoCo's C
functions stage by stage, and between two stages says what each constraint is in N m and N/m.
"""
