"""Joint angles as the goal positions of Dynamixel servos, mounted straight unless a robot says so.

For the AX series [Setiyono] has raw = 512 +- 3.413 angle in degrees, which rounds 1024 counts over
300 degrees; the sign belongs to how each servo is mounted.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
    ROBOTIS-eManual: e-Manual of the Dynamixel AX and MX series, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from math import radians

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.model.limbs import Limb

AX_CENTRE = 512  # counts, [Setiyono]
AX_HIGHEST = 1023  # counts, [ROBOTIS-eManual]
AX_PER_DEGREE = 3.413  # counts a degree, [Setiyono]; 1024 / 300
MX_TURN = 4096  # counts a turn, [ROBOTIS-eManual]
MX_CENTRE = 2048  # counts, [ROBOTIS-eManual]


def ax_counts(angle: np.ndarray, direction: np.ndarray | int = 1) -> np.ndarray:
    """Goal position of an AX servo, rounded to the nearest count and kept within 0 to 1023.

    Args:
        angle: In [rad], 0 in the middle of the servo's range. Shape (...).
        direction: 1 or -1, how the servo is mounted. Shape (...).

    Returns:
        Whole counts. Shape (...).
    """
    raw = AX_CENTRE + np.asarray(direction) * AX_PER_DEGREE * np.degrees(angle)
    return np.clip(np.floor(raw + 0.5), 0, AX_HIGHEST).astype(int)


def mx_counts(angle: np.ndarray) -> np.ndarray:
    """Goal position of an MX servo, rounded and kept within 0 to 4095; angles in [rad]."""
    raw = MX_CENTRE + np.asarray(angle) * MX_TURN / radians(360.0)
    return np.clip(np.floor(raw + 0.5), 0, MX_TURN - 1).astype(int)


def limb_counts(limb: Limb, joints: np.ndarray) -> dict[str, int]:
    """Goal position of each servo of a limb by joint.

    Raises:
        WrongValue: If a joint's servo is none whose counts are known.
    """
    if limb.counts is not None:
        values = limb.counts(joints)
    else:
        values = np.array(
            [_counts(joint.servo, angle) for joint, angle in zip(limb.joints, joints, strict=True)]
        )
    return {joint.name: int(value) for joint, value in zip(limb.joints, values, strict=True)}


def _counts(servo: str | None, angle: float) -> int:
    if servo is not None and servo.startswith("mx_"):
        return int(mx_counts(np.array(angle)))
    if servo is not None and servo.startswith("ax_"):
        return int(ax_counts(np.array(angle)))
    raise WrongValue(
        f"counts of a servo {servo or 'that is none'} are not known, only those of the Dynamixel "
        "series ax_ and mx_"
    )
