"""Where the feet of a robot are in joint positions: what inverse kinematics would be asked for."""

from __future__ import annotations

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.model.gait import FeetPoses
from gaitlab.model.robot import Robot
from gaitlab.model.stance import stance_of, standing_feet
from gaitlab.model.tree import LinkPoses

LIFTED = 0.001  # m; a sole that is higher than the lower one by more is meant to be in the air
DIGITS = 12  # after the point, of lengths and angles; what is behind them is rounding


def feet_of_joints(robot: Robot, joints: np.ndarray) -> FeetPoses:
    """Foot poses of a robot whose joints are all set, and the joints themselves.

    The lower sole stands level, so the trunk leans as that leg holds it. A foot is in swing while
    its sole's centre is higher than the other's. There is no phase: the joints do not tell it.

    Args:
        robot: The robot.
        joints: Positions of all joints in the order of its tree, in [rad]. Shape (n, joints).
    """
    n, poses = len(joints), _poses(robot, joints)
    links = [robot.tree.index(name) for name in robot.feet]
    rotation = poses.rotation[:, links]
    centres = np.array([robot.sole.centre_of(foot) for foot in range(2)])
    soles = poses.position[:, links] + np.einsum("nfij,fj->nfi", rotation, centres)
    # Of two soles the one that stands is found along the mean of their normals.
    height = np.einsum("ni,nfi->nf", rotation[..., 2].mean(axis=1), soles)
    up = rotation[np.arange(n), height.argmin(axis=1), :, 2]
    both = np.abs(height[:, 0] - height[:, 1]) <= LIFTED
    up[both] = rotation[both][..., 2].mean(axis=1)
    height = np.einsum("ni,nfi->nf", up, soles)
    level = np.zeros((n, 2))
    return FeetPoses(
        position=np.round(_below_ankles(robot, poses) + _from_hips(robot), DIGITS) + 0.0,
        heading=np.round(np.arctan2(rotation[..., 1, 0], rotation[..., 0, 0]), DIGITS) + 0.0,
        trunk_pitch=np.round(np.arctan2(-up[:, 0], up[:, 2]), DIGITS) + 0.0,
        ankle_pitch=level,
        knee_only=level,
        swing=height > height.min(axis=1, keepdims=True) + LIFTED,
        phase=np.full(n, np.nan),
        step_index=np.full(n, -1),
        joints={joint.name: joints[:, k] for k, joint in enumerate(robot.tree.joints)},
    )


def standing_joints(robot: Robot) -> np.ndarray:
    """Joint positions in which a robot stands on both soles, knees bent, in [rad]. Shape (joints,).

    Raises:
        Infeasible: If it cannot.
    """
    stance = stance_of(robot)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    return robot.joint_targets(feet)[0]


def _poses(robot: Robot, joints: np.ndarray) -> LinkPoses:
    n = len(joints)
    return robot.tree.poses(np.zeros((n, 3)), np.broadcast_to(np.eye(3), (n, 3, 3)), joints)


def _below_ankles(robot: Robot, poses: LinkPoses) -> np.ndarray:
    """Points of the soles below the ankles in the trunk's frame, in [m]. Shape (n, 2, 3)."""
    links = [robot.tree.index(name) for name in robot.feet]
    return poses.position[:, links] - robot.sole.height * poses.rotation[:, links][..., 2]


def _from_hips(robot: Robot) -> np.ndarray:
    """The trunk's frame in the hip frame, in [m], as the robot's inverse kinematics has it."""
    try:
        stance = stance_of(robot)
        feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
        poses = _poses(robot, robot.joint_targets(feet))
    except Infeasible:
        return np.array([0.0, 0.0, robot.hip_offset()])
    offset = (feet.position - _below_ankles(robot, poses))[0].mean(axis=0)
    return np.asarray(np.round(offset, DIGITS))
