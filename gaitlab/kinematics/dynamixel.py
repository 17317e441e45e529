"""Angles as a Dynamixel AX-12 counts them.

The paper's rule, raw = 512 +- 3.413 angle in degrees, rounds 1024 counts over 300 degrees; the
sign belongs to how each servo is mounted.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
    ROBOTIS-eManual: e-Manual of the Dynamixel AX-12A, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

import numpy as np

CENTRE = 512  # counts, [Setiyono]
HIGHEST = 1023  # counts, [ROBOTIS-eManual]
PER_DEGREE = 3.413  # counts a degree, [Setiyono]; 1024 / 300


def servo_counts(angle: np.ndarray, direction: np.ndarray | int = 1) -> np.ndarray:
    """Goal position, rounded to the nearest count and kept within 0 to 1023.

    Args:
        angle: In [rad], 0 in the middle of the servo's range. Shape (...).
        direction: 1 or -1, how the servo is mounted. Shape (...).

    Returns:
        Whole counts. Shape (...).
    """
    raw = CENTRE + np.asarray(direction) * PER_DEGREE * np.degrees(angle)
    return np.clip(np.floor(raw + 0.5), 0, HIGHEST).astype(int)
