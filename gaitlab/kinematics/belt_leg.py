"""A planar leg of two equal segments whose belts carry both motors on the trunk.

Angles are absolute: of the thigh (index 0) and of the shank (index 1) from the downward vertical of
the trunk, positive with the lower end forward. A second belt keeps the sole parallel to the trunk.

What the motors do in a stance is derived here for a point mass in the hips: massless legs, an
upright trunk and no moment at the ankle. The ground's force on the foot is what the mass needs, and
the virtual work of that force gives the torques.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from math import acos, asin, cos, hypot, sqrt
from typing import NamedTuple

import numpy as np

GRAVITY = 9.81  # m/s^2
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


class MotorEffort(NamedTuple):
    """What one way of driving the leg costs over a stance.

    Attributes:
        peak: Largest torque of a motor, in [N m].
        work: Positive work of the motors, in [J]; braking gives nothing back.
        heat: Sum over the motors of the integral of torque squared, in [N^2 m^2 s].
    """

    peak: float
    work: float
    heat: float


def belt_torques(
    angles: np.ndarray, acceleration: np.ndarray, mass: float, segment: float
) -> np.ndarray:
    """Torques of the thigh's and of the shank's motor on the trunk.

    Args:
        angles: Thigh and shank of the supporting leg, in [rad]. Shape (n, 2).
        acceleration: Of the hips, forward and up, in [m/s^2]. Shape (n, 2).
        mass: Point mass in the hips, in [kg].
        segment: Length l of thigh and of shank, in [m].

    Returns:
        In [N m]. Shape (n, 2).
    """
    force = mass * (acceleration + np.array([0.0, GRAVITY]))
    lever = -segment * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    torques: np.ndarray = np.einsum("nki,ni->nk", lever, force)
    return torques


def joint_torques(belt: np.ndarray) -> np.ndarray:
    """Hip and knee torques of a leg with a motor in each joint. Shapes (n, 2) to (n, 2), [N m].

    The power is the same: belt torque times absolute speed is joint torque times joint speed.
    """
    return np.stack([belt.sum(axis=-1), belt[:, 1]], axis=-1)


def effort(torque: np.ndarray, speed: np.ndarray, dt: float) -> MotorEffort:
    """Cost of torques at speeds, a motor a column. Shapes (n, m) in [N m], [rad/s]; dt in [s]."""
    power = np.maximum(torque * speed, 0.0).sum(axis=-1)
    heat = (torque**2).sum(axis=-1)
    peak = float(np.abs(torque).max())
    return MotorEffort(peak, _integral(power, dt), _integral(heat, dt))


def _integral(rate: np.ndarray, dt: float) -> float:
    return float(0.5 * (rate[1:] + rate[:-1]).sum()) * dt


class StanceEffort(NamedTuple):
    """The same stance driven by belts from the trunk, and by motors in hip and knee."""

    belts: MotorEffort
    joints: MotorEffort


def stance_effort(
    angles: np.ndarray, acceleration: np.ndarray, dt: float, *, mass: float, segment: float
) -> StanceEffort:
    """Cost of a stance.

    Args:
        angles: Thigh and shank of the supporting leg, in [rad]. Shape (n, 2).
        acceleration: Of the hips, forward and up, in [m/s^2]. Shape (n, 2).
        dt: Time between two instants, in [s].
        mass: Point mass in the hips, in [kg].
        segment: Length l of thigh and of shank, in [m].
    """
    belt = belt_torques(angles, acceleration, mass, segment)
    speed = np.gradient(angles, dt, axis=0)
    relative = np.stack([speed[:, 0], speed[:, 1] - speed[:, 0]], axis=-1)
    return StanceEffort(effort(belt, speed, dt), effort(joint_torques(belt), relative, dt))
