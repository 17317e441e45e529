"""What a search has tried, and which of it is best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Study

State: TypeAlias = Literal["done", "pruned", "infeasible"]


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
    state: State
    objectives: tuple[float, ...]
    violations: tuple[float, ...]
    feasible: bool
    seeds: int
    trial_ids: tuple[str, ...]
    batch: int
    simulated: float
    reason: str = ""


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
        derived = {
            "front": front,
            "best": self._best(front) if len(self.study.objectives) == 1 else None,
            "used": sum(candidate.simulated for candidate in self.candidates),
            "planned": sum(self._in_full(candidate) for candidate in self.candidates),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    def _best(self, front: Sequence[Candidate]) -> Candidate | None:
        standing = pareto_front(self.study, self.finals)
        return next(iter((*standing, *front)), None)

    @property
    def study(self) -> Study:
        """What the file asks for."""
        study = self.experiment.study
        if study is None:
            raise ValueError(f"{self.experiment.name} is no study")
        return study

    @property
    def saving(self) -> float:
        """Share of the simulated time that racing saved, in [0, 1]."""
        return 1.0 - self.used / self.planned if self.planned else 0.0

    def _in_full(self, candidate: Candidate) -> float:
        """Simulated time with every seed, the remaining ones taken like those that walked."""
        if candidate.state != "pruned" or not candidate.seeds:
            return candidate.simulated
        return candidate.simulated * len(self.experiment.seeds) / candidate.seeds


def costs(study: Study, candidate: Candidate) -> tuple[float, ...]:
    """The objectives with their signs turned such that less is better."""
    return tuple(
        -value if objective.direction == "maximize" else value
        for objective, value in zip(study.objectives, candidate.objectives, strict=True)
    )


def pareto_front(study: Study, candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The finished candidates that break no constraint and that none of them beats.

    In the order of their objectives, the best first; of equal ones, the earlier.
    """
    finished = [c for c in candidates if c.state == "done" and c.feasible]
    ranked = sorted(finished, key=lambda c: (costs(study, c), c.number))
    front: list[Candidate] = []
    for candidate in ranked:  # whoever beats it, or equals it, stands before it
        cost = costs(study, candidate)
        if not any(_no_worse(costs(study, other), cost) for other in front):
            front.append(candidate)
    return tuple(front)


def _no_worse(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(a <= b for a, b in zip(one, other, strict=True))
