"""A three-joint arm: shoulder pitch, shoulder roll, elbow.

Corrections to the printed equations of [Pristovani2018]: R11 of (5) lacks the last factor sin(q3);
R13 of (5) is labelled R33; link indices in (5) follow Table 3; phi of (5) is
cos(q2) (dz2 + dz3 cos(q3)), no printed version satisfies its own R14; R24 of (7) takes -dy, and
the rest of (7) equals (5). In print the right limbs lie at +y; here y points left, so the side
with s = +1 is the left one and every formula stands as it is.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitlab.kinematics.reach import require
from gaitlab.kinematics.transforms import homogeneous

ROUNDING = 1e-9  # -, share by which a cosine or a root may miss its range


@dataclass(frozen=True, kw_only=True)
class ArmLengths:
    """Lengths of the arm's chain Ry T(0, s dy, -dz1) Rx T(0, 0, -dz2) Ry T(0, 0, -dz3).

    Attributes:
        shoulder_spacing: dy, trunk centre plane to the arm, in [m].
        shoulder_drop: dz1, shoulder pitch axis down to the roll axis, in [m].
        upper_arm: dz2, roll axis to the elbow, in [m].
        forearm: dz3, elbow to the hand, in [m].
    """

    shoulder_spacing: float
    shoulder_drop: float
    upper_arm: float
    forearm: float


def hand_pose(
    geometry: ArmLengths, joints: np.ndarray, side: Literal["left", "right"]
) -> np.ndarray:
    """Pose of the hand in the arm origin's frame, [Pristovani2018] eqs. (5) to (8), corrected.

    Args:
        geometry: Lengths of the chain.
        joints: Shoulder pitch, shoulder roll and elbow, in [rad]. Shape (..., 3).
        side: Which arm; the left one lies at +y.

    Returns:
        Homogeneous transform, positions in [m]. Shape (..., 4, 4).
    """
    c1, c2, c3 = np.moveaxis(np.cos(joints), -1, 0)
    s1, s2, s3 = np.moveaxis(np.sin(joints), -1, 0)
    dz1, dz2, dz3 = geometry.shoulder_drop, geometry.upper_arm, geometry.forearm
    dy = geometry.shoulder_spacing if side == "left" else -geometry.shoulder_spacing
    phi = c2 * (dz2 + dz3 * c3)
    rows = [
        [c1 * c3 - s1 * c2 * s3, s1 * s2, c1 * s3 + s1 * c2 * c3],
        [s2 * s3, c2, -s2 * c3],
        [-s1 * c3 - c1 * c2 * s3, c1 * s2, c1 * c2 * c3 - s1 * s3],
    ]
    rotation = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    x = -dz1 * s1 - s1 * phi - dz3 * c1 * s3
    y = dy + dz2 * s2 + dz3 * s2 * c3
    z = dz3 * s1 * s3 - c1 * phi - dz1 * c1
    return homogeneous(rotation, np.stack([x, y, z], axis=-1))


def hand_branches(
    geometry: ArmLengths, point: np.ndarray, side: Literal["left", "right"]
) -> np.ndarray:
    """Joints that put the hand at a point, derived here from (5) to (8).

    With Y the hand's lateral distance from the arm, L = dz2 + dz3 cos(q3) and w = L cos(q2), (5)
    gives L sin(q2) = Y and x^2 + z^2 + Y^2 = dz1^2 + dz2^2 + dz3^2 + 2 dz2 dz3 cos(q3) + 2 dz1 w;
    without w that is a quadratic in cos(q3).

    Args:
        geometry: Lengths of the chain.
        point: In the arm origin's frame, in [m]. Shape (..., 3).
        side: Which arm.

    Returns:
        Joints in [rad], NaN for a branch that does not exist: elbow bent forward first, and of
        each two the one that hangs lower in the shoulder first. Shape (..., 4, 3).

    Raises:
        Infeasible: If a point has no branch.
    """
    dz1, dz2, dz3 = geometry.shoulder_drop, geometry.upper_arm, geometry.forearm
    dy = geometry.shoulder_spacing if side == "left" else -geometry.shoulder_spacing
    x, y, z = np.moveaxis(np.asarray(point, dtype=float)[..., None, :] - [0.0, dy, 0.0], -1, 0)
    rest = x**2 + y**2 + z**2 - dz1**2 - dz2**2 - dz3**2
    cosine = _elbow_cosines(geometry, y, rest)
    length = dz2 + dz3 * cosine
    with np.errstate(invalid="ignore"):
        lateral = np.sqrt(np.maximum(length**2 - y**2, 0.0)) * [1.0, -1.0]
        lateral = (rest - 2.0 * dz2 * dz3 * cosine) / (2.0 * dz1) if dz1 > 0.0 else lateral
        lower = np.argsort(-np.nan_to_num(lateral, nan=-np.inf), axis=-1)
    cosine, length, lateral = (
        np.take_along_axis(part, lower, axis=-1) for part in (cosine, length, lateral)
    )
    q3 = np.concatenate([-np.arccos(cosine), np.arccos(cosine)], axis=-1)
    length, lateral = (np.concatenate([part, part], axis=-1) for part in (length, lateral))
    q2 = np.arctan2(y * np.sign(length), lateral * np.sign(length))
    q1 = np.arctan2(x, z) - np.arctan2(-dz3 * np.sin(q3), -dz1 - lateral)
    joints = np.stack([np.remainder(q1 + np.pi, 2.0 * np.pi) - np.pi, q2, q3], axis=-1)
    longest = dz1 + dz2 + dz3
    require(
        np.isfinite(joints).all(axis=-1).any(axis=-1),
        np.sqrt(x**2 + y**2 + z**2)[..., 0],
        f"{side}_arm",
        f"arm origin to hand would have to be {{found:.4f}} m; the arm is {longest:.4f} m long and "
        "reaches less far ahead, aside and close by",
    )
    return joints


def _elbow_cosines(geometry: ArmLengths, y: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Both roots of the quadratic in cos(q3), NaN where they are none. Shape (..., 2)."""
    dz1, dz2, dz3 = geometry.shoulder_drop, geometry.upper_arm, geometry.forearm
    a = 4.0 * dz3**2 * (dz2**2 - dz1**2)
    half = -2.0 * dz2 * dz3 * (rest + 2.0 * dz1**2)
    c = rest**2 - 4.0 * dz1**2 * (dz2**2 - y**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        square = half**2 - a * c
        root = np.sqrt(np.where(square > -ROUNDING * half**2, np.maximum(square, 0.0), np.nan))
        sum_of_both = -(half + np.where(half < 0.0, -root, root))
        cosine = np.concatenate([sum_of_both / a, c / sum_of_both], axis=-1)
        cosine = np.where(np.abs(cosine) <= 1.0 + ROUNDING, np.clip(cosine, -1.0, 1.0), np.nan)
        bent = np.abs(dz2 + dz3 * cosine) >= np.abs(y) - ROUNDING
    return np.where(bent, cosine, np.nan)
