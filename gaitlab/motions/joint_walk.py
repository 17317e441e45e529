"""What a walk from joint angles is, wherever the angles come from.

The robot stands for a start, bends from there to the first row in `stand_time`, and then each row
is sent at its instant and held until the next. Joints that the rows leave out stay as they stand.
With `period` the last so many seconds repeat; without, the last row is held to the end.

What a walk is meant to do cannot be read from joint angles: `step_length` is what its maker meant,
and 0 if nobody says. Then no distance was commanded: it is measured, and nothing is called stalled.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.model import Robot
from gaitlab.model.forward import feet_of_joints, standing_joints
from gaitlab.model.gait import FeetPoses
from gaitlab.model.servo import Servo
from gaitlab.motions.trajectory import Trajectory, Unit, require_walkable
from gaitlab.parameters import parameter

ROUNDING = 1e-9  # s, and share of a control period


@dataclass(frozen=True, kw_only=True)
class JointWalk(ABC):
    """How joint angles over time are walked."""

    unit: Unit = parameter("rad", unit="-", doc="of the angles in the file: rad or deg")
    period: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=60.0,
        doc="a whole cycle, two steps; 0: not known, all of the file counts as one",
    )
    repeat: bool = parameter(
        True, unit="-", doc="walk the last period again and again; false: only once"
    )
    step_length: float = parameter(
        0.0, unit="m", low=-2.0, high=2.0, doc="of the walk as it was meant; 0: not known"
    )
    side_step: float = parameter(
        0.0, unit="m", low=-1.0, high=1.0, doc="to the left in each step, as it was meant"
    )
    turn: float = parameter(
        0.0, unit="rad", low=-1.0, high=1.0, doc="to the left in each step, as it was meant"
    )
    stand_time: float = parameter(
        1.0,
        unit="s",
        low=0.0,
        high=10.0,
        doc="from standing to the first row; 0: starts in it",
        source="assumption",
    )
    walk_start: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=600.0,
        doc="of the file, before which it only starts up and nothing is measured",
    )
    control_period: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=0.1,
        doc="between two targets, read off straight lines between rows; 0: the rows themselves",
    )
    hip_height: float = parameter(
        0.0, unit="m", low=0.0, high=3.0, doc="hips over the soles; 0: as it starts to walk"
    )

    @property
    @abstractmethod
    def trajectory(self) -> Trajectory:
        """The joint angles over time."""

    @property
    def gait_period(self) -> float:
        """A whole cycle of two steps, in [s]."""
        return self.period or max(self.trajectory.end - self.walk_start, ROUNDING)

    @property
    def startup_time(self) -> float:
        """Until it walks as it is meant to, in [s]."""
        return self.stand_time + self.walk_start

    @property
    def _repeats_from(self) -> float | None:
        """Instant of the file that follows its end, in [s]; None if nothing does."""
        return self.trajectory.end - self.period if self.period and self.repeat else None

    def feet_on(self, robot: Robot, t: np.ndarray) -> FeetPoses:
        """Feet and joints of a robot at the instants t, in [s], t >= 0. Shape (n,).

        Raises:
            Infeasible: If the robot cannot stand for a start.
        """
        t = np.asarray(t, dtype=float) - self.stand_time
        begun = t >= self.walk_start - ROUNDING
        if self.control_period:
            t = np.floor(t / self.control_period + ROUNDING) * self.control_period
        place = self._place(t)
        if not self.control_period:  # the phase, too, is that of the row
            t = t - np.maximum(place - self.trajectory.time[self.trajectory.row(place)], 0.0)
        walked = np.maximum(t - self.walk_start, 0.0) + ROUNDING
        count, rest = np.divmod(walked, self.gait_period)
        second = 2.0 * rest >= self.gait_period
        return replace(
            feet_of_joints(robot, self._joints(robot, place)),
            phase=np.where(begun, np.maximum(rest - ROUNDING, 0.0) / self.gait_period, np.nan),
            step_index=np.where(begun, 2 * count + second, -1).astype(int),
        )

    def _place(self, t: np.ndarray) -> np.ndarray:
        """Which instant of the file is walked so long after its first row, in [s]. Shape (n,)."""
        end, repeats = self.trajectory.end, self._repeats_from
        if repeats is None:
            return t
        again = repeats + np.mod(t - repeats + ROUNDING, self.period)
        return np.where(t >= end - ROUNDING, again, t)

    def _joints(self, robot: Robot, t: np.ndarray) -> np.ndarray:
        """Targets of all joints at instants of the file, in [s]. Shape (n, joints)."""
        found = self.trajectory
        sent = found.at(t) if self.control_period else found.angles[found.row(t)]
        names = [joint.name for joint in robot.tree.joints]
        columns = [names.index(name) for name in found.joints]
        standing = self._standing(robot, columns)
        joints = np.tile(standing, (len(t), 1))
        joints[:, columns] = sent
        if self.stand_time:
            share = np.clip(1.0 + t / self.stand_time, 0.0, 1.0)
            share = share * share * (3.0 - 2.0 * share)  # at rest at both ends
            bent = standing + share[:, None] * (joints - standing)
            joints = np.where((t < 0.0)[:, None], bent, joints)
        return joints

    def _standing(self, robot: Robot, columns: Sequence[int]) -> np.ndarray:
        """How a robot stands; one that cannot with bent knees starts in the first row."""
        try:
            return standing_joints(robot)
        except Infeasible:
            joints = np.zeros(len(robot.tree.joints))
            joints[list(columns)] = self.trajectory.angles[0]
            return joints

    def require_playable(self, robot: Robot, servos: Sequence[Servo]) -> None:
        """Refuse a robot that cannot be sent it, and a cycle that is not in the file.

        Raises:
            FileError: Joints, limits and jumps, at their lines.
            WrongValue: If the file is too short for `walk_start` and `period`.
        """
        found = self.trajectory
        left, least = found.end - self.walk_start, self.period if self.repeat else 0.0
        if left <= 0.0 or left < least - (found.end - found.time[-1]) - ROUNDING:
            raise WrongValue(
                f"{found.file} lasts {found.end:g} s; walk_start {self.walk_start:g} s and period "
                f"{self.period:g} s do not fit into it"
            )
        require_walkable(found, robot, servos, self._repeats_from)
