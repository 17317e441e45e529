"""What a gait says: where the feet shall be, as arrays over time.

References:
    REP-103: Standard Units of Measure and Coordinate Conventions, ROS Enhancement Proposal.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import NamedTuple, Protocol

import numpy as np

from gaitlab.errors import WrongValue

SHAPES: dict[str, tuple[int, ...]] = {  # of the arrays of FeetPoses, after the instants
    "position": (2, 3),
    "heading": (2,),
    "trunk_pitch": (),
    "ankle_pitch": (2,),
    "knee_only": (2,),
    "swing": (2,),
    "phase": (),
    "step_index": (),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class FeetPoses:
    """Commanded foot poses over n instants; feet are ordered left, right.

    The hip frame has its origin midway between the hip axes and is fixed to the trunk: x forward,
    y left, z up [REP-103].

    Attributes:
        position: Point of the sole below the ankle, in the hip frame, in [m]. Shape (n, 2, 3).
        heading: Yaw of the foot in the hip frame, in [rad]. Shape (n, 2).
        trunk_pitch: Forward lean of the trunk that the legs hold, in [rad]. Shape (n,).
        ankle_pitch: Added to the ankle pitch joint after inverse kinematics has made the sole
            level, positive is toe down, in [rad]. Shape (n, 2).
        knee_only: Share in [0, 1] of the hip pitch that is left out when the ankle is made level:
            the ankle pitch becomes -(knee + (1 - knee_only) hip_pitch). Shape (n, 2).
        swing: True where the gait means the foot to be in the air. Shape (n, 2).
        phase: Gait phase in [0, 1), NaN before full-amplitude walking starts. Shape (n,).
        step_index: Footsteps begun since full-amplitude walking started, -1 before. Shape (n,).
        joints: Joints that the gait sets itself, by name, whatever inverse kinematics gives for
            them, in [rad]. Shape (n,) each.
    """

    position: np.ndarray
    heading: np.ndarray
    trunk_pitch: np.ndarray
    ankle_pitch: np.ndarray
    knee_only: np.ndarray
    swing: np.ndarray
    phase: np.ndarray
    step_index: np.ndarray
    joints: Mapping[str, np.ndarray] = field(default_factory=dict)

    def at(self, index: int) -> FeetPoses:
        """The poses of one instant, as poses over one instant."""
        one = {name: getattr(self, name)[index : index + 1] for name in SHAPES}
        joints = {name: angles[index : index + 1] for name, angles in self.joints.items()}
        return FeetPoses(**one, joints=joints)

    def moved(self, by: np.ndarray) -> FeetPoses:
        """The same with both feet moved in the hip frame, in [m]. Shape (3,)."""
        return replace(self, position=self.position + by)


def first_step(feet: FeetPoses) -> float:
    """Index of the first commanded step; infinite if there is none.

    A step begins where a foot is first meant to be in the air. A motion that never means a foot to
    be, a dance on both feet for instance, begins where anything that it commands first changes.
    """
    begun: np.ndarray = np.any(feet.swing, axis=1)
    if not begun.any():
        parts = (feet.position, feet.heading, feet.trunk_pitch, feet.ankle_pitch, feet.knee_only)
        for part in (*parts, *feet.joints.values()):
            begun = begun | (part != part[:1]).reshape(len(begun), -1).any(axis=1)
    return float(np.argmax(begun)) if begun.any() else inf


class Changes(NamedTuple):
    """Instants at which something is no longer what it was: between them, commands are held.

    Attributes:
        first: The instants; 0 is the first of them. Shape (m,).
        of: Of each instant, which of those it repeats. Shape (n,).
    """

    first: np.ndarray
    of: np.ndarray


def changes(*parts: np.ndarray) -> Changes:
    """When any of some arrays over n instants changes. Shape (n, ...) each."""
    new = np.ones(len(parts[0]), dtype=bool)
    new[1:] = False
    for part in parts:
        differ = part[1:] != part[:-1]
        new[1:] |= differ.any(axis=tuple(range(1, differ.ndim)))
    return Changes(np.flatnonzero(new), np.cumsum(new) - 1)


class Gait(Protocol):
    """A gait: a frozen dataclass called `Gait` in a file of its own in `gaitlab/gaits`."""

    @property
    def step_length(self) -> float:
        """Forward distance between the feet in double support, in [m]; negative walks backwards.

        A gait that goes sideways or turns has `side_step` to the left, in [m], and `turn` to the
        left, in [rad], of each step as well.
        """

    @property
    def hip_height(self) -> float:
        """Height of the hip axes above the soles when standing, in [m]."""

    @property
    def gait_period(self) -> float:
        """Duration of a full cycle of two steps, in [s]."""

    @property
    def startup_time(self) -> float:
        """Instant at which full-amplitude walking starts, in [s]; before it nothing is measured."""

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0. Shape (n,)."""


def require_walk(gait: Gait) -> None:
    """Refuse a gait whose lengths and durations make no walk.

    Raises:
        WrongValue: Names the first that is no finite number, or a duration out of range.
    """
    for name in ("step_length", "hip_height", "gait_period", "startup_time"):
        value = getattr(gait, name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise WrongValue(f"the gait's {name} is {value!r}; a finite number is expected")
    if gait.gait_period <= 0.0 or gait.startup_time < 0.0:
        raise WrongValue(
            f"the gait's gait_period is {gait.gait_period:g} s and its startup_time "
            f"{gait.startup_time:g} s; more than 0 and at least 0 are expected"
        )


def require_feet(feet: object, count: int) -> None:
    """Refuse what a gait's `feet` gave unless it is poses for so many instants.

    Raises:
        WrongValue: Names the first array of another shape, or with a value that is not finite.
    """
    if not isinstance(feet, FeetPoses):
        raise WrongValue(f"the gait's feet(t) gave {type(feet).__name__}; FeetPoses is expected")
    arrays = {name: (getattr(feet, name), (count, *rest)) for name, rest in SHAPES.items()}
    joints = {f"joints[{name!r}]": (array, (count,)) for name, array in feet.joints.items()}
    for name, (array, shape) in {**arrays, **joints}.items():
        if np.shape(array) != shape:
            raise WrongValue(
                f"the gait's feet(t) gave {name} of shape {np.shape(array)} for {count} instants; "
                f"{shape} is expected"
            )
        if name != "phase" and not np.isfinite(array).all():
            tick = np.argwhere(~np.isfinite(array))[0][0]
            raise WrongValue(f"the gait's feet(t) gave a {name} at tick {tick} that is nan")
