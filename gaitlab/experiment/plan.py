"""All trials of an experiment, in the order of its file, made one at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import prod
from typing import Any, Protocol, runtime_checkable

from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment import (
    Experiment,
    Parts,
    Value,
    changed,
    changes_of,
    combinations,
    owned,
    try_out,
)
from gaitlab.experiment.loading import LARGEST_SEED
from gaitlab.model import Robot
from gaitlab.model.balance import Balance
from gaitlab.model.commands import require_playable, servos_for
from gaitlab.model.gait import Gait
from gaitlab.model.servo import Servo
from gaitlab.model.settings import SETTINGS
from gaitlab.plugins import label, load_class
from gaitlab.simulation.trial import Names, Plugin, Trial, duration, plugin

SAMPLED_CELLS = 32  # cells whose duration stands for all
TRAJECTORY = "trajectory"  # the gait that walks what a program wrote


@runtime_checkable
class WrittenWalk(Protocol):
    """A gait whose walk is written by a program of the team's own, before anything is walked."""

    @property
    def told(self) -> str:
        """The program and what it is given, for a message."""

    @property
    def runs(self) -> str:
        """The command as it is written, for whoever wants to know what code runs."""

    def walked(self, *, run: bool) -> Mapping[str, Any] | None:
        """Parameters of the trajectory that it writes; None if it has not and may not run.

        Raises:
            WrongValue: If it writes none.
        """


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One combination of varied values; its trials differ in the seed alone.

    Attributes:
        index: Position in the order of the plan.
        values: Value by dotted path, and the label of the ground under `surface`.
    """

    index: int
    values: Mapping[str, Value]


@dataclass(frozen=True, kw_only=True)
class PlannedTrial:
    """A trial and where it stands in its experiment.

    Attributes:
        trial: The trial.
        values: Varied values of its cell.
        cell_index: Position of its cell.
    """

    trial: Trial
    values: Mapping[str, Value]
    cell_index: int


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What an experiment amounts to. Sizes are counted, never expanded.

    Attributes:
        experiment: The experiment.
        programs: Whether programs that write its walks may run for it. If not, a walk that is not
            written yet is planned as if none had ever been walked.
    """

    experiment: Experiment
    programs: bool = True

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        rows = (len(axis.rows) for axis in self.experiment.axes)
        return prod(rows) * len(self.experiment.parts.surfaces)

    @property
    def size(self) -> int:
        """Number of trials."""
        return self.cell_count * len(self.experiment.seeds)

    def cells(self) -> Iterator[Cell]:
        """Cells in the order of the file: the first axis slowest, the surface fastest."""
        surfaces = self.experiment.parts.surfaces
        index = 0
        for values in combinations(self.experiment.axes):
            for name in surfaces:
                yield Cell(index=index, values={**values, "surface": name})
                index += 1

    def trials(self) -> Iterator[PlannedTrial]:
        """Trials cell by cell, seeds in the order of the file."""
        maker = _Maker(self.experiment, self.programs)
        for cell in self.cells():
            shared = maker.shared(cell.values)
            for seed in self.experiment.seeds:
                trial = Trial(**shared, seed=seed)
                yield PlannedTrial(trial=trial, values=cell.values, cell_index=cell.index)

    def trial(self, cell: Cell, seed: int) -> Trial:
        """The trial of a cell with any seed, those of the experiment or another.

        Raises:
            WrongValue: If a program writes no walk for it, or the seed is none.
        """
        if not 0 <= seed <= LARGEST_SEED:
            raise WrongValue(f"seed {seed}: a seed is a whole number from 0 to 2^63 - 1")
        return Trial(**_Maker(self.experiment, self.programs).shared(cell.values), seed=seed)

    def write_walks(self) -> None:
        """Have every walk written that a program writes, so that nothing has to wait for it later.

        Raises:
            WrongValue: If a program does not write one.
        """
        if self.written_by:
            maker = _Maker(self.experiment, programs=True)
            for cell in self.cells():
                maker.shared(cell.values)

    @property
    def written_by(self) -> list[str]:
        """Commands of the programs that write its walks; mostly none."""
        walkers = self.experiment.walkers.values() or [self.experiment.parts]
        return [parts.gait.runs for parts in walkers if isinstance(parts.gait, WrittenWalk)]

    def rounds(self) -> Iterator[tuple[int, PlannedTrial]]:
        """Trials seed by seed, so that every cell has one before any has two.

        Each comes with its place among `trials`.
        """
        maker, seeds = _Maker(self.experiment, self.programs), self.experiment.seeds
        for number, seed in enumerate(seeds):
            for cell in self.cells():
                trial = Trial(**maker.shared(cell.values), seed=seed)
                planned = PlannedTrial(trial=trial, values=cell.values, cell_index=cell.index)
                yield cell.index * len(seeds) + number, planned

    @property
    def sample(self) -> list[Trial]:
        """One trial of each of some cells, evenly spaced over the plan."""
        maker, seed = _Maker(self.experiment, self.programs), self.experiment.seeds[0]
        every = max(1, self.cell_count // SAMPLED_CELLS)
        return [Trial(**maker.shared(values), seed=seed) for values in self._spaced(every)]

    @property
    def seconds(self) -> float:
        """Simulated seconds of a trial if the robot stays up, the mean over a sample of cells."""
        sample = self.sample
        return sum(duration(trial.gait, trial.horizon) for trial in sample) / len(sample)

    def _spaced(self, every: int) -> Iterator[Mapping[str, Value]]:
        """Every so many cells, found by index and not by counting through."""
        for index in range(0, self.cell_count, every):
            yield self.cell(index).values

    def cell(self, index: int) -> Cell:
        """Cell at a position in the order of the plan."""
        names = tuple(self.experiment.parts.surfaces)
        rest, place = divmod(index, len(names))
        values: dict[str, Value] = {}
        for axis in reversed(self.experiment.axes):
            rest, row = divmod(rest, len(axis.rows))
            values = {**dict(zip(axis.paths, axis.rows[row], strict=True)), **values}
        return Cell(index=index, values={**values, "surface": names[place]})


def plan(experiment: Experiment, *, programs: bool = True) -> Plan:
    """Plan of an experiment; see `Plan`."""
    return Plan(experiment=experiment, programs=programs)


@dataclass
class _Maker:
    """Makes what the trials of a cell share, each part once however many cells want it."""

    experiment: Experiment
    programs: bool
    made: dict[tuple[object, ...], Any] = field(default_factory=dict)

    def shared(self, values: Mapping[str, Value]) -> dict[str, Any]:
        """Arguments of the trials of a cell, but for the seed."""
        parts, name = self.experiment.parts_of(values), str(values["surface"])
        robot = self._part("robot", parts.robot, values)
        balance = self._balance(parts, robot, values)
        servos = self._servos(parts, robot, values)
        gait = self._part("gait", parts.gait, values)
        servos = self._driven(gait, robot, servos)
        gait, gait_code = self._walked(gait, parts.gait_code, robot, servos)
        return {
            "robot": robot,
            "gait": gait,
            "surface": self._part("surface", parts.surfaces[name], values, name),
            "servos": servos,
            **{name: self._part(name, getattr(parts, name), values) for name in SETTINGS},
            "names": Names(
                robot=str(values.get("robot", label(parts.robot_code.name))),
                gait=label(parts.gait_code.name),
                surface=name,
                balance=None if balance is None else parts.balance_name,
            ),
            "robot_code": parts.robot_code,
            "gait_code": gait_code,
            "balance": balance,
            "balance_code": None if balance is None else parts.balance_code,
            "metric_codes": parts.metric_codes,
        }

    def _part(self, group: str, owner: Any, values: Mapping[str, Value], name: str = "") -> Any:
        changes = changes_of(group, values)
        if group == "surface":
            changes = owned(owner, changes)
        key = (group, name, values.get("robot"), *changes.items())
        if key not in self.made:
            self.made[key] = changed(owner, changes) if changes else owner
            try_out(group, self.made[key])
        return self.made[key]

    def _driven(self, gait: Gait, robot: Robot, servos: tuple[Servo, ...]) -> tuple[Servo, ...]:
        """The servos as the gait drives them."""
        key = ("driven", id(gait), id(robot), servos)
        if key not in self.made:
            self.made[key] = servos_for(gait, robot, servos)
        driven: tuple[Servo, ...] = self.made[key]
        return driven

    def _walked(
        self, gait: Gait, code: Plugin, robot: Robot, servos: tuple[Servo, ...]
    ) -> tuple[Gait, Plugin]:
        """The gait, or the trajectory that a program writes for it, and its code."""
        if not isinstance(gait, WrittenWalk):
            return gait, code
        key = ("written", gait, id(robot), servos)
        if key not in self.made:
            found = gait.walked(run=self.programs)
            made = (gait, code)
            if found is not None:
                made = load_class("gait", TRAJECTORY)(**found), plugin("gait", TRAJECTORY)
                try:
                    require_playable(made[0], robot, servos)
                except FileError as error:
                    raise WrongValue(f"{gait.told}: {error}") from error
            self.made[key] = made
        walked: tuple[Gait, Plugin] = self.made[key]
        return walked

    def _balance(self, parts: Parts, robot: Robot, values: Mapping[str, Value]) -> Balance | None:
        changes = changes_of("balance", values)
        key = (
            "balance",
            values.get("robot"),
            *changes.items(),
            *changes_of("robot", values).items(),
        )
        if key not in self.made:
            self.made[key] = parts.balanced(changes, robot)
        balance: Balance | None = self.made[key]
        return balance

    def _servos(self, parts: Parts, robot: Robot, values: Mapping[str, Value]) -> tuple[Servo, ...]:
        changes = changes_of("servo", values)
        key = ("servo", values.get("robot"), *changes.items(), *changes_of("robot", values).items())
        if key not in self.made:
            self.made[key] = parts.servos(changes, robot)
        servos: tuple[Servo, ...] = self.made[key]
        return servos
