"""Rotations and homogeneous transforms, batched over leading axes."""

from __future__ import annotations

import numpy as np


def axis_rotation(axis: str, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices about a coordinate axis by angles in [rad]. Shape (..., 3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((*np.shape(angle), 3, 3))
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix[..., i, i] = 1.0
    matrix[..., j, j] = matrix[..., k, k] = c
    matrix[..., j, k], matrix[..., k, j] = -s, s
    return matrix


def turned(rotation: np.ndarray, axis: str, angle: np.ndarray) -> np.ndarray:
    """Rotations followed by turns about a coordinate axis, which mix two columns of theirs.

    Args:
        rotation: Rotation matrices. Shape (..., 3, 3).
        axis: Of the turns, in the frame that was rotated.
        angle: In [rad]. Shape (...).
    """
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    out = np.empty_like(rotation)
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    out[..., i] = rotation[..., i]
    out[..., j] = c * rotation[..., j] + s * rotation[..., k]
    out[..., k] = c * rotation[..., k] - s * rotation[..., j]
    return out


def vector_rotation(axis: tuple[float, float, float], angle: np.ndarray) -> np.ndarray:
    """Rotation matrices about a unit vector by angles in [rad], Rodrigues. Shape (..., 3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    c, s = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    return c * np.eye(3) + s * cross + (1.0 - c) * np.outer(axis, axis)


def homogeneous(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Homogeneous transforms of rotations (..., 3, 3) and positions (..., 3). Shape (..., 4, 4)."""
    matrix = np.zeros((*np.shape(position)[:-1], 4, 4))
    matrix[..., :3, :3], matrix[..., :3, 3] = rotation, position
    matrix[..., 3, 3] = 1.0
    return matrix


def rotation_of(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions xyzw (..., 4). Shape (..., 3, 3)."""
    given = np.asarray(quaternion, dtype=float)
    x, y, z, w = given[..., 0], given[..., 1], given[..., 2], given[..., 3]
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz, xw, yw, zw = x * y, x * z, y * z, x * w, y * w, z * w
    found = np.empty((*given.shape[:-1], 3, 3))  # written in place: a loop asks for a few at once
    found[..., 0, 0] = 1 - 2 * (yy + zz)
    found[..., 0, 1] = 2 * (xy - zw)
    found[..., 0, 2] = 2 * (xz + yw)
    found[..., 1, 0] = 2 * (xy + zw)
    found[..., 1, 1] = 1 - 2 * (xx + zz)
    found[..., 1, 2] = 2 * (yz - xw)
    found[..., 2, 0] = 2 * (xz - yw)
    found[..., 2, 1] = 2 * (yz + xw)
    found[..., 2, 2] = 1 - 2 * (xx + yy)
    return found


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternions xyzw with w >= 0 of rotation matrices (..., 3, 3). Shape (..., 4).

    The symmetric matrix 4 q q^T is linear in the rotation; its column with the largest diagonal
    element, normalised, is q without loss of digits. Derived here.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = np.moveaxis(rotation, (-2, -1), (0, 1))
    xy, xz, yz, xw, yw, zw = r01 + r10, r02 + r20, r12 + r21, r21 - r12, r02 - r20, r10 - r01
    rows = [
        [1 + r00 - r11 - r22, xy, xz, xw],
        [xy, 1 - r00 + r11 - r22, yz, yw],
        [xz, yz, 1 - r00 - r11 + r22, zw],
        [xw, yw, zw, 1 + r00 + r11 + r22],
    ]
    largest = np.argmax(np.stack([rows[k][k] for k in range(4)]), axis=0)
    x, y, z, w = (np.choose(largest, row) for row in rows)
    norm = np.where(w < 0.0, -1.0, 1.0) * np.sqrt(x * x + y * y + z * z + w * w)
    return np.moveaxis(np.array([x / norm, y / norm, z / norm, w / norm]), 0, -1)


def roll_pitch_yaw(rotation: np.ndarray) -> np.ndarray:
    """Angles of Rz(yaw) Ry(pitch) Rx(roll), in [rad]; pitch in [-pi/2, pi/2]. Shape (..., 3)."""
    roll = np.arctan2(rotation[..., 2, 1], rotation[..., 2, 2])
    sideways = np.hypot(rotation[..., 0, 0], rotation[..., 1, 0])
    pitch = np.arctan2(-rotation[..., 2, 0], sideways)
    yaw = np.arctan2(rotation[..., 1, 0], rotation[..., 0, 0])
    return np.moveaxis(np.array([roll, pitch, yaw]), 0, -1)
