"""What the servos are sent, tick by tick: the gait alone, or the gait as balance corrects it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gaitlab.model import Robot
from gaitlab.model.balance import require_joints
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Readings
from gaitlab.model.randomness import randomness
from gaitlab.simulation.trial import Trial


class Loop(Protocol):
    """What is sent, and what becomes known meanwhile.

    Attributes:
        sent: Joint targets, in [rad], as far as ticks have passed what the servos were sent.
            Shape (n, joints).
    """

    sent: np.ndarray

    def targets(self, tick: int) -> np.ndarray:
        """What to send from this tick on until more is known, in [rad]. Shape (ticks, joints)."""

    def feel(self, trunk: np.ndarray) -> None:
        """Take in the trunk at the end of each tick, or before the first, as rows of the tape."""


def loop_of(trial: Trial, feet: FeetPoses, targets: np.ndarray) -> Loop:
    """An open loop, or one that the trial's balance controller closes.

    Args:
        trial: The trial.
        feet: What its gait means, at every tick.
        targets: Joint targets of that, in [rad]. Shape (n, joints).
    """
    return Open(targets) if trial.balance is None else Closed(trial, feet, targets)


class Open:
    """The gait as it is."""

    def __init__(self, targets: np.ndarray) -> None:
        self.sent = targets

    def targets(self, tick: int) -> np.ndarray:
        """All that is left of the gait."""
        return self.sent[tick:]

    def feel(self, trunk: np.ndarray) -> None:
        """Nothing depends on it."""


class Closed:
    """The gait with corrections that are held between two readings of the IMU.

    A limit cuts a correction and never the gait.
    """

    def __init__(self, trial: Trial, feet: FeetPoses, targets: np.ndarray) -> None:
        if trial.balance is None:
            raise ValueError("the trial has no balance controller")
        balance, dt = trial.balance, trial.engine.dt
        require_joints(balance, trial.robot)
        self.sent = targets.copy()
        self._imu, self._dt = balance.imu, dt
        self._controller = balance.controller(feet, dt)
        self._readings = Readings(balance.imu, dt, randomness(trial.seed).imu)
        self._columns = _columns(trial.robot, balance.joints)
        self._low, self._high = _ranges(trial.robot, targets)
        self._correction = np.full(targets.shape[1], -0.0)  # adding it keeps even a sign of zero

    def targets(self, tick: int) -> np.ndarray:
        """The gait until the next reading, corrected by this one, within the limits."""
        end = tick + 1
        while end < len(self.sent) and not self._imu.due(end, self._dt):
            end += 1
        felt = self._readings.read()
        self._correction[self._columns] = self._controller.correction(tick, felt)
        rows: np.ndarray = self.sent[tick:end]
        np.add(rows, self._correction, out=rows)
        np.maximum(rows, self._low[tick:end], out=rows)
        np.minimum(rows, self._high[tick:end], out=rows)
        return rows

    def feel(self, trunk: np.ndarray) -> None:
        """Let the IMU see the trunk."""
        for row in trunk[:, 3:].tolist():
            self._readings.see(tuple(row[:4]), tuple(row[7:]))


def _columns(robot: Robot, joints: tuple[str, ...]) -> list[int]:
    names = [joint.name for joint in robot.tree.joints]
    return [names.index(name) for name in joints]


def _ranges(robot: Robot, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What each target may become: within the joint limits, and what the gait asks for anyway."""
    lower = np.array([joint.lower for joint in robot.tree.joints])
    upper = np.array([joint.upper for joint in robot.tree.joints])
    return np.minimum(targets, lower), np.maximum(targets, upper)
