"""What was walked after a search: its best again on fresh seeds, and steps around its values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gaitlab.experiment import Value

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
