"""A planar leg of two equal segments whose belts carry both motors on the trunk.

Angles are absolute: of the thigh (index 0) and of the shank (index 1) from the downward vertical of
the trunk, positive with the lower end forward. A second belt keeps the sole parallel to the trunk.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from math import acos, asin, cos, hypot, sqrt
from typing import NamedTuple

import numpy as np

ROUNDING = 1e-9  # of the leg's length, by which a straight leg may be too long


def ankle_position(angles: np.ndarray, segment: float) -> np.ndarray:
    """Ankle seen from the hip, forward and up, [Siswoyo2008] section II.

    Args:
        angles: Thigh and shank, in [rad]. Shape (..., 2).
        segment: Length l of thigh and of shank, in [m].

    Returns:
        In [m]. Shape (..., 2).
    """
    forward, down = np.sin(angles).sum(axis=-1), np.cos(angles).sum(axis=-1)
    return segment * np.stack([forward, -down], axis=-1)


def within_reach(ankle: np.ndarray, segment: float) -> np.ndarray:
    """Whether a leg is long enough. Shapes (..., 2) in [m] to (...)."""
    distance = np.hypot(ankle[..., 0], ankle[..., 1])
    return np.asarray(distance <= 2.0 * segment * (1.0 + ROUNDING))


def segment_angles(ankle: np.ndarray, segment: float) -> np.ndarray:
    """Thigh and shank that put the ankle there with the knee forward, derived here.

    The two segments lie on either side of the line from hip to ankle, at the same angle.

    Args:
        ankle: Ankle seen from the hip, forward and up, in [m]. Shape (..., 2).
        segment: Length l of thigh and of shank, in [m].

    Returns:
        In [rad]; a leg that is too short is stretched towards the ankle. Shape (..., 2).
    """
    x, z = ankle[..., 0], ankle[..., 1]
    lean = np.arctan2(x, -z)
    bend = np.arccos(np.clip(np.hypot(x, z) / (2.0 * segment), -1.0, 1.0))
    return np.stack([lean + bend, lean - bend], axis=-1)


def serial_joints(angles: np.ndarray) -> np.ndarray:
    """Hip, knee and ankle of a leg with a motor in each joint that stands alike, derived here.

    Holds for velocities too. Shapes (..., 2) to (..., 3), in [rad] or [rad/s].
    """
    thigh, shank = angles[..., 0], angles[..., 1]
    return np.stack([thigh, shank - thigh, -shank], axis=-1)


def motor_torques(serial: np.ndarray) -> np.ndarray:
    """Torques of the two belt motors that do what three motors in the joints would, derived here.

    The power is the same: motor torque times absolute speed adds up to joint torque times joint
    speed for every motion that the belts allow.

    Args:
        serial: Torques of hip, knee and ankle, in [N m]. Shape (..., 3).

    Returns:
        Torques of the thigh's and of the shank's motor, in [N m]. Shape (..., 2).
    """
    hip, knee, ankle = np.moveaxis(serial, -1, 0)
    return np.stack([hip - knee, knee - ankle], axis=-1)


def belt_reaction(serial: np.ndarray) -> np.ndarray:
    """Moment that the sole's belt carries up to the trunk, in [N m]. Shapes (..., 3) to (...)."""
    return np.asarray(serial[..., 2])


class StrideAngles(NamedTuple):
    """Angles of the postures, in [rad], [Siswoyo2008] section III.A.

    Attributes:
        touchdown: theta, of both segments when a foot lands.
        lift: psi, of thigh and, negative, of shank when the swing foot is lifted.
        ending_thigh: -(A - B), thigh of the trailing leg when lifted in an ending stride.
        ending_shank: -(A + B), its shank.
    """

    touchdown: float
    lift: float
    ending_thigh: float
    ending_shank: float


def stride_angles(
    step_length: float, step_height: float, segment: float, lift: str = "exact"
) -> StrideAngles:
    """Posture angles for lengths in [m]; `printed` lifts from the height that the paper assumes."""
    touchdown = asin(step_length / (2.0 * segment))
    height = 2.0 * segment * cos(touchdown / 2.0)
    assumed = sqrt((2.0 * segment) ** 2 - (step_length / 2.0) ** 2)
    from_height = height if lift == "exact" else assumed
    reach = hypot(height - step_height, step_length / 2.0)
    lean, bend = asin(step_length / 2.0 / reach), acos(min(reach / (2.0 * segment), 1.0))
    return StrideAngles(
        touchdown=touchdown,
        lift=acos((from_height - step_height) / (2.0 * segment)),
        ending_thigh=bend - lean,
        ending_shank=-(lean + bend),
    )
