"""A limb that can be asked where it ends and how to get somewhere.

A robot that answers `gaitlab ik` and `gaitlab fk` has a method `limbs()`, which gives its limbs by
name: `left_leg`, `right_leg`, `left_arm`, `right_arm`, `head`, as far as it has them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.kinematics.arm import ArmLengths, hand_branches, hand_pose
from gaitlab.kinematics.dh import DhArm
from gaitlab.kinematics.dynamixel import servo_counts
from gaitlab.kinematics.planar_leg import (
    LegAngles,
    angles_of,
    ankle_position,
    joints_of,
    leg_angles,
)
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model import ROUNDING, Joint

Side = Literal["left", "right"]


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


def arm_limb(arm: DhArm, joints: Sequence[Joint]) -> Limb:
    """An arm of five to seven joints; the elbow hangs as low as it can, the wrist is straight."""
    count = len(joints)

    def forward(position: np.ndarray) -> np.ndarray:
        return arm.pose(np.pad(position, (0, len(arm.rows) - count)))

    def inverse(target: np.ndarray, heading: float) -> np.ndarray:
        del heading  # A tip has none.
        return arm.point_joints(target)[:, :count]

    return Limb(
        name=arm.name,
        joints=tuple(joints),
        target="the tip of the arm, in the frame of the shoulder",
        forward=forward,
        inverse=inverse,
        turns=False,
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

    def inverse(target: np.ndarray, heading: float) -> np.ndarray:
        del heading  # A head of two joints has none.
        pan, tilt = pointing(target)
        other = pan - np.pi if pan > 0.0 else pan + np.pi
        return np.array([[pan, tilt], [other, -tilt]])

    return Limb(
        name="head",
        joints=tuple(joints),
        target="a point that the axis of the head goes through, in the frame of the neck's base",
        forward=pose,
        inverse=inverse,
        turns=False,
    )


def short_arm_limb(geometry: ArmLengths, joints: Sequence[Joint], side: Side) -> Limb:
    """An arm of three joints."""

    def inverse(target: np.ndarray, heading: float) -> np.ndarray:
        del heading  # A hand of three joints has none.
        found = hand_branches(geometry, target, side)
        return found[np.isfinite(found).all(axis=-1)]

    return Limb(
        name=f"{side}_arm",
        joints=tuple(joints),
        target="the hand, in the frame of the arms' origin",
        forward=lambda position: hand_pose(geometry, position, side),
        inverse=inverse,
        turns=False,
    )


def planar_leg_limb(
    geometry: LegLengths, joints: Sequence[Joint], side: Side, directions: np.ndarray
) -> Limb:
    """A leg without hip yaw, its target as the Bioloid paper has it; the sole is level.

    Args:
        geometry: Lengths of the leg.
        joints: Hip roll, hip pitch, knee, ankle pitch, ankle roll.
        side: Which leg.
        directions: 1 or -1, how each AX-12 is mounted. Shape (5,).
    """
    thigh, shank = geometry.thigh, geometry.shank
    turned = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])

    def forward(position: np.ndarray) -> np.ndarray:
        ankle = ankle_position(angles_of(position), thigh=thigh, shank=shank, coupling="spatial")
        roll, *pitches, ankle_roll = position
        sole = axis_rotation("x", roll) @ axis_rotation("y", sum(pitches))
        return homogeneous(turned @ sole @ axis_rotation("x", ankle_roll) @ turned, ankle)

    def inverse(target: np.ndarray, heading: float) -> np.ndarray:
        del heading  # A leg without hip yaw has none.
        found = leg_angles(
            target,
            thigh=thigh,
            shank=shank,
            coupling="spatial",
            ankle_law="flat",
            limb=f"{side}_leg",
        )
        folded = 2.0 * np.arctan2(target[0], np.hypot(target[1], target[2])) - found.alpha
        beta = -found.beta
        backwards = LegAngles(folded, beta, beta - folded, found.theta, found.omega)
        return np.stack([joints_of(found), joints_of(backwards)])

    return Limb(
        name=f"{side}_leg",
        joints=tuple(joints),
        target="the ankle's pitch axis from the hip's: x forward, y down, z to the robot's right",
        forward=forward,
        inverse=inverse,
        turns=False,
        counts=lambda position: servo_counts(position, directions),
    )
