"""The motor law of a row of servos, one tick at a time: the compiled kernel behind the engine.

A proportional controller sets the duty, a DC motor turns it into torque (derived here from the
torque-speed line): torque = damping (speed - velocity) with damping = stall torque over no-load
speed and speed = gain error. The engine is told that speed and the largest torque it may use to
get there, and never overshoots it.

Velocity feedback this strong on a link as light as a foot would chatter from tick to tick, so it
enters the torque as an implicit step of the lightest inertia would have it, damping / (1 + damping
dt / inertia); the torque at rest and the torque-speed line stay exact.

References:
    ROBOTIS-eManual: e-Manual of the Dynamixel AX and MX series, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from gaitlab.servos.servo import Servo

LIGHTEST = 6e-4  # kg m^2, a 0.12 kg foot about its ankle; see the module's docstring


class ServoRow(NamedTuple):
    """Servos of a robot in joint order, as arrays. Shape (joints,) each.

    Attributes:
        gain: Commanded speed over position error, in [1/s].
        speed: No-load speed at the supply's voltage, in [rad/s].
        damping: Stall torque over no-load speed, in [N m s/rad].
        feedback: Damping as it acts within a tick, in [N m s/rad].
        limit: Largest torque, in [N m].
        resolution: Step of target and encoder, in [rad].
        play: Half the backlash, in [rad].
    """

    gain: np.ndarray
    speed: np.ndarray
    damping: np.ndarray
    feedback: np.ndarray
    limit: np.ndarray
    resolution: np.ndarray
    play: np.ndarray


def torque_limit(servo: Servo) -> float:
    """Largest torque of a servo at its supply voltage, in [N m]."""
    return servo.torque_limit * servo.stall_torque * servo.supply / servo.voltage


def servo_row(servos: Sequence[Servo], gain_scale: np.ndarray, dt: float) -> ServoRow:
    """Servos as arrays at a time step in [s], each gain scaled. Shape of gain_scale (joints,)."""
    damping = np.array([s.stall_torque / s.no_load_speed for s in servos])
    table = {
        "gain": [s.position_gain * g for s, g in zip(servos, gain_scale, strict=True)],
        "speed": [s.no_load_speed * s.supply / s.voltage for s in servos],
        "damping": damping,
        "feedback": damping / (1.0 + damping * dt / LIGHTEST),
        "limit": [torque_limit(s) for s in servos],
        "resolution": [s.resolution for s in servos],
        "play": [s.backlash / 2.0 for s in servos],
    }
    return ServoRow(**{name: np.array(values, dtype=float) for name, values in table.items()})


@njit(cache=True)
def _quantise(value: float, step: float) -> float:
    return np.round(value / step) * step if step > 0.0 else value


@njit(cache=True)
def drive(
    row: ServoRow,
    target: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    speed: np.ndarray,
    torque: np.ndarray,
) -> None:
    """Speed each servo heads for and the torque it has to get there.

    Backlash is lost motion: no duty inside the play around the target. The torque is bounded by
    the servo's limit and, when it drives the motion, by the torque-speed line.

    Args:
        row: The servos.
        target: Target that has reached the servos, in [rad]. Shape (joints,).
        position: Joint positions, in [rad]. Shape (joints,).
        velocity: Joint velocities, in [rad/s]. Shape (joints,).
        speed: Receives the speed without load, in [rad/s]. Shape (joints,).
        torque: Receives the largest torque, in [N m]. Shape (joints,).
    """
    for j in range(len(target)):
        step = row.resolution[j]
        error = _quantise(target[j], step) - _quantise(position[j], step)
        error -= min(max(error, -row.play[j]), row.play[j])
        speed[j] = min(max(row.gain[j] * error, -row.speed[j]), row.speed[j])
        wanted = abs(row.damping[j] * speed[j] - row.feedback[j] * velocity[j])
        torque[j] = min(wanted, row.limit[j])
        if speed[j] * velocity[j] > 0.0:
            line = row.damping[j] * (row.speed[j] - abs(velocity[j]))
            torque[j] = min(torque[j], max(line, 0.0))
