"""The one rule that says when a robot has fallen.

A robot has fallen when its trunk was tilted beyond 45 degrees for 0.1 s, when a link other than a
foot lay on the ground for 0.05 s, or when the trunk is below 0.6 of its standing height. The
numbers are gaitlab's own: [EROS2018] calls a walk unstable when the robot falls and does not say
when that is.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import ceil, cos, radians
from typing import Final

UPRIGHT_LIMIT: Final = cos(radians(45.0))  # -, R33 below it is a tilt no open-loop walk leaves
TILT_TIME: Final = 0.1  # s, longer than the rocking of a heel strike
BODY_CONTACT_TIME: Final = 0.05  # s, longer than a hand or a knee that brushes the ground
HEIGHT_RATIO: Final = 0.6  # of standing height; legs that gave way, far below a walking squat

CAUSES: Final = ("none", "tilt", "body_contact", "low_trunk")  # by the log's code
_TILT, _BODY_CONTACT, _LOW_TRUNK = 1, 2, 3


def _ticks(duration: float, dt: float) -> int:
    """Ticks that fill a duration in [s]; the margin forgives 0.1 / 0.002 being above 50."""
    return max(1, ceil(duration / dt - 1e-6))


class FallDetector:
    """Says at each tick whether and why the robot has fallen; remembers the first cause.

    Causes that come true at the same tick rank tilt, body contact, low trunk.

    Attributes:
        cause: Code of the log's column `fall_cause`: 0 none, 1 tilt, 2 body contact, 3 low trunk.
    """

    __slots__ = ("_contact_ticks", "_lowest", "_tilt_ticks", "_tilted", "_touching", "cause")

    def __init__(self, dt: float, standing_height: float) -> None:
        """Takes the time step in [s] and the trunk's height when standing still in [m]."""
        self.cause = 0
        self._tilted = self._touching = 0
        self._tilt_ticks = _ticks(TILT_TIME, dt)
        self._contact_ticks = _ticks(BODY_CONTACT_TIME, dt)
        self._lowest = HEIGHT_RATIO * standing_height

    def update(self, upright: float, body_contact: bool, trunk_height: float) -> int:
        """Cause of the fall up to this tick, 0 while there is none.

        Args:
            upright: Cosine of the trunk's tilt, R33 of its rotation matrix.
            body_contact: Whether a link other than a foot touches the ground.
            trunk_height: Height of the trunk link frame, in [m].
        """
        if self.cause:
            return self.cause
        self._tilted = self._tilted + 1 if upright < UPRIGHT_LIMIT else 0
        self._touching = self._touching + 1 if body_contact else 0
        if self._tilted >= self._tilt_ticks:
            self.cause = _TILT
        elif self._touching >= self._contact_ticks:
            self.cause = _BODY_CONTACT
        elif trunk_height < self._lowest:
            self.cause = _LOW_TRUNK
        return self.cause
