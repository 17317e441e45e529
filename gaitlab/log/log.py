"""The record of one trial: its values tick by tick, and what is known beside them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import pairwise
from math import inf, isinf, isnan, nan
from typing import Any

import numpy as np

from gaitlab.log.columns import FEET, columns
from gaitlab.log.course import Course

GRAVITY = 9.81  # m/s^2, as in the engine
STALL_SHARE = 0.5  # of the commanded distance; assumption, nobody publishes one
SWING_LOAD = 0.1  # of the weight; a standing foot carries half of it, brushed blades far less
SHORTEST_SWING = 0.1  # of the gait period; commanded swings take some 0.3 to 0.5 of it


@dataclass(frozen=True, kw_only=True)
class LogHeader:
    """What a metric needs to know besides the columns.

    Attributes:
        joints: Joint names in column order.
        dt: Time between two rows, in [s].
        mass: Mass of the robot, in [kg].
        standing_height: Height of the trunk link frame when standing still, in [m].
        startup_time: End of the start-up, in [s]; earlier rows are not measured.
        gait_period: Commanded duration of two steps, in [s].
        step_length: Commanded step length, in [m]; negative walks backwards.
        horizon_time: Longest walking time asked for, in [s] after the start-up.
        pile_height: Height of the top of the pile over the base, in [m].
        sole_length: Sole length along x of the foot, in [m].
        sole_width: Sole width, in [m].
        torque_limits: Largest torque each joint's servo may give, in [N m], in joint order; 0 for
            a joint without a servo.
        fsr_positions: x and y of the force sensors in the ankle frame, in [m]: four of the left
            foot in the order of the columns, then four of the right; empty if there are none.
        first_step_time: Instant of the first commanded step, in [s], found by `gaitlab.model.gait`;
            infinite if there is none, NaN in a log that was stored without it.
        side_step: Commanded way to the left in a step, in [m].
        turn: Commanded turn to the left in a step, in [rad].
    """

    joints: tuple[str, ...]
    dt: float
    mass: float
    standing_height: float
    startup_time: float
    gait_period: float
    step_length: float
    horizon_time: float
    pile_height: float
    sole_length: float
    sole_width: float
    torque_limits: tuple[float, ...]
    fsr_positions: tuple[float, ...] = ()
    first_step_time: float = nan
    side_step: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        if self.first_step_time is None:  # as JSON has it, which knows no infinity
            object.__setattr__(self, "first_step_time", inf)

    def to_dict(self) -> dict[str, Any]:
        """The header as JSON data, from which `LogHeader(**data)` rebuilds it."""
        data = asdict(self)
        # What a robot does not have or a log does not know is left out, as before there was any.
        for name in ("fsr_positions", "side_step", "turn"):
            if not data[name]:
                del data[name]
        if isinf(self.first_step_time):
            data["first_step_time"] = None
        elif isnan(self.first_step_time):
            del data["first_step_time"]
        return data

    @property
    def sensors(self) -> np.ndarray | None:
        """Force sensors, left and right foot, ankle frame, in [m]. Shape (2, 4, 2)."""
        return np.reshape(self.fsr_positions, (2, 4, 2)) if self.fsr_positions else None

    @cached_property
    def course(self) -> Course:
        """The way that the walk is commanded to go."""
        steps = (self.step_length, self.side_step, self.turn)
        ahead, aside, rate = (2.0 * step / self.gait_period for step in steps)
        return Course(ahead=ahead, aside=aside, rate=rate)

    @property
    def commanded_speed(self) -> float:
        """Commanded mean speed along the way, in [m/s]; negative straight backwards."""
        return self.course.speed

    @property
    def weight(self) -> float:
        """Weight of the robot, in [N]."""
        return self.mass * GRAVITY


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialLog:
    """A trial that ran: every column over time, locked.

    Attributes:
        header: Constants of the trial.
        arrays: Column name to array of the column's dtype. Shape (n,) each.

    Raises:
        KeyError: If a column is missing that no older log lacks.
        ValueError: If the columns differ in length.
    """

    header: LogHeader
    arrays: Mapping[str, np.ndarray]

    def __post_init__(self) -> None:
        locked = {}
        for column in columns(self.header.joints):
            given = self.arrays.get(column.name) if column.late else self.arrays[column.name]
            if given is None:
                given = np.full(len(self.arrays["time"]), nan)
            array = np.ascontiguousarray(given, dtype=column.dtype)
            array.setflags(write=False)
            locked[column.name] = array
        if len({len(array) for array in locked.values()}) != 1:
            raise ValueError("the columns of a log are equally long")
        object.__setattr__(self, "arrays", locked)

    def __len__(self) -> int:
        return len(self.arrays["time"])

    def __getitem__(self, name: str) -> np.ndarray:
        """One column, floats widened to float64 so that sums do not lose digits. Shape (n,)."""
        array = self.arrays[name]
        return array.astype(np.float64) if array.dtype == np.float32 else array

    def vector(self, name: str, axes: Sequence[str] = "xyz") -> np.ndarray:
        """Columns `name` + axis side by side, `vector("trunk_")` for instance. Shape (n, axes)."""
        return self._side_by_side(f"{name}{axis}" for axis in axes)

    def joint_table(self, quantity: str) -> np.ndarray:
        """`target`, `position`, `velocity` or `torque` of every joint. Shape (n, joints)."""
        return self._side_by_side(f"{joint}_{quantity}" for joint in self.header.joints)

    def per_foot(self, quantity: str) -> np.ndarray:
        """One quantity of the left and the right foot, `sink` for instance. Shape (n, 2)."""
        return self._side_by_side(f"{side}_foot_{quantity}" for side in FEET)

    def driven_table(self, quantity: str) -> np.ndarray:
        """The same of every joint that has a servo, locked. Shape (n, driven joints)."""
        if quantity not in self._driven:
            limits = zip(self.header.joints, self.header.torque_limits, strict=True)
            driven = (f"{joint}_{quantity}" for joint, limit in limits if limit > 0.0)
            self._driven[quantity] = self._side_by_side(driven)
            self._driven[quantity].setflags(write=False)
        return self._driven[quantity]

    def _side_by_side(self, names: Iterable[str]) -> np.ndarray:
        """Columns as those of one table, floats widened as one column's are. Shape (n, columns)."""
        rows = np.array([self.arrays[name] for name in names])
        wide = np.float64 if rows.dtype == np.float32 else rows.dtype
        return np.ascontiguousarray(rows.T, dtype=wide)  # five times as fast as stacking columns

    @cached_property
    def _driven(self) -> dict[str, np.ndarray]:
        """What `driven_table` has made: several metrics ask for the same."""
        return {}

    @cached_property
    def fall_index(self) -> int | None:
        """Row at which the fall was established, None if the robot stayed up."""
        fallen = np.flatnonzero(self.arrays["fall_cause"])
        return int(fallen[0]) if len(fallen) else None

    @cached_property
    def fell_standing(self) -> bool:
        """Whether the fall was established before the first commanded step."""
        if self.fall_index is None:
            return False
        # The row that ends as the step begins is still standing; a tenth of one forgives rounding.
        until = self.header.first_step_time + 0.1 * self.header.dt
        return bool(self["time"][self.fall_index] <= until)

    @cached_property
    def walking(self) -> slice:
        """Rows that are measured: after the start-up, before the fall; empty if there are none."""
        # A tenth of a row forgives the rounding of the time column.
        after = self.header.startup_time + 0.1 * self.header.dt
        start = int(np.searchsorted(self["time"], after))
        stop = len(self) if self.fall_index is None else self.fall_index
        return slice(min(start, stop), stop)

    @property
    def walked_time(self) -> float:
        """Time that was walked and measured, in [s]."""
        return (self.walking.stop - self.walking.start) * self.header.dt

    @property
    def commanded_distance(self) -> float:
        """Distance commanded over the walked time, in [m]; never negative."""
        return abs(self.header.commanded_speed) * self.walked_time

    @cached_property
    def displacement(self) -> np.ndarray:
        """Trunk position relative to the end of the start-up, along and across the commanded way.

        Along is positive the way that is commanded, across is positive to the left, in [m]; see
        `gaitlab.log.course`. Shape (n, 2); rows before the start-up's end are relative to the same
        origin.
        """
        origin = max(self.walking.start - 1, 0)
        heading = self["yaw"][origin]
        xy = self.vector("trunk_", "xy")
        x, y = (xy - xy[origin]).T
        along = x * np.cos(heading) + y * np.sin(heading)
        across = y * np.cos(heading) - x * np.sin(heading)
        return self.header.course.of(along, across)

    @property
    def distance(self) -> float:
        """Distance walked along the commanded way, in [m], negative the wrong way; NaN if none."""
        walked = self.displacement[self.walking, 0]
        return float(walked[-1]) if len(walked) else nan

    @cached_property
    def work(self) -> float:
        """Positive mechanical work of all servos over the walk, in [J]; NaN if none."""
        power = self.joint_power[self.walking]
        return float(np.maximum(power, 0.0).sum()) * self.header.dt if power.size else nan

    @cached_property
    def joint_power(self) -> np.ndarray:
        """Mean mechanical power of every joint with a servo over each tick, in [W].

        A row holds the torque that acted during its tick and the velocity after it. Under a
        constant torque the mean velocity of a tick is the middle of those before and after, so
        that the work of a tick is just what it adds to the kinetic energy. The first row, before
        which nothing is known, takes its own velocity. Shape (n, driven joints).
        """
        velocity = self.driven_table("velocity")
        before = np.concatenate([velocity[:1], velocity[:-1]])
        power: np.ndarray = self.driven_table("torque") * (0.5 * (before + velocity))
        return power

    @property
    def stalled(self) -> bool:
        """Whether the robot stayed up but covered less than half of the commanded distance."""
        if self.fall_index is not None or not self.commanded_distance:
            return False
        return self.distance < STALL_SHARE * self.commanded_distance

    @cached_property
    def cycles(self) -> tuple[slice, ...]:
        """Rows of each complete gait cycle that was walked, in order."""
        period = self.header.gait_period / self.header.dt
        # A trial may end on the last row before the cycle's end.
        count = int((self.walking.stop - self.walking.start + 1.1) / period)
        edges = self.walking.start + np.rint(np.arange(count + 1) * period).astype(int)
        edges = np.minimum(edges, self.walking.stop)
        return tuple(slice(int(a), int(b)) for a, b in pairwise(edges) if a < b)

    @cached_property
    def _clear_cycles(self) -> tuple[slice, ...]:
        """Cycles that end a whole period ahead of the fall; all of them without one."""
        ahead = round(self.header.gait_period / self.header.dt)
        last = self.walking.stop - (0 if self.fall_index is None else ahead)
        return tuple(cycle for cycle in self.cycles if cycle.stop <= last)

    @property
    def steady_cycles(self) -> tuple[slice, ...]:
        """Cycles from the third on that are clear of the fall by a whole period."""
        return self._clear_cycles[2:]

    @property
    def measured_cycles(self) -> tuple[slice, ...]:
        """The steady cycles; when fewer than two, all clear of the fall; when none, all."""
        if len(self.steady_cycles) >= 2:
            return self.steady_cycles
        return self._clear_cycles or self.cycles

    @cached_property
    def swings(self) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
        """Rows of every completed swing of the left and of the right foot.

        A foot swings while it carries less than `SWING_LOAD` of the weight, for no less than
        `SHORTEST_SWING` of the gait period: brushing blades make no stance, chatter no step.
        """
        loaded = self.per_foot("normal_force")[self.walking] >= SWING_LOAD * self.header.weight
        return self._gaps(loaded[:, 0]), self._gaps(loaded[:, 1])

    def _gaps(self, loaded: np.ndarray) -> tuple[slice, ...]:
        change = np.diff(loaded.astype(np.int8))
        lifts, landings = np.flatnonzero(change < 0) + 1, np.flatnonzero(change > 0) + 1
        landings = landings[landings > lifts[0]] if len(lifts) else landings[:0]
        shortest = SHORTEST_SWING * self.header.gait_period / self.header.dt
        start = self.walking.start
        return tuple(
            slice(start + int(a), start + int(b))
            for a, b in zip(lifts, landings, strict=False)
            if b - a >= shortest
        )
