"""Standard Denavit-Hartenberg chains, batched over leading axes.

A row turns and shifts along the old z, then shifts and turns along the new x, the distal form of
[Yanto] eq. (1), which is right as printed. Its columns are n, o, a, P in that order.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class DHRow(NamedTuple):
    """One joint of a chain.

    Attributes:
        offset: Added to the joint angle, in [rad].
        d: Shift along the old z, in [m].
        a: Shift along the new x, in [m].
        alpha: Turn about the new x, in [rad].
    """

    offset: float
    d: float
    a: float
    alpha: float


def dh_transform(theta: np.ndarray, d: float, a: float, alpha: float) -> np.ndarray:
    """Transform of one joint, [Yanto] eq. (1): Rz(theta) Tz(d) Tx(a) Rx(alpha).

    Args:
        theta: Joint angle, in [rad]. Shape (...).
        d: Shift along the old z, in [m].
        a: Shift along the new x, in [m].
        alpha: Turn about the new x, in [rad].

    Returns:
        Homogeneous transform. Shape (..., 4, 4).
    """
    c, s = np.cos(theta), np.sin(theta)
    ca, sa = np.cos(alpha), np.sin(alpha)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [
        [c, -ca * s, sa * s, a * c],
        [s, ca * c, -sa * c, a * s],
        [zero, sa * one, ca * one, d * one],
        [zero, zero, zero, one],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def chain_pose(rows: Sequence[DHRow], joints: np.ndarray) -> np.ndarray:
    """Pose of the last frame of a chain in the first.

    Args:
        rows: One a joint.
        joints: In [rad]. Shape (..., joints).

    Returns:
        Homogeneous transform. Shape (..., 4, 4).
    """
    joints = np.asarray(joints, dtype=float)
    pose = np.broadcast_to(np.eye(4), (*joints.shape[:-1], 4, 4))
    for row, angle in zip(rows, np.moveaxis(joints, -1, 0), strict=True):
        pose = pose @ dh_transform(angle + row.offset, row.d, row.a, row.alpha)
    return pose
