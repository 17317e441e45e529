"""What the page of a study is computed from: its candidates, and what was walked after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, Protocol

from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Choices, Numbers, Study

WINNER, DEFAULT, RANDOM = "winner", "hand-set default", "best of random search"
Side = Literal["below", "above"]
Ending = Literal[
    "fell",
    "out of reach",
    "a walk failed",
    "no fall found",
    "not walked yet",
    "limit of the parameter",
]


class Candidate(Protocol):
    """One combination of values that the search tried."""

    @property
    def number(self) -> int:
        """Its place in the order of the search, from 0."""

    @property
    def values(self) -> Mapping[str, Value]:
        """Value by dotted path; a parameter whose condition fails is left out."""

    @property
    def state(self) -> Literal["done", "pruned", "infeasible"]:
        """Whether it walked with all seeds, was given up, or cannot be walked."""

    @property
    def objectives(self) -> tuple[float, ...]:
        """One number an objective, in the metric's unit; of the seeds that it walked with."""

    @property
    def violations(self) -> tuple[float, ...]:
        """One number a constraint, at most 0 where it is fulfilled."""

    @property
    def feasible(self) -> bool:
        """Whether all constraints hold."""

    @property
    def seeds(self) -> int:
        """How many seeds it walked with."""

    @property
    def batch(self) -> int:
        """Which batch it was proposed in, from 0."""


@dataclass(frozen=True, kw_only=True)
class Walk:
    """One trial after the search.

    Attributes:
        trial_id: Identity of the trial.
        surface: Ground.
        seed: Replicate.
        state: `DONE`, `INFEASIBLE`, `FAILED`, or `MISSING` while the store lacks it.
        metrics: Metrics by name; none unless it is done.
    """

    trial_id: str
    surface: str
    seed: int
    state: str
    metrics: Mapping[str, float | bool | int | str | None]

    @property
    def up(self) -> bool:
        """Whether the robot stayed on its feet to the horizon."""
        return bool(self.metrics.get("stable"))


@dataclass(frozen=True, kw_only=True)
class Rerun:
    """A combination of values on seeds that the search never saw.

    Attributes:
        label: What the combination is.
        values: Value by dotted path.
        walks: Its trials on every ground.
    """

    label: str
    values: Mapping[str, Value]
    walks: tuple[Walk, ...]

    def on(self, surfaces: Sequence[str]) -> tuple[Walk, ...]:
        """Trials on some grounds that have ended with a result."""
        there = (walk for walk in self.walks if walk.state in ("DONE", "INFEASIBLE"))
        return tuple(walk for walk in there if walk.surface in surfaces)


@dataclass(frozen=True, kw_only=True)
class Reach:
    """How far a parameter moves one way from the winner, everything else kept.

    Attributes:
        holds: Farthest value, in the parameter's unit, up to which no seed fell that stays up at
            the winner; the winner's own value if the first step is too far.
        fails: Nearest value at which one fell; None if none was found.
        ending: Why it goes no farther.
    """

    holds: float
    fails: float | None
    ending: Ending


@dataclass(frozen=True, kw_only=True)
class Margin:
    """How far one parameter can move before the robot falls.

    Attributes:
        path: Dotted path.
        value: The winner's value.
        below: Towards smaller values.
        above: Towards larger values.
    """

    path: str
    value: float
    below: Reach
    above: Reach


@dataclass(frozen=True, kw_only=True)
class Switch:
    """Whether the robot stays up with another option of a choice, everything else kept.

    Attributes:
        path: Dotted path.
        value: The winner's option.
        holds: Option to whether no seed fell that stays up at the winner.
    """

    path: str
    value: Value
    holds: Mapping[Value, bool]


@dataclass(frozen=True, kw_only=True)
class Margins:
    """Stability around the winner, one parameter at a time.

    Attributes:
        numbers: Of the parameters that are numbers.
        switches: Of those that are choices.
        seeds: How many seeds stay up at the winner on the study's grounds and were walked at
            every step; none means that nothing can be said.
        complete: Whether every step that is needed was walked.
    """

    numbers: tuple[Margin, ...] = ()
    switches: tuple[Switch, ...] = ()
    seeds: int = 0
    complete: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class Findings:
    """A study, its candidates, and what was walked after the search.

    Attributes:
        experiment: What was asked; its `study` is not None.
        candidates: In the order of the search.
        best: Of a single objective; None if nothing feasible walked with all seeds.
        front: Candidates that no other one beats in every objective; with a single objective the
            best alone, or nothing.
        finals: The best with the seeds of the final; empty while there was none.
        chosen: The winner that was walked again: the best, or the middle of the front.
        importance: Objective by its place to share by dotted path; empty if there is too little.
        used: Simulated time of all candidates, in [s].
        planned: Simulated time if every candidate had walked with all seeds, in [s].
        wall: Time of one core that the simulated time took, in [s]; 0 if unknown.
        defaults: Value of each searched parameter before the search; None if there is no single.
        reruns: What was walked on fresh seeds: the winner, the default, the best of random search.
        margins: Stability around the winner; None if it was not walked.
        drawn: Candidates of the search at random with the same budget; 0 if there was none.
        called: What the command line calls the study.
        facts: Name and Markdown text of where everything comes from.
        commands: What walks everything, and what makes the page again.
    """

    experiment: Experiment
    candidates: Sequence[Candidate]
    best: Candidate | None
    front: tuple[Candidate, ...]
    chosen: Candidate | None
    importance: Sequence[Mapping[str, float]]
    used: float
    planned: float
    wall: float
    defaults: Mapping[str, Value | None]
    reruns: tuple[Rerun, ...] = ()
    margins: Margins | None = None
    drawn: int = 0
    called: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)
    commands: Sequence[str] = ()
    finals: Sequence[Candidate] = ()

    @cached_property
    def study(self) -> Study:
        """What was searched.

        Raises:
            ValueError: If the experiment is no study.
        """
        if self.experiment.study is None:
            raise ValueError(f"{self.experiment.name} is no study")
        return self.experiment.study

    @property
    def grounds(self) -> tuple[str, ...]:
        """Grounds that the study tuned on."""
        return tuple(self.experiment.parts.surfaces)

    def rerun(self, label: str) -> Rerun | None:
        """One of the combinations on fresh seeds, if it was walked."""
        return next((rerun for rerun in self.reruns if rerun.label == label), None)

    def parameter(self, path: str) -> Numbers | Choices:
        """The searched parameter of a path."""
        return next(item for item in self.study.search if item.path == path)

    def unit(self, path: str) -> str:
        """SI unit of a searched parameter, empty for a ratio or a choice."""
        unit = self.experiment.parts.parameter(path).unit
        return "" if unit == "-" else unit
