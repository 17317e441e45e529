"""The motor law of a row of servos, one tick at a time: the compiled kernel behind the engine.

A proportional controller sets the duty, a DC motor turns it into torque (derived here from the
torque-speed line):

    speed  = gain error                  within the no-load speed
    torque = damping (speed - velocity)  within the limit

with damping = stall torque over no-load speed. The velocity is that at the end of the tick. It
matters: the torque of an MX-64 would stop a foot about its ankle in a tenth of a millisecond, so
that taken from the start of a tick of 2 ms it would overshoot fourteen times. But Bullet has no
motor whose torque falls with speed, only one that goes to a speed with a bounded torque, which it
solves together with the contacts. So the velocity at the end is predicted, the bound is what the
law gives at it, and the motor is sent to `speed`, beyond which no motor of this law drives.

Prediction. With the inertia J that the joint turns and the load torque L on it,

    v' = v + kappa (speed - v + L / damping),   kappa = r / (1 + r),   r = damping dt / J

is the implicit step of the law, exact for a joint that turns freely. L is what the last tick
showed, J (v - v_before) / dt - torque, so at rest, at constant speed and at the limit the law holds
exactly whatever J is. A joint of a standing leg turns more than its own J, for it the prediction is
v low-passed with a lag of r ticks. Half of that and more is made good by carrying the load forward,
L + theta (L - L_before), with the theta that leaves both poles of the lag equal, or a smaller one
above r = 20, where that would let some loads between J and infinity swing up (`LEAD`):

    theta = (sqrt(1 + r) - 1) / (sqrt(1 + r) + 1),   lag = r (1 - theta) ticks.

J of each joint is that of the robot in its first pose with all other joints free, the smallest it
can be; where joints shake each other it is taken smaller by the common factor that keeps the
uncorrected prediction stable (see `feedback`).

References:
    ROBOTIS-eManual: e-Manual of the Dynamixel AX and MX series, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from gaitlab.model.servo import Servo

# The largest theta is LEAD[0] + LEAD[1] / r: up to 0.02 below that at which some load swings up,
# found numerically from the roots of the joint's characteristic polynomial.
LEAD = (0.52, 3.6)


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


class Feedback(NamedTuple):
    """How the velocity at the end of a tick is predicted, and what of the last tick it needs.

    Attributes:
        ratio: r of each joint. Shape (joints,).
        lead: theta of each joint. Shape (joints,).
        velocity: Velocity before the last tick, in [rad/s]; changed in place. Shape (joints,).
        load: Load on the joint in the last tick over its damping, in [rad/s]; changed in place. NaN
            before the first tick, which finds the motor carrying what it is asked for at rest.
            Shape (joints,).
    """

    ratio: np.ndarray
    lead: np.ndarray
    velocity: np.ndarray
    load: np.ndarray


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


def feedback(damping: np.ndarray, mobility: np.ndarray, dt: float) -> Feedback:
    """Feedback of joints at rest.

    With B = dt D^1/2 M^-1 D^1/2, the damping D in units of the inertia, one joint alone has
    r = B_jj. A prediction with s r is stable against a load that shakes all joints while
    B <= 2/3 + 4/3 s diag(B), as matrices; s is the smallest such factor, at least 1. (Derived from
    the characteristic polynomial of one joint, whose true B may be (2 + 4 r) / 3.)

    Args:
        damping: Of each joint, in [N m s/rad]. Shape (joints,).
        mobility: Inverse of the robot's mass matrix at these joints, in [1/(kg m^2)].
            Shape (joints, joints).
        dt: Time step, in [s].
    """
    root = np.sqrt(damping)
    coupled = dt * root[:, None] * mobility * root
    alone = np.diag(coupled)
    if not len(alone):
        return Feedback(*(np.zeros(0) for _ in range(4)))
    scaled = (coupled - 2.0 / 3.0 * np.eye(len(alone))) / np.sqrt(np.outer(alone, alone))
    ratio = max(1.0, 0.75 * float(np.linalg.eigvalsh(scaled)[-1])) * alone
    root = np.sqrt(1.0 + ratio)
    lead = np.minimum((root - 1.0) / (root + 1.0), LEAD[0] + LEAD[1] / ratio)
    return Feedback(ratio, lead, np.zeros(len(ratio)), np.full(len(ratio), np.nan))


def lags(damping: np.ndarray, mobility: np.ndarray, dt: float) -> np.ndarray:
    """How late the velocity of a heavily loaded joint is fed back, in [s]. Shape (joints,).

    Arguments as of `feedback`.
    """
    made = feedback(damping, mobility, dt)
    return dt * made.ratio * (1.0 - made.lead)


@njit(cache=True)
def _quantise(value: float, step: float) -> float:
    return np.round(value / step) * step if step > 0.0 else value


@njit(cache=True)
def drive(
    row: ServoRow,
    memory: Feedback,
    target: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    applied: np.ndarray,
    speed: np.ndarray,
    torque: np.ndarray,
) -> None:
    """Speed each servo heads for and the torque it has to get there; advances the memory.

    Backlash is lost motion: no duty inside the play around the target.

    Args:
        row: The servos.
        memory: How velocity is fed back, and what the last tick was like.
        target: Target that has reached the servos, in [rad]. Shape (joints,).
        position: Joint positions, in [rad]. Shape (joints,).
        velocity: Joint velocities, in [rad/s]. Shape (joints,).
        applied: Torques of the last tick, in [N m]. Shape (joints,).
        speed: Receives the speed without load, in [rad/s]. Shape (joints,).
        torque: Receives the largest torque, in [N m]. Shape (joints,).
    """
    for j in range(len(target)):
        step, damping, ratio = row.resolution[j], row.damping[j], memory.ratio[j]
        error = _quantise(target[j], step) - _quantise(position[j], step)
        error -= min(max(error, -row.play[j]), row.play[j])
        speed[j] = min(max(row.gain[j] * error, -row.speed[j]), row.speed[j])
        load = (velocity[j] - memory.velocity[j]) / ratio - applied[j] / damping
        before = memory.load[j]
        if np.isnan(before):
            load = before = -speed[j]
        ahead = load + memory.lead[j] * (load - before)
        after = velocity[j] + ratio / (1.0 + ratio) * (speed[j] - velocity[j] + ahead)
        memory.velocity[j], memory.load[j] = velocity[j], load
        torque[j] = min(damping * abs(speed[j] - after), row.limit[j])
