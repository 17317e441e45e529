"""The way that a walk is commanded to go, and how far along and beside it the robot is.

The trunk is to go ahead at 2 S / T, to the left at 2 Q / T and to turn at 2 W / T, with T the gait
period, S the step length, Q the side step and W the turn of a step. The way is a straight line, or
an arc of radius speed over rate whose centre is on the side it turns to. Distances are measured
along it from where the walk began, and across it to the left of where the robot faces at first;
on an arc, to the left of the way. Derived here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot

import numpy as np

SLOWEST = 1e-9  # rad/s; slower a walk does not turn


@dataclass(frozen=True, kw_only=True)
class Course:
    """A commanded way, in the frame in which the walk begins: x ahead, y to the left.

    Attributes:
        ahead: Speed ahead, in [m/s]; negative backwards.
        aside: Speed to the left, in [m/s].
        rate: Yaw rate, to the left, in [rad/s].
    """

    ahead: float
    aside: float = 0.0
    rate: float = 0.0

    @property
    def speed(self) -> float:
        """Along the way, in [m/s]; negative for a walk straight backwards."""
        return hypot(self.ahead, self.aside) if self.aside or self.rate else self.ahead

    @property
    def straight(self) -> bool:
        """Whether the way is a line ahead or back, or none at all."""
        return not self.aside and not self.radius

    @cached_property
    def radius(self) -> float:
        """Radius of the arc, in [m], positive for one to the left; 0 for a straight line."""
        turns = abs(self.rate) > SLOWEST
        return hypot(self.ahead, self.aside) / self.rate if turns else 0.0

    def of(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distances along and across the way of points in the order of time, in [m].

        Shapes (n,), (n,) to (n, 2).
        """
        if self.straight:
            return np.stack([(-1.0 if self.ahead < 0.0 else 1.0) * x, y], axis=-1)
        direction = atan2(self.aside, self.ahead)
        c, s = np.cos(direction), np.sin(direction)
        along, across = c * x + s * y, c * y - s * x
        if not self.radius:
            return np.stack([along, across], axis=-1)
        # From the centre of the arc, the angle gone round it.
        sign, radius = np.sign(self.radius), abs(self.radius)
        left = sign * across
        gone = np.unwrap(np.arctan2(along, radius - left))
        return np.stack([radius * gone, sign * (radius - np.hypot(along, radius - left))], axis=-1)
