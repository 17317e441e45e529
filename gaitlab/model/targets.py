"""Joint targets of a robot: its legs put the feet where the gait has them, all else is held.

Joint positions that a limb cannot take are refused, by its name and the first instant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.transforms import axis_rotation, homogeneous, turned
from gaitlab.model.gait import FeetPoses, changes
from gaitlab.model.link_table import SIDES, turns_about_y
from gaitlab.model.tree import Joint
from gaitlab.parameters import parameter

ROUNDING = 1e-9  # rad, the only angle by which a joint limit is forgiven


class SixJointLeg(Protocol):
    """Kinematics of a leg that takes any pose: three joints in the hip, the knee, two ankles."""

    def pose_joints(self, pose: np.ndarray) -> np.ndarray:
        """Joints of the sole's pose, the ankle's pitch last but one, in [rad]. (n, 4, 4), (n, 6).

        Raises:
            Infeasible: Names the first pose that is out of reach.
        """


def both_legs(leg: Callable[[int], np.ndarray], held: Sequence[float]) -> np.ndarray:
    """Targets of the left leg, the right leg and all other joints, in [rad]. Shape (n, joints).

    Args:
        leg: Targets of leg 0, left, or 1, right. Shape (n, joints of the leg).
        held: Positions of the joints that the gait does not move.

    Raises:
        Infeasible: Of both legs the one that fails first.
    """
    found, problems = [], []
    for index in (0, 1):
        try:
            found.append(leg(index))
        except Infeasible as problem:
            problems.append(problem)
    if problems:
        raise min(problems, key=lambda problem: problem.tick)
    return np.concatenate([*found, np.tile(held, (len(found[0]), 1))], axis=1)


def angle(default: float, *, low: float, high: float, doc: str) -> Any:
    """A field of a posture, in [rad], which is chosen and not published."""
    return parameter(default, unit="rad", low=low, high=high, doc=doc, source="assumption")


def held(posture: object, joints: Sequence[Joint]) -> list[float]:
    """Positions in which a posture has joints, in [rad]; those that it does not name are at 0.

    A posture has fields that are named as joints are, without a side. They are the left joint's;
    the right one mirrors it, unless both turn about y.
    """
    return [_held(posture, joint) for joint in joints]


def _held(posture: object, joint: Joint) -> float:
    side, _, name = joint.name.partition("_")
    position: float | None = getattr(posture, name if side in SIDES else joint.name, None)
    if position is None:
        return 0.0
    return -position if side == "right" and not turns_about_y(joint.axis) else position


def six_joint_targets(
    leg: SixJointLeg, joints: Sequence[Joint], feet: FeetPoses, index: int, origin: np.ndarray
) -> np.ndarray:
    """Positions of a leg of six joints that give a sole its place, in [rad]. Shape (n, 6).

    The first instant out of reach or beyond a limit is refused.

    Args:
        leg: Its kinematics.
        joints: Its joints.
        feet: What the gait has the feet do.
        index: 0 for the left leg, 1 for the right one.
        origin: Of the frame of the leg's poses in the hip frame, in [m]. Shape (3,).

    Raises:
        Infeasible: If the sole is out of reach or a joint beyond its limit.
    """
    changed = changes(feet.position[:, index], feet.heading[:, index], feet.trunk_pitch)
    few = changed.first
    lean = axis_rotation("y", -feet.trunk_pitch[few])
    level = turned(lean, "z", feet.heading[few, index])
    pose = homogeneous(level, feet.position[few, index] - origin)
    limb = f"{SIDES[index]}_leg"
    try:
        found = leg.pose_joints(pose)[changed.of]
    except Infeasible as problem:
        tick = int(few[problem.tick])
        require_limits(limb, joints, leg.pose_joints(pose[: problem.tick])[changed.of[:tick]])
        raise Infeasible(limb=problem.limb, tick=tick, reason=problem.reason) from problem
    require_limits(limb, joints, found)
    return with_ankle(found, joints, feet, index)


def with_ankle(
    position: np.ndarray, joints: Sequence[Joint], feet: FeetPoses, index: int
) -> np.ndarray:
    """Positions of a leg whose level sole a gait pitches: what it adds gives way to the limit.

    Args:
        position: Of a leg that ends in hip pitch, knee, ankle pitch and ankle roll, with a level
            sole and within the limits, in [rad]. Shape (n, k).
        joints: Its joints.
        feet: What the gait has the feet do.
        index: 0 for the left leg, 1 for the right one.
    """
    added = feet.knee_only[:, index] * position[:, -4] + feet.ankle_pitch[:, index]
    ankle = joints[-2]
    turned = np.clip(position[:, -2] + added, ankle.lower, ankle.upper)
    return np.column_stack([position[:, :-2], turned, position[:, -1]])


def require_limits(limb: str, joints: Sequence[Joint], position: np.ndarray) -> None:
    """Refuse joint positions beyond their limits.

    Args:
        limb: Name for the message, `left_leg` for instance.
        joints: Joints of the limb.
        position: In [rad]. Shape (n, joints of the limb).

    Raises:
        Infeasible: Names the first such instant, its joint, the angle found and those allowed.
    """
    low = np.array([joint.lower for joint in joints]) - ROUNDING
    high = np.array([joint.upper for joint in joints]) + ROUNDING
    within = (position >= low) & (position <= high)
    if within.all():
        return
    tick, index = (int(i) for i in np.argwhere(~within)[0])
    joint = joints[index]
    reason = (
        f"{joint.name} would have to turn to {_angles(position[tick, index])}, its limits are "
        f"{_angles(joint.lower, joint.upper)}; shorten step_length or step_height, or change "
        "hip_height"
    )
    raise Infeasible(limb=limb, tick=tick, reason=reason)


def _angles(*angles: float) -> str:
    in_radians = " and ".join(f"{angle:.3f}" for angle in angles)
    in_degrees = " and ".join(f"{angle:.1f}" for angle in np.degrees(angles))
    return f"{in_radians} rad ({in_degrees} degrees)"
