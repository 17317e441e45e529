"""A leg of two parallelograms in series, and the serial leg that moves its foot alike.

The first parallelogram carries a plate at the knee parallel to the pelvis, the second the ankle
parallel to that plate, so that the foot keeps the pelvis' pitch. What is left to choose are yaw,
roll, the absolute angles of thigh and shank, and the ankle's roll. [Yanto] prints
q5 = q3 + q4 (37): wrong for an ankle at the end of a serial chain, it is the shank's absolute
angle, which is what a motor of a parallelogram turns. A reconstruction, verified by identities.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from math import pi

import numpy as np

from gaitlab.kinematics.dh import DHRow, chain_pose
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.kinematics.transforms import axis_rotation, homogeneous


def serial_joints(parallelogram: np.ndarray) -> np.ndarray:
    """Yaw, roll, hip pitch, knee, ankle pitch, ankle roll of a leg of parallelograms.

    Args:
        parallelogram: Yaw, roll, thigh, shank and ankle roll; thigh and shank are absolute pitch
            angles from the pelvis, in [rad]. Shape (..., 5).
    """
    yaw, roll, thigh, shank, ankle_roll = np.moveaxis(parallelogram, -1, 0)
    return np.stack([yaw, roll, thigh, shank - thigh, -shank, ankle_roll], axis=-1)


def parallelogram_joints(serial: np.ndarray) -> np.ndarray:
    """Inverse of `serial_joints` for a sole parallel to the pelvis. (..., 6) to (..., 5)."""
    yaw, roll, hip_pitch, knee, _, ankle_roll = np.moveaxis(serial, -1, 0)
    return np.stack([yaw, roll, hip_pitch, hip_pitch + knee, ankle_roll], axis=-1)


def plate_joints(parallelogram: np.ndarray) -> np.ndarray:
    """Joints of the chain with the knee plate as a link of its own, derived here.

    Returns:
        Yaw, roll, hip pitch, knee plate, shank, ankle plate, ankle roll, in [rad]; each plate
        turns back by the angle of the link above it. Shape (..., 7).
    """
    yaw, roll, thigh, shank, ankle_roll = np.moveaxis(parallelogram, -1, 0)
    return np.stack([yaw, roll, thigh, -thigh, shank, -shank, ankle_roll], axis=-1)


def sole_pose(leg: Leg, parallelogram: np.ndarray) -> np.ndarray:
    """Pose of the sole from the parallelograms alone, without the serial chain; derived here.

    Args:
        leg: Lengths and side; its yaw axis goes through the hip.
        parallelogram: As in `serial_joints`. Shape (..., 5).

    Returns:
        Homogeneous transform, positions in [m]. Shape (..., 4, 4).
    """
    yaw, roll, thigh, shank, ankle_roll = np.moveaxis(parallelogram, -1, 0)
    upper, lower = leg.geometry.thigh, leg.geometry.shank
    pelvis = axis_rotation("z", yaw) @ axis_rotation("x", roll)
    x = -upper * np.sin(thigh) - lower * np.sin(shank)
    z = -upper * np.cos(thigh) - lower * np.cos(shank)
    ankle = leg.hip + np.einsum(
        "...ij,...j->...i", pelvis, np.stack([x, np.zeros_like(x), z], axis=-1)
    )
    foot = pelvis @ axis_rotation("x", ankle_roll)
    return homogeneous(foot, ankle - leg.ankle_height * foot[..., 2])


def dh_sole_pose(leg: Leg, joints: np.ndarray) -> np.ndarray:
    """Pose of the sole by six Denavit-Hartenberg rows, the form [Yanto] eq. (20) announces.

    Args:
        leg: Lengths and side; its yaw axis goes through the hip.
        joints: Yaw, roll, hip pitch, knee, ankle pitch, ankle roll, in [rad]. Shape (..., 6).

    Returns:
        Homogeneous transform, positions in [m]. Shape (..., 4, 4).
    """
    turn, geometry = pi / 2.0, leg.geometry
    rows = (
        DHRow(turn, -geometry.hip_drop, 0.0, turn),
        DHRow(-turn, 0.0, 0.0, -turn),
        DHRow(0.0, 0.0, geometry.thigh, 0.0),
        DHRow(0.0, 0.0, geometry.shank, 0.0),
        DHRow(0.0, 0.0, 0.0, turn),
        DHRow(0.0, 0.0, leg.ankle_height, 0.0),
    )
    pose = np.array(chain_pose(rows, joints))
    pose[..., 1, 3] += leg.hip[1]
    pose[..., :3, :3] = pose[..., :3, [2, 1, 0]] * [1.0, 1.0, -1.0]  # x is the last z, z is -x
    return pose
