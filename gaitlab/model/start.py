"""How a robot stands before its first command: in a given pose, on level soles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.transforms import axis_rotation, quaternion_of
from gaitlab.model.robot import Robot


class Start(NamedTuple):
    """Where a robot starts.

    Attributes:
        joints: Positions of all joints, in [rad]. Shape (joints,).
        position: Trunk link frame, world frame, in [m]. Shape (3,).
        quaternion: Its orientation, xyzw. Shape (4,).
        targets: What the servos were sent before, in [rad]. Shape (joints,).
    """

    joints: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    targets: np.ndarray


def standing(robot: Robot, joints: np.ndarray, *, gap: float) -> Start:
    """A robot on level soles; its trunk leans as its joints say, and does not turn.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
        gap: Height of the soles over the base, in [m]; of the lower one should they differ.
    """
    at, here = np.array(joints, dtype=float), np.zeros((1, 3))
    feet = [robot.tree.index(foot) for foot in robot.feet]
    level = robot.tree.poses(here, np.eye(3)[None], at[None])
    upright = _levelling(level.rotation[0, feet, :, 2].mean(axis=0))
    soles = [
        level.position[0, k] + level.rotation[0, k] @ np.array(robot.sole.centre_of(side))
        for side, k in enumerate(feet)
    ]
    lowest = min(float(upright[2] @ sole) for sole in soles)
    return Start(at, np.array([0.0, 0.0, gap - lowest]), quaternion_of(upright), at)


def _levelling(normal: np.ndarray) -> np.ndarray:
    """The rotation without yaw that turns a direction upright. Shape (3, 3)."""
    x, y, z = normal
    roll = np.arctan2(y, z)
    return axis_rotation("y", -np.arctan2(x, np.hypot(y, z))) @ axis_rotation("x", roll)
