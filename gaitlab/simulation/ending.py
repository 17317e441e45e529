"""When a trial ends, decided at the end of every tick by one compiled rule for all engines.

A trial ends with a fall (see `gaitlab.log.fall`), when the trunk is as far along its commanded way
as the horizon asks, or when the numbers are lost.
"""

from __future__ import annotations

from math import atan2, ceil, cos, hypot, isfinite, pi, sin
from typing import Final

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.log.course import Course
from gaitlab.log.fall import (
    BODY_CONTACT,
    BODY_CONTACT_TIME,
    HEIGHT_RATIO,
    LOW_TRUNK,
    TILT,
    TILT_TIME,
    UPRIGHT_LIMIT,
)

GOES_ON: Final = 0  # the codes of a fall, 1 to 3, are those of the log
ARRIVED: Final = 8
LOST: Final = 9  # a number of the state is none any more

# What `ended` remembers from tick to tick, by index.
_TICKS, _TILTED, _TOUCHING, _X, _Y, _COS, _SIN, _GONE = range(8)


class Ending:
    """The rule of one trial, and what it remembers.

    Attributes:
        rule: What never changes, as `ended` wants it. Shape (9,).
        memory: What it remembers; changed in place. Shape (8,).
    """

    def __init__(
        self, *, dt: float, standing_height: float, startup: int, distance: float, course: Course
    ) -> None:
        """The rule before the first tick.

        Args:
            dt: Duration of a tick, in [s].
            standing_height: Height of the trunk link frame when standing still, in [m].
            startup: Ticks before the walk begins.
            distance: How far along its way the trunk is to get, in [m].
            course: The way that is commanded.
        """
        along = atan2(course.aside, course.ahead) if course.aside or course.radius else 0.0
        times = (_ticks(duration, dt) for duration in (TILT_TIME, BODY_CONTACT_TIME))
        limits = (HEIGHT_RATIO * standing_height, startup, distance)
        self.rule = np.array([*times, *limits, cos(along), sin(along), course.radius])
        self.memory = np.zeros(8)
        self.memory[_COS] = 1.0

    def after(self, trunk: np.ndarray, touches: bool) -> int:
        """What `ended` says of a tick after which the trunk is there. Shape (7,) or more."""
        return int(ended(self.rule, self.memory, trunk, touches))


def _ticks(duration: float, dt: float) -> int:
    """Ticks that fill a duration in [s]; the margin forgives 0.1 / 0.002 being above 50."""
    return max(1, ceil(duration / dt - 1e-6))


@njit
def ended(rule: np.ndarray, memory: np.ndarray, trunk: np.ndarray, touches: bool) -> int:
    """Whether a trial ends with this tick, and why; advances the memory.

    Causes of a fall that come true at the same tick rank tilt, body contact, low trunk.

    Args:
        rule: As of `Ending`.
        memory: Likewise, changed in place.
        trunk: Trunk link frame, position in [m] and xyzw; a row of the tape begins so.
            Shape (7,) or more.
        touches: Whether the ground pushes on a link other than a foot.

    Returns:
        GOES_ON, the log's code of a fall, ARRIVED or LOST.
    """
    tilt_ticks, contact_ticks, lowest, startup, distance = rule[:5]
    x, y, z, qx, qy, qz, qw = trunk[:7]
    memory[_TICKS] += 1.0
    if not isfinite(x + y + z + qx + qy + qz + qw):
        return LOST
    upright = 1.0 - 2.0 * (qx * qx + qy * qy)
    memory[_TILTED] = memory[_TILTED] + 1.0 if upright < UPRIGHT_LIMIT else 0.0
    memory[_TOUCHING] = memory[_TOUCHING] + 1.0 if touches else 0.0
    if memory[_TILTED] >= tilt_ticks:
        return TILT
    if memory[_TOUCHING] >= contact_ticks:
        return BODY_CONTACT
    if z < lowest:
        return LOW_TRUNK
    if memory[_TICKS] <= startup:
        c, s = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy + qz * qw)
        length = hypot(c, s)
        memory[_X], memory[_Y], memory[_COS], memory[_SIN] = x, y, c / length, s / length
        return GOES_ON
    dx, dy, c, s = x - memory[_X], y - memory[_Y], memory[_COS], memory[_SIN]
    memory[_GONE] = gone(rule[5:], dx * c + dy * s, dy * c - dx * s, memory[_GONE])
    return ARRIVED if abs(memory[_GONE]) >= distance else GOES_ON


@njit
def gone(way: np.ndarray, x: float, y: float, before: float) -> float:
    """Distance along the way of one point, as `Course.of` has it for many, in [m].

    Args:
        way: Cosine and sine of the direction it begins in, and its radius. Shape (3,).
        x: How far ahead of where the walk began, in [m].
        y: How far to the left, in [m].
        before: The distance a tick ago: on an arc the one nearest to it is meant.
    """
    c, s, radius = way
    along = c * x + s * y
    if radius == 0.0:
        return along
    left = np.sign(radius) * (c * y - s * x)
    radius = abs(radius)
    found = radius * atan2(along, radius - left)
    whole = 2.0 * pi * radius
    return found + whole * np.round((before - found) / whole)
