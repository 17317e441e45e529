"""A limb that can be asked where it ends and how to get somewhere.

A robot that answers `gaitlab ik` and `gaitlab fk` has a method `limbs()`, which gives its limbs by
name: `left_leg`, `right_leg`, `left_arm`, `right_arm`, `head`, as far as it has them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.model import ROUNDING, Joint


@dataclass(frozen=True, kw_only=True, eq=False)
class Limb:
    """A chain of joints with its kinematics in closed form.

    Attributes:
        name: Name of the limb.
        joints: Joints in the order of the chain.
        target: What is put at the target, and in which frame, in words.
        forward: End pose of joint positions in [rad], (k,) to (4, 4), positions in [m].
        inverse: Joint positions of a target in [m] and a heading in [rad], (3,) to (b, k): every
            branch there is, the usual one first. Raises Infeasible when out of reach.
        turns: Whether a heading can be asked for.
        counts: Servo counts of joint positions in [rad], (k,) to (k,); None when they are unknown.
    """

    name: str
    joints: tuple[Joint, ...]
    target: str
    forward: Callable[[np.ndarray], np.ndarray]
    inverse: Callable[[np.ndarray, float], np.ndarray]
    turns: bool = True
    counts: Callable[[np.ndarray], np.ndarray] | None = None


@runtime_checkable
class Limbed(Protocol):
    """A robot whose limbs can be asked."""

    def limbs(self) -> Mapping[str, Limb]:
        """Limbs by name."""


class Branch(NamedTuple):
    """One way to take a pose.

    Attributes:
        joints: Joint positions, in [rad]. Shape (k,).
        beyond: What stands in the way, one sentence a joint beyond its limits; mostly empty.
    """

    joints: np.ndarray
    beyond: tuple[str, ...]


def end_pose(limb: Limb, joints: Sequence[float]) -> np.ndarray:
    """Pose of the end of a limb, positions in [m]. Shape (4, 4).

    Args:
        limb: The limb.
        joints: Joint positions in the order of the chain, in [rad].

    Raises:
        WrongValue: If there are too few or too many, if one is no finite number or beyond its
            limits.
    """
    names = ", ".join(joint.name for joint in limb.joints)
    position = _vector("joints", joints, len(limb.joints), f"in [rad], in the order {names}")
    beyond = beyond_limits(limb.joints, position)
    if beyond:
        raise WrongValue(f"{limb.name}: {'; '.join(beyond)}")
    return limb.forward(position)


def branches(limb: Limb, target: Sequence[float], heading: float = 0.0) -> list[Branch]:
    """Every way to reach a target; those within the joint limits come first.

    Args:
        limb: The limb.
        target: Where its end shall be, in [m], in the frame that `limb.target` names.
        heading: Yaw of its end, in [rad].

    Raises:
        WrongValue: If the target is no point, or is out of reach.
    """
    point = _vector("target", target, 3, f"X Y Z in [m]: {limb.target}")
    (angle,) = _vector("heading", [heading], 1, "in [rad]")
    if angle != 0.0 and not limb.turns:
        raise WrongValue(f"{limb.name}: found heading {angle:g}; this limb's end has none, leave 0")
    try:
        found = limb.inverse(point, float(angle))
    except Infeasible as problem:
        fact, _, _ = problem.reason.partition(";")  # what follows is advice for a gait
        raise WrongValue(
            f"{limb.name}: {fact}; move the target [{', '.join(f'{x:g}' for x in point)}] m"
        ) from problem
    ways = [Branch(joints, beyond_limits(limb.joints, joints)) for joints in found]
    return sorted(ways, key=lambda way: bool(way.beyond))


def beyond_limits(joints: Sequence[Joint], position: np.ndarray) -> tuple[str, ...]:
    """One sentence for each joint beyond its limits. Positions in [rad], shape (k,)."""
    return tuple(
        f"{joint.name} is {_angle(angle)}, its limits are {_angle(joint.lower)} to "
        f"{_angle(joint.upper)}"
        for joint, angle in zip(joints, position, strict=True)
        if not joint.lower - ROUNDING <= angle <= joint.upper + ROUNDING
    )


def _angle(angle: float) -> str:
    return f"{angle:.4f} rad ({np.degrees(angle):.1f} degrees)"


def _vector(name: str, values: Sequence[float], length: int, wanted: str) -> np.ndarray:
    if len(values) != length:
        raise WrongValue(f"{name}: found {len(values)} numbers, expected {length}, {wanted}")
    vector = np.array(values, dtype=float)
    if not np.all(np.isfinite(vector)):
        raise WrongValue(f"{name}: found {list(values)}; every number must be finite, {wanted}")
    return vector


def leg_limb(leg: Leg, joints: Sequence[Joint], origin: str) -> Limb:
    """A leg of six joints; the sole is level and turned by the heading.

    Args:
        leg: Its kinematics.
        joints: Its joints, hip yaw first.
        origin: What the frame of its poses is fixed to, in words.
    """
    return Limb(
        name=f"{leg.side}_leg",
        joints=tuple(joints),
        target=f"the point of the level sole below the ankle, in the frame of {origin}",
        forward=leg.sole_pose,
        inverse=lambda target, heading: leg.flat_branches(target, np.array(heading)),
    )


def point_limb(
    name: str,
    joints: Sequence[Joint],
    target: str,
    *,
    forward: Callable[[np.ndarray], np.ndarray],
    inverse: Callable[[np.ndarray], np.ndarray],
    counts: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Limb:
    """A limb whose end has no heading of its own: its target is a point. As `Limb` has them."""
    return Limb(
        name=name,
        joints=tuple(joints),
        target=target,
        forward=forward,
        inverse=lambda point, _heading: inverse(point),
        turns=False,
        counts=counts,
    )


def head_limb(
    pose: Callable[[np.ndarray], np.ndarray],
    pointing: Callable[[np.ndarray], np.ndarray],
    joints: Sequence[Joint],
) -> Limb:
    """A pan-tilt head that turns its axis through the target.

    Args:
        pose: Pose of the eyes from pan and tilt.
        pointing: Pan and tilt >= 0 that look at a point.
        joints: Pan and tilt.
    """

    def inverse(point: np.ndarray) -> np.ndarray:
        pan, tilt = pointing(point)
        other = pan - np.pi if pan > 0.0 else pan + np.pi
        return np.array([[pan, tilt], [other, -tilt]])

    target = "a point that the axis of the head goes through, in the frame of the neck's base"
    return point_limb("head", joints, target, forward=pose, inverse=inverse)
