"""The servos of one robot at work: targets arrive late, torques follow the motor law."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from gaitlab.model.servo import Servo
from gaitlab.servos.law import drive, feedback, lags, servo_row

LONGEST = 0.002  # s, of a step of the engine
LATEST = 0.02  # s, a fiftieth of a gait's period; EROS' ankles are within it in steps of 2 ms
LARGEST = 0.075  # of the position error; stiffer steps shake the belts of the biped
MOST_STEPS = 20  # in a tick
ROUNDING = 1e-6  # ticks; forgives 0.014 / 0.002 being no whole number to the last bit


def unequally_late(
    servos: Sequence[Servo], spread: float, rng: np.random.Generator
) -> Sequence[Servo]:
    """Servos whose latencies are each moved by spread x U(-1, 1), in [s], never below 0.

    Nothing is drawn for a spread of 0.
    """
    if spread == 0.0:
        return servos
    moved = spread * rng.uniform(-1.0, 1.0, len(servos))
    return [
        replace(servo, latency=max(0.0, servo.latency + float(by)))
        for servo, by in zip(servos, moved, strict=True)
    ]


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


class ServoBank:
    """Servos in joint order, with the targets that are still on their way."""

    def __init__(
        self,
        servos: Sequence[Servo],
        gain_scale: np.ndarray,
        dt: float,
        pose: np.ndarray,
        mobility: np.ndarray,
    ) -> None:
        """Servos at rest.

        Args:
            servos: One per joint.
            gain_scale: Factor on the position gain of each. Shape (joints,).
            dt: Time step, in [s].
            pose: Targets until the first command arrives, in [rad]. Shape (joints,).
            mobility: Inverse of the robot's mass matrix at these joints, in [1/(kg m^2)].
                Shape (joints, joints).
        """
        self._row = servo_row(servos, gain_scale)
        self._memory = feedback(self._row.damping, mobility, dt)
        self._delays, self._shares = _ticks(np.array([servo.latency for servo in servos]) / dt)
        self._between = self._shares > 0.0
        self._alike = len(set(zip(self._delays, self._shares, strict=True))) == 1
        longest = int((self._delays + self._between).max(initial=0))
        self._targets = deque([pose.copy()] * (longest + 1), maxlen=longest + 1)
        self._speed, self._torque = np.zeros(len(servos)), np.zeros(len(servos))

    def drive(
        self,
        target: np.ndarray,
        position: np.ndarray,
        velocity: np.ndarray,
        applied: np.ndarray,
    ) -> tuple[list[float], list[float]]:
        """What to ask of the engine in this tick.

        Args:
            target: Targets sent now, in [rad]. Shape (joints,).
            position: Joint positions, in [rad]. Shape (joints,).
            velocity: Joint velocities, in [rad/s]. Shape (joints,).
            applied: Torques of the last tick, in [N m]. Shape (joints,).

        Returns:
            Speeds to head for, in [rad/s], and largest torques, in [N m], in joint order.
        """
        self._targets.append(target)
        due = self._arrived()
        drive(self._row, self._memory, due, position, velocity, applied, self._speed, self._torque)
        return self._speed.tolist(), self._torque.tolist()

    def _arrived(self) -> np.ndarray:
        """The targets that reach each servo in this tick, sent as long ago as it is late.

        A command that was sent between two ticks lies on the line between theirs.
        """
        if self._alike and not self._between[0]:
            return self._targets[0]
        if self._alike:
            later, earlier = self._targets[1], self._targets[0]
            return later + self._shares * (earlier - later)
        sent, joint = np.array(self._targets), np.arange(len(self._delays))
        at = len(sent) - 1 - self._delays
        later, earlier = sent[at, joint], sent[at - self._between, joint]
        return np.where(self._between, later + self._shares * (earlier - later), later)


def _ticks(late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Delays in whole ticks, and the share of another tick beyond them; no share of rounding."""
    nearest = np.rint(late)
    late = np.where(np.abs(late - nearest) < ROUNDING, nearest, late)
    whole = np.floor(late)
    return whole.astype(int), late - whole
