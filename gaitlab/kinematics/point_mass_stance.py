"""What the motors of a leg on belts do in one stance, with all mass in the hips; derived here.

Massless legs, an upright trunk and no moment at the ankle: the ground's force on the foot is what
the point mass needs, and the virtual work of that force gives the torques.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

GRAVITY = 9.81  # m/s^2


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

    The inverse of `gaitlab.kinematics.belt_leg.motor_torques` where the ankle carries no moment.
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
