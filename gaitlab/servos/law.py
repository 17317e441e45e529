"""The motor law of a servo, the same in every engine: the compiled kernel behind them.

A proportional controller sets the duty, a DC motor turns it into torque (derived here from the
torque-speed line):

    speed  = gain error                  within the no-load speed
    torque = damping (speed - velocity)  within the limit

with damping = stall torque over no-load speed. The velocity is that at the end of the step. It
matters: the torque of an MX-64 would stop a foot about its ankle in a tenth of a millisecond, so
that taken from the start of a step of 2 ms it would overshoot fourteen times. How an engine gets
there is its own affair.

References:
    ROBOTIS-eManual: e-Manual of the Dynamixel AX and MX series, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.model.servo import Servo


class ServoRow(NamedTuple):
    """Servos of a robot in joint order, as arrays. Shape (joints,) each.

    Attributes:
        gain: Commanded speed over position error, in [1/s].
        speed: No-load speed at the supply's voltage, in [rad/s].
        damping: Stall torque over no-load speed, in [N m s/rad].
        limit: Largest torque, in [N m].
        resolution: Step of target and encoder, in [rad].
        play: Half the backlash, in [rad].
    """

    gain: np.ndarray
    speed: np.ndarray
    damping: np.ndarray
    limit: np.ndarray
    resolution: np.ndarray
    play: np.ndarray


def torque_limit(servo: Servo) -> float:
    """Largest torque of a servo at its supply voltage, in [N m]."""
    return servo.largest_torque


def stiffness(servo: Servo) -> float:
    """Torque at rest over position error, below the limit, in [N m/rad]."""
    return servo.position_gain * servo.stall_torque / servo.no_load_speed


def servo_row(servos: Sequence[Servo], gain_scale: np.ndarray) -> ServoRow:
    """Servos as arrays, each gain scaled. Shape of gain_scale (joints,)."""
    table = {
        "gain": [s.position_gain * g for s, g in zip(servos, gain_scale, strict=True)],
        "speed": [s.largest_speed for s in servos],
        "damping": [s.stall_torque / s.no_load_speed for s in servos],
        "limit": [torque_limit(s) for s in servos],
        "resolution": [s.resolution for s in servos],
        "play": [s.backlash / 2.0 for s in servos],
    }
    return ServoRow(**{name: np.array(values, dtype=float) for name, values in table.items()})


@njit
def _quantise(value: float, step: float) -> float:
    return np.round(value / step) * step if step > 0.0 else value


@njit
def headed_speed(row: ServoRow, j: int, target: float, position: float) -> float:
    """Speed without load that one servo heads for, in [rad/s].

    Backlash is lost motion: no duty inside the play around the target.

    Args:
        row: The servos.
        j: Which of them.
        target: Target that has reached it, in [rad].
        position: Position of its joint, in [rad].
    """
    step, play = row.resolution[j], row.play[j]
    error = _quantise(target, step) - _quantise(position, step)
    error -= min(max(error, -play), play)
    return min(max(row.gain[j] * error, -row.speed[j]), row.speed[j])
