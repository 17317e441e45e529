"""What the servos are sent, tick by tick: the gait alone, or the gait as balance corrects it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gaitlab.model import Robot
from gaitlab.model.balance import require_joints
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Readings
from gaitlab.model.randomness import randomness
from gaitlab.simulation.engine import TickState
from gaitlab.simulation.trial import Trial


class Loop(Protocol):
    """What is sent, and what becomes known after each tick.

    Attributes:
        sent: Joint targets, in [rad], as far as ticks have passed what the servos were sent.
            Shape (n, joints).
    """

    sent: np.ndarray

    def target(self, tick: int) -> np.ndarray:
        """What to send in this tick, in [rad]. Shape (joints,)."""

    def feel(self, state: TickState) -> None:
        """Take in the world at the end of a tick, or before the first."""


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

    def target(self, tick: int) -> np.ndarray:
        """The gait's target."""
        row: np.ndarray = self.sent[tick]
        return row

    def feel(self, state: TickState) -> None:
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

    def target(self, tick: int) -> np.ndarray:
        """The gait's target with the correction of the latest reading, within the limits."""
        if self._imu.due(tick, self._dt):
            felt = self._readings.read()
            self._correction[self._columns] = self._controller.correction(tick, felt)
        row: np.ndarray = self.sent[tick]
        np.add(row, self._correction, out=row)
        np.maximum(row, self._low[tick], out=row)
        np.minimum(row, self._high[tick], out=row)
        return row

    def feel(self, state: TickState) -> None:
        """Let the IMU see the trunk."""
        self._readings.see(state.quaternion, state.spin)


def _columns(robot: Robot, joints: tuple[str, ...]) -> list[int]:
    names = [joint.name for joint in robot.tree.joints]
    return [names.index(name) for name in joints]


def _ranges(robot: Robot, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What each target may become: within the joint limits, and what the gait asks for anyway."""
    lower = np.array([joint.lower for joint in robot.tree.joints])
    upper = np.array([joint.upper for joint in robot.tree.joints])
    return np.minimum(targets, lower), np.maximum(targets, upper)
