"""One trial from its numbers to its log: the engine, the loop around it and the recording.

Only this package knows Bullet. What a robot or a gait is stands in `model`, the laws of the ground
in `surfaces`.
"""

from gaitlab.simulation.simulate import engine_for, simulate, start_of

__all__ = ["engine_for", "simulate", "start_of"]
