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

from gaitlab.kinematics.transforms import homogeneous
from gaitlab.parameters import parameter

_SCALED = "assumption: proportions of a robot of this height"


@dataclass(frozen=True, kw_only=True)
class ArmGeometry:
    """Lengths of the arm's chain Ry T(0, s dy, -dz1) Rx T(0, 0, -dz2) Ry T(0, 0, -dz3)."""

    shoulder_spacing: float = parameter(
        0.090,
        unit="m",
        low=0.0,
        high=1.0,
        doc="dy, trunk centre plane to the arm",
        source=_SCALED,
    )
    shoulder_drop: float = parameter(
        0.018,
        unit="m",
        low=0.0,
        high=0.5,
        doc="dz1, shoulder pitch axis down to the roll axis",
        source=_SCALED,
    )
    upper_arm: float = parameter(
        0.075, unit="m", low=0.01, high=1.0, doc="dz2, roll axis to the elbow", source=_SCALED
    )
    forearm: float = parameter(
        0.120, unit="m", low=0.01, high=1.0, doc="dz3, elbow to the hand", source=_SCALED
    )


def hand_pose(
    geometry: ArmGeometry, joints: np.ndarray, side: Literal["left", "right"]
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
