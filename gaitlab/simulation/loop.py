"""What the servos are sent, tick by tick: a gait, as balance corrects it, or what a policy says."""

from __future__ import annotations

from math import ceil, floor
from typing import Protocol

import numpy as np

from gaitlab.model import Robot
from gaitlab.model.balance import require_joints
from gaitlab.model.commands import Reactive
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import ROUNDING, Attitude, Readings
from gaitlab.model.randomness import randomness
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial


class Loop(Protocol):
    """What is sent, and what becomes known meanwhile.

    Attributes:
        sent: Joint targets, in [rad], as far as ticks have passed what the servos were sent.
            Shape (n, joints).
    """

    sent: np.ndarray

    @property
    def feet(self) -> FeetPoses:
        """What the feet are meant to do, as far as ticks have passed."""

    def begin(self, trunk: np.ndarray) -> None:
        """Take in the trunk before the first tick, as a row of the tape. Shape (13,)."""

    def targets(self, tick: int) -> np.ndarray:
        """What to send from this tick on until more is known, in [rad]. Shape (ticks, joints)."""

    def feel(self, tape: Tape, first: int) -> None:
        """Take in what the tape holds from a tick on."""


def loop_of(trial: Trial, feet: FeetPoses, targets: np.ndarray) -> Loop:
    """An open loop, or one that the trial's balance controller or its gait closes.

    Args:
        trial: The trial.
        feet: What its gait means, at every tick.
        targets: Joint targets of that, in [rad]. Shape (n, joints).
    """
    if isinstance(trial.gait, Reactive):
        return Piloted(trial, trial.gait, targets)
    return Open(feet, targets) if trial.balance is None else Closed(trial, feet, targets)


class Open:
    """The gait as it is."""

    def __init__(self, feet: FeetPoses, targets: np.ndarray) -> None:
        self.feet, self.sent = feet, targets

    def targets(self, tick: int) -> np.ndarray:
        """All that is left of the gait."""
        return self.sent[tick:]

    def begin(self, trunk: np.ndarray) -> None:
        """Nothing depends on it."""

    def feel(self, tape: Tape, first: int) -> None:
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
        self.feet, self.sent = feet, targets.copy()
        self._imu, self._dt = balance.imu, dt
        self._controller = balance.controller(feet, dt)
        self._readings = Readings(balance.imu, dt, randomness(trial.seed).imu, trial.slope.level)
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

    def begin(self, trunk: np.ndarray) -> None:
        """Let the IMU see the trunk."""
        self._see(trunk[None])

    def feel(self, tape: Tape, first: int) -> None:
        """Let the IMU see the trunk."""
        self._see(tape.trunk[first : tape.length])

    def _see(self, trunk: np.ndarray) -> None:
        for row in trunk[:, 3:].tolist():
            self._readings.see(tuple(row[:4]), tuple(row[7:]))


class Piloted:
    """Standing, then what a policy says, held until it acts again.

    It feels the joints as they are at the end of the tick before, and the trunk as the latest
    reading of the IMU has it. Targets are kept within the joint limits.
    """

    def __init__(self, trial: Trial, gait: Reactive, targets: np.ndarray) -> None:
        self.sent, self._trial, self._gait = targets.copy(), trial, gait
        self._pilot, self._dt = gait.pilot(trial.robot), trial.engine.dt
        self._taken = round(gait.stand_time / self._dt)  # tick in which it takes over
        rng, level = randomness(trial.seed).imu, trial.slope.level
        self._readings = Readings(gait.imu, self._dt, rng, level)
        self._late, self._old = (
            round(seconds / self._dt) for seconds in (self._pilot.delay, gait.imu.delay)
        )
        columns = self._pilot.columns
        self._low, self._high = (part[:, columns] for part in _ranges(trial.robot, targets[:1]))
        self._position, self._velocity = targets[0, columns], np.zeros(len(columns))
        self._first = np.empty(0)
        self._tape: Tape | None = None
        self._read, self._felt = -1, (Attitude(0.0, 0.0, 0.0, 0.0), 0.0)

    @property
    def feet(self) -> FeetPoses:
        """Where what was sent would put the feet."""
        n = len(self.sent) if self._tape is None else self._tape.length
        sent, at = self.sent[:n], np.arange(n) * self._dt
        return self._gait.feet_sent(self._trial.robot, sent, at)

    def targets(self, tick: int) -> np.ndarray:
        """What is sent until the policy acts again."""
        if tick < self._taken:
            return self.sent[tick : self._taken]
        t, interval = (tick - self._taken) * self._dt, self._pilot.interval
        acts = floor(t / interval + ROUNDING) + 1
        end = max(tick + 1, self._taken + ceil(acts * interval / self._dt - ROUNDING))
        found = self._pilot.act(t, *self._reading(tick), self._position, self._velocity)
        held = self.sent[tick + self._late : end + self._late]
        held[:, self._pilot.columns] = np.minimum(np.maximum(found, self._low), self._high)
        return self.sent[tick:end]

    def _reading(self, tick: int) -> tuple[Attitude, float]:
        """What the IMU said last, the yaw rate apart, in [rad/s]."""
        read = self._gait.imu.latest(tick, self._dt)
        if read != self._read:
            row, self._read = read - 1 - self._old, read
            trunk = self._first if row < 0 or self._tape is None else self._tape.trunk[row]
            seen = trunk.tolist()
            state = tuple(seen[3:7]), tuple(seen[10:13])
            self._felt = self._readings.told(*state), self._readings.turning(*state)
        return self._felt

    def begin(self, trunk: np.ndarray) -> None:
        """Remember how it stood."""
        self._first = trunk

    def feel(self, tape: Tape, first: int) -> None:
        """Feel the joints."""
        self._tape, columns = tape, self._pilot.columns
        self._position, self._velocity = tape.joints[tape.length - 1, :2, columns].T


def _columns(robot: Robot, joints: tuple[str, ...]) -> list[int]:
    names = [joint.name for joint in robot.tree.joints]
    return [names.index(name) for name in joints]


def _ranges(robot: Robot, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What each target may become: within the joint limits, and what the gait asks for anyway."""
    lower = np.array([joint.lower for joint in robot.tree.joints])
    upper = np.array([joint.upper for joint in robot.tree.joints])
    return np.minimum(targets, lower), np.maximum(targets, upper)
