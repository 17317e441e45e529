"""The physics engine behind a thin shell; the only part of gaitlab that knows Bullet."""

from gaitlab.engine.engine import Engine, TickState

__all__ = ["Engine", "TickState"]
