"""The motors of a robot in Bullet: a speed and a bounded torque for each joint, step by step.

Bullet has no motor whose torque falls with speed, only one that goes to a speed with a bounded
torque, which it solves together with the contacts. So the velocity at the end of the step is
predicted, the bound is what the law of `gaitlab.servos.law` gives at it, and the motor is sent to
the headed speed, beyond which no motor of that law drives.

Prediction. With the inertia J that the joint turns and the load torque L on it,

    v' = v + kappa (speed - v + L / damping),   kappa = r / (1 + r),   r = damping dt / J

is the implicit step of the law, exact for a joint that turns freely. L is what the last step
showed, J (v - v_before) / dt - torque, so at rest, at constant speed and at the limit the law holds
exactly whatever J is. A joint of a standing leg turns more than its own J, for it the prediction is
v low-passed with a lag of r steps. Half of that and more is made good by carrying the load forward,
L + theta (L - L_before), with the theta that leaves both poles of the lag equal, or a smaller one
above r = 20, where that would let some loads between J and infinity swing up (`LEAD`):

    theta = (sqrt(1 + r) - 1) / (sqrt(1 + r) + 1),   lag = r (1 - theta) steps.

J of each joint is that of the robot in its first pose with all other joints free, the smallest it
can be; where joints shake each other it is taken smaller by the common factor that keeps the
uncorrected prediction stable (see `feedback`).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.model.servo import Servo
from gaitlab.servos.latency import ROUNDING
from gaitlab.servos.law import ServoRow, headed_speed, servo_row

# The largest theta is LEAD[0] + LEAD[1] / r: up to 0.02 below that at which some load swings up,
# found numerically from the roots of the joint's characteristic polynomial.
LEAD = (0.52, 3.6)
LONGEST = 0.002  # s, of a step of the engine
LATEST = 0.02  # s, a fiftieth of a gait's period; EROS' ankles are within it in steps of 2 ms
LARGEST = 0.075  # of the position error; stiffer steps shake the belts of the biped
MOST_STEPS = 20  # in a tick


class Feedback(NamedTuple):
    """How the velocity at the end of a step is predicted, and what of the last step it needs.

    Attributes:
        ratio: r of each joint. Shape (joints,).
        lead: theta of each joint. Shape (joints,).
        velocity: Velocity before the last step, in [rad/s]; changed in place. Shape (joints,).
        load: Load on the joint in the last step over its damping, in [rad/s]; changed in place. NaN
            before the first step, which finds the motor carrying what it is asked for at rest.
            Shape (joints,).
    """

    ratio: np.ndarray
    lead: np.ndarray
    velocity: np.ndarray
    load: np.ndarray


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


def steps_in(
    servos: Sequence[Servo],
    mobility: np.ndarray,
    standing: Sequence[int],
    geared: Sequence[int],
    dt: float,
) -> int:
    """Into how many steps of the engine a tick is divided.

    As many as keep a step within `LONGEST`, the feedback of the joints that the robot stands on
    within `LATEST`, and what a geared one makes good of its error in a step within `LARGEST`.

    Args:
        servos: One per joint.
        mobility: Inverse of the robot's mass matrix at these joints, in [1/(kg m^2)].
            Shape (joints, joints).
        standing: Indices of the joints of the legs.
        geared: Indices of the joints that gears or belts tie to others.
        dt: Duration of the tick, in [s].
    """
    row = servo_row(servos, np.ones(len(servos)))
    damping, quickest = row.damping, float(np.max(row.gain[list(geared)], initial=0.0))
    steps = max(1, ceil(dt / LONGEST - ROUNDING), ceil(quickest * dt / LARGEST - ROUNDING))
    while steps < MOST_STEPS:
        if np.max(lags(damping, mobility, dt / steps)[list(standing)], initial=0.0) <= LATEST:
            break
        steps += 1
    return steps


class Motors:
    """The motors of one robot, and what they remember of the last step."""

    def __init__(
        self, servos: Sequence[Servo], gain_scale: np.ndarray, dt: float, mobility: np.ndarray
    ) -> None:
        """Motors at rest.

        Args:
            servos: One per joint.
            gain_scale: Factor on the position gain of each. Shape (joints,).
            dt: Duration of a step, in [s].
            mobility: Inverse of the robot's mass matrix at these joints, in [1/(kg m^2)].
                Shape (joints, joints).
        """
        self._row = servo_row(servos, gain_scale)
        self._memory = feedback(self._row.damping, mobility, dt)
        self._speed, self._torque = np.zeros(len(servos)), np.zeros(len(servos))

    def drive(
        self, due: np.ndarray, position: np.ndarray, velocity: np.ndarray, applied: np.ndarray
    ) -> tuple[list[float], list[float]]:
        """What to ask of Bullet in this step.

        Args:
            due: Targets that have reached the servos, in [rad]. Shape (joints,).
            position: Joint positions, in [rad]. Shape (joints,).
            velocity: Joint velocities, in [rad/s]. Shape (joints,).
            applied: Torques of the last step, in [N m]. Shape (joints,).

        Returns:
            Speeds to head for, in [rad/s], and largest torques, in [N m], in joint order.
        """
        drive(self._row, self._memory, due, position, velocity, applied, self._speed, self._torque)
        return self._speed.tolist(), self._torque.tolist()


@njit
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

    Args:
        row: The servos.
        memory: How velocity is fed back, and what the last step was like.
        target: Target that has reached the servos, in [rad]. Shape (joints,).
        position: Joint positions, in [rad]. Shape (joints,).
        velocity: Joint velocities, in [rad/s]. Shape (joints,).
        applied: Torques of the last step, in [N m]. Shape (joints,).
        speed: Receives the speed without load, in [rad/s]. Shape (joints,).
        torque: Receives the largest torque, in [N m]. Shape (joints,).
    """
    for j in range(len(target)):
        damping, ratio = row.damping[j], memory.ratio[j]
        speed[j] = headed_speed(row, j, target[j], position[j])
        load = (velocity[j] - memory.velocity[j]) / ratio - applied[j] / damping
        before = memory.load[j]
        if np.isnan(before):
            load = before = -speed[j]
        ahead = load + memory.lead[j] * (load - before)
        after = velocity[j] + ratio / (1.0 + ratio) * (speed[j] - velocity[j] + ahead)
        memory.velocity[j], memory.load[j] = velocity[j], load
        torque[j] = min(damping * abs(speed[j] - after), row.limit[j])
