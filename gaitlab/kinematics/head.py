"""A pan-tilt head: the camera's pose, and where to turn to look at a point.

Paper's [Pristovani2018] signs: pitch positive looks down. Corrections to the printed equations:
the fourth column's second row of (2), and (3), must read d2 sin(q1) sin(q2); print has
sin(q2) sin(q2).

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitlab.kinematics.transforms import homogeneous


@dataclass(frozen=True, kw_only=True)
class HeadLengths:
    """Lengths of the head's chain Rz(pan) T(0, 0, d1) Ry(tilt) T(0, 0, d2).

    Attributes:
        neck: d1, neck base to the tilt axis, in [m].
        camera: d2, tilt axis to the camera, in [m].
    """

    neck: float
    camera: float


def camera_pose(geometry: HeadLengths, joints: np.ndarray) -> np.ndarray:
    """Pose of the camera in the neck base frame, [Pristovani2018] eqs. (2) and (3).

    Args:
        geometry: Lengths of the chain.
        joints: Pan and tilt, in [rad]. Shape (..., 2).

    Returns:
        Homogeneous transform, positions in [m]. Shape (..., 4, 4).
    """
    c1, c2 = np.moveaxis(np.cos(joints), -1, 0)
    s1, s2 = np.moveaxis(np.sin(joints), -1, 0)
    d1, d2, zero = geometry.neck, geometry.camera, np.zeros_like(c1)
    rotation = np.stack([c1 * c2, -s1, c1 * s2, s1 * c2, c1, s1 * s2, -s2, zero, c2], axis=-1)
    position = np.stack([d2 * c1 * s2, d2 * s1 * s2, d1 + d2 * c2], axis=-1)
    return homogeneous(rotation.reshape(*c1.shape, 3, 3), position)


def pointing_joints(geometry: HeadLengths, point: np.ndarray) -> np.ndarray:
    """Pan and tilt that put the camera's up axis through a point, derived here from (3).

    The camera itself goes there when the point lies `camera` away from the tilt axis.

    Args:
        geometry: Lengths of the chain.
        point: In the neck base frame, in [m]. Shape (..., 3).

    Returns:
        Pan and tilt >= 0, in [rad]. Shape (..., 2).
    """
    x, y, z = np.moveaxis(np.asarray(point, dtype=float), -1, 0)
    return np.stack([np.arctan2(y, x), np.arctan2(np.hypot(x, y), z - geometry.neck)], axis=-1)
