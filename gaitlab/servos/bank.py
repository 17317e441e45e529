"""The servos of one robot at work: targets arrive late, torques follow the motor law."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitlab.servos.law import drive, feedback, servo_row
from gaitlab.servos.servo import Servo


def unequally_late(
    servos: Sequence[Servo], spread: float, rng: np.random.Generator
) -> Sequence[Servo]:
    """Servos whose latencies, in ticks, are each moved by spread x U(-1, 1), never below 0.

    Nothing is drawn for a spread of 0.
    """
    if spread == 0.0:
        return servos
    moved = spread * rng.uniform(-1.0, 1.0, len(servos))
    return [
        replace(servo, latency=max(0, round(servo.latency + float(ticks))))
        for servo, ticks in zip(servos, moved, strict=True)
    ]


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
        self._delays = np.array([servo.latency for servo in servos])
        self._alike = len(set(self._delays)) == 1
        longest = int(self._delays.max(initial=0))
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
        """The targets that reach each servo in this tick, sent as many ticks ago as it is late."""
        if self._alike:
            return self._targets[0]
        newest = len(self._targets) - 1
        return np.array(self._targets)[newest - self._delays, np.arange(len(self._delays))]
