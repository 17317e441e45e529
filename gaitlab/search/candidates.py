"""What a search has tried, and which of it is best."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import fsum, log
from typing import Literal, TypeAlias, TypeVar

from gaitlab.experiment import Experiment, Value, study_of
from gaitlab.experiment.study import Choices, Numbers, Study

T = TypeVar("T")
CandidateState: TypeAlias = Literal["done", "pruned", "infeasible"]
NEAR = 0.02  # of its range; a value so close to an end asks for a wider range


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One combination of values that was tried.

    Attributes:
        number: Position in the order of the search, from 0.
        values: Value of each searched parameter by dotted path, without those whose condition
            does not hold.
        state: `done` with every seed, `pruned` before that, `infeasible` if the robot cannot
            take a pose or the gait refuses the values.
        objectives: In the order and the unit of the file, over the seeds that were walked; empty
            if there is none.
        violations: By how much each constraint is missed, as a share of its bound; fulfilled at
            0 or below.
        feasible: Whether it is not infeasible and every constraint holds.
        seeds: Seeds that it walked with.
        trial_ids: Its trials.
        batch: Number of candidates before those that were proposed together with it.
        simulated: Simulated time of its trials, in [s].
        reason: Why it was pruned or is infeasible, one line.
    """

    number: int
    values: Mapping[str, Value]
    state: CandidateState
    objectives: tuple[float, ...]
    violations: tuple[float, ...]
    feasible: bool
    seeds: int
    trial_ids: tuple[str, ...]
    batch: int
    simulated: float
    reason: str = ""

    @property
    def missed_by(self) -> float:
        """Sum of what it misses, in sizes of the bounds."""
        return fsum(max(0.0, violation) for violation in self.violations)


@dataclass(frozen=True, kw_only=True)
class History:
    """A search so far.

    Attributes:
        experiment: What was searched; its `study` is there.
        candidates: In the order of their numbers.
        finals: The finalists with the seeds of the final; empty until it was held.
        best: Of one objective, the best of the candidates with all seeds that break no constraint;
            after the final its winner.
        front: Of those, all that no other one beats in every objective.
        used: Simulated time of all their trials, in [s].
        planned: The same had every candidate walked with every seed, estimated from what each
            one walked, in [s].
    """

    experiment: Experiment
    candidates: tuple[Candidate, ...]
    finals: tuple[Candidate, ...] = ()
    best: Candidate | None = field(init=False)
    front: tuple[Candidate, ...] = field(init=False)
    used: float = field(init=False)
    planned: float = field(init=False)

    def __post_init__(self) -> None:
        front = pareto_front(self.study, self.candidates)
        best = next(iter((*pareto_front(self.study, self.finals), *front)), None)
        derived = {
            "front": front,
            "best": best if len(self.study.objectives) == 1 else None,
            "used": sum(candidate.simulated for candidate in self.candidates),
            "planned": sum(self._in_full(candidate) for candidate in self.candidates),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def study(self) -> Study:
        """What the file asks for."""
        return study_of(self.experiment)

    @property
    def representative(self) -> Candidate | None:
        """The candidate that stands for the search: the best, or the middle one of the front."""
        if self.best is not None or not self.front:
            return self.best
        return self.front[len(self.front) // 2]

    @property
    def last_improvement(self) -> int:
        """Number of the candidate with which the search last got better; -1 before any.

        Better is a candidate of the front; while nothing is allowed, one that misses the
        constraints by less than all before it.
        """
        if self.front:
            return max(candidate.number for candidate in self.front)
        nearest = self.nearest_misses(1)
        return nearest[0].number if nearest else -1

    def nearest_misses(self, count: int) -> list[Candidate]:
        """Candidates that break the constraints by the least, the nearest first."""
        missed = [candidate for candidate in self.candidates if not candidate.feasible]
        return sorted(missed, key=lambda c: (c.missed_by, c.number))[:count]

    @property
    def saving(self) -> float:
        """Share of the simulated time that racing saved, in [0, 1]."""
        return 1.0 - self.used / self.planned if self.planned else 0.0

    def _in_full(self, candidate: Candidate) -> float:
        """Simulated time with every seed, the remaining ones taken like those that walked."""
        if candidate.state != "pruned" or not candidate.seeds:
            return candidate.simulated
        return candidate.simulated * len(self.experiment.seeds) / candidate.seeds


def costs(study: Study, objectives: Sequence[float]) -> tuple[float, ...]:
    """Objectives with their signs turned such that less is better."""
    pairs = zip(study.objectives, objectives, strict=True)
    return tuple(-value if o.direction == "maximize" else value for o, value in pairs)


def ranked(study: Study, candidates: Iterable[Candidate]) -> list[Candidate]:
    """The finished candidates that break no constraint, the best first; of equal ones, the earlier.

    With several objectives the first one counts most.
    """
    finished = [c for c in candidates if c.state == "done" and c.feasible]
    return sorted(finished, key=lambda c: (costs(study, c.objectives), c.number))


def pareto_front(study: Study, candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
    """The finished candidates that break no constraint and that none of them beats.

    In the order of their objectives, the best first; of equal ones, the earlier.
    """
    return unbeaten((costs(study, c.objectives), c) for c in ranked(study, candidates))


def unbeaten(rated: Iterable[tuple[Sequence[float], T]]) -> tuple[T, ...]:
    """What nothing before it beats or equals in every cost; given by rising costs."""
    front: list[tuple[Sequence[float], T]] = []
    for cost, item in rated:
        if not any(all(a <= b for a, b in zip(less, cost, strict=True)) for less, _ in front):
            front.append((cost, item))
    return tuple(item for _, item in front)


def moved(item: Numbers, start: float, end: float) -> float:
    """How far one value lies above another, in shares of the searched range or of its ratio."""
    if item.log:
        return log(end / start) / log(item.high / item.low)
    return (end - start) / (item.high - item.low)


def edge_of(item: Numbers | Choices, value: Value | None) -> str:
    """`lower` or `upper` if a value lies at the end of its range; empty elsewhere."""
    if isinstance(item, Choices) or value is None or isinstance(value, str):
        return ""
    share = moved(item, item.low, float(value))
    return "lower" if share <= NEAR else "upper" if share >= 1.0 - NEAR else ""


def edges(study: Study, candidate: Candidate) -> dict[str, str]:
    """Searched numbers of a candidate that lie at an end of their range, and at which."""
    found = {}
    for item in study.search:
        edge = edge_of(item, candidate.values.get(item.path))
        if edge and isinstance(item, Numbers):
            found[item.path] = f"{edge} end {item.low if edge == 'lower' else item.high:g}"
    return found
