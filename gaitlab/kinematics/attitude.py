"""Attitude of a body: quaternions, rotation matrices and the three angles of REP-103, batched.

References:
    REP-103: Standard Units of Measure and Coordinate Conventions, ROS Enhancement Proposal.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def rotation_from_quaternion(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions xyzw. Shapes (n, 4) to (n, 3, 3)."""
    return Rotation.from_quat(quaternion).as_matrix()


def quaternion_from_rotation(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternions xyzw with w >= 0 of rotation matrices. Shapes (n, 3, 3) to (n, 4)."""
    return Rotation.from_matrix(rotation).as_quat(canonical=True)


def roll_pitch_yaw(rotation: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll), in [rad]. Shapes (n, 3, 3) to (n, 3).

    Pitch is positive nose down, roll positive to the right [REP-103].
    """
    pitch = np.arctan2(-rotation[:, 2, 0], np.hypot(rotation[:, 0, 0], rotation[:, 1, 0]))
    roll = np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2])
    yaw = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    return np.stack([roll, pitch, yaw], axis=-1)
