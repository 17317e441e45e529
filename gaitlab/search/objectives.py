"""How good a candidate of a study is, from its trials: objectives, constraints, feasibility.

Pure and without an opinion on how the search goes on. What a fallen trial counts as is said in
`gaitlab.experiment.study`. Seeds become one number on each surface first, surfaces one number
second.

References:
    Rockafellar2000: Rockafellar and Uryasev, Optimization of conditional value-at-risk, Journal
        of Risk 2(3), 2000.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor, fsum, inf, isfinite, nan
from typing import Literal

from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.experiment.study import (
    Aggregate,
    Constraint,
    Direction,
    Objective,
    Study,
    is_measured,
    worst,
)
from gaitlab.metrics import Value
from gaitlab.store import Index, State

NO_VALUE = 0.1  # added to the loss when an objective has no value, if only for want of its metric
UNWALKED = 2.0  # loss of a trial that never walked; a fall at the first instant loses 1
FARTHEST = 10.0  # bounds; a miss by more is as bad as this, and only one without a value is worse
ROUNDING = 1e-9  # trials; forgives 0.1 x 30 being above 3
TO_THE_END = "walking to the end"  # what the last violation asks for


@dataclass(frozen=True, kw_only=True)
class TrialOutcome:
    """What became of one trial of a candidate.

    Attributes:
        surface: What the ground is called.
        seed: Its replicate.
        state: `DONE` (a fall is done), `INFEASIBLE`, `FAILED`, or `MISSING` while the store lacks
            it.
        metrics: Metric name to value; None or missing where it is not defined.
        trial_id: Identity of the trial; empty where nobody asks for it.
    """

    surface: str
    seed: int
    state: State | Literal["MISSING"]
    metrics: Mapping[str, Value]
    trial_id: str = ""

    @property
    def walked(self) -> bool:
        """Whether it was simulated to its end or to a fall."""
        return self.state == "DONE"

    @property
    def fell(self) -> bool:
        """Whether it walked and fell."""
        return self.walked and bool(self.metrics.get("fell"))

    @property
    def stable(self) -> bool:
        """Whether the robot stayed on its feet to the horizon."""
        return self.walked and bool(self.metrics.get("stable"))


def outcome_of(
    planned: PlannedTrial, state: State | Literal["MISSING"], metrics: Mapping[str, Value]
) -> TrialOutcome:
    """What became of a planned trial that ended in a state."""
    return TrialOutcome(
        surface=str(planned.values["surface"]),
        seed=planned.trial.seed,
        state=state,
        metrics=metrics,
        trial_id=planned.trial.id,
    )


def stored_outcome(planned: PlannedTrial, index: Index) -> TrialOutcome:
    """What a store says of a planned trial."""
    entry = index.entries.get(planned.trial.id)
    if entry is None:
        return outcome_of(planned, "MISSING", {})
    return outcome_of(planned, entry.state, entry.details.metrics)


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """How good a candidate is.

    Attributes:
        objectives: In the order of the study, each in its metric's unit and own direction;
            infinitely bad when too many trials are lost for the objective to have a value.
        violations: One a constraint, in the order of the study, and one for trials lost to falls
            and to poses out of reach; above 0 is not allowed, 1 misses a bound by its own size.
            Always finite.
        feasible: Whether no violation is above 0.
        n: Number of trials.
    """

    objectives: tuple[float, ...]
    violations: tuple[float, ...]
    feasible: bool
    n: int


def evaluate(study: Study, outcomes: Iterable[TrialOutcome]) -> Evaluation:
    """How good a candidate with these outcomes is, in whatever order they came.

    Raises:
        ValueError: If there are none.
    """
    trials = list(outcomes)
    if not trials:
        raise ValueError("a candidate without trials cannot be judged")
    objectives = tuple(score(objective, trials) for objective in study.objectives)
    missed = tuple(_violation(constraint, trials) for constraint in study.constraints)
    fulfilled = all(violation <= 0.0 for violation in missed)
    violations = (*missed, _loss(trials, all(map(isfinite, objectives)), fulfilled))
    return Evaluation(
        objectives=objectives,
        violations=violations,
        feasible=all(violation <= 0.0 for violation in violations),
        n=len(trials),
    )


def violation_names(study: Study) -> tuple[str, ...]:
    """What each violation of an evaluation is about."""
    return (*(constraint.text for constraint in study.constraints), TO_THE_END)


def misses(study: Study, objectives: Sequence[float], violations: Sequence[float]) -> list[str]:
    """What a candidate that is not allowed lacks, in words, from its evaluation.

    A number in brackets is what it misses in sizes of the bound.
    """
    found = []
    for constraint, violation in zip(study.constraints, violations, strict=False):
        if violation > FARTHEST + NO_VALUE + ROUNDING:
            found.append(f"{constraint.text}, for a fall leaves it without a value")
        elif violation > FARTHEST:
            found.append(f"{constraint.metric}, which has no value in these walks")
        elif violation > 0.0:
            least = "at least " if violation == FARTHEST else ""
            found.append(f"{constraint.text} ({least}{violation:.3g})")
    undefined = [
        objective.metric
        for objective, value in zip(study.objectives, objectives, strict=False)
        if not isfinite(value)
    ]
    lost = violations[-1] - (NO_VALUE if undefined else 0.0)
    if lost > ROUNDING:
        found.append(f"{TO_THE_END} ({lost:.3g})")
    elif undefined:
        found.append(f"{' and '.join(undefined)}, which has no value in these walks")
    return found


def score(wanted: Objective | Constraint, trials: Sequence[TrialOutcome]) -> float:
    """Value of an objective, or of what a constraint bounds, over all trials."""
    return combined(wanted, [(trial.surface, counted(wanted, trial)) for trial in trials])


def combined(wanted: Objective | Constraint, numbers: Iterable[tuple[str, float]]) -> float:
    """The same from what each trial counts as, with its surface."""
    by_surface: dict[str, list[float]] = {}
    for surface, number in numbers:
        by_surface.setdefault(surface, []).append(number)
    seeds = [
        aggregated(wanted.over_seeds, values, wanted.direction) for values in by_surface.values()
    ]
    return aggregated(wanted.over_surfaces, seeds, wanted.direction)


def counted(wanted: Objective | Constraint, trial: TrialOutcome) -> float:
    """What one trial counts as; a fall never counts for more than staying up would."""
    least = worst(wanted.metric, wanted.direction) if wanted.fallen is None else wanted.fallen
    measured = is_measured(wanted.metric, wanted.direction) and wanted.fallen is None
    value = _number(trial.metrics.get(wanted.metric)) if trial.walked else nan
    if not isfinite(value) or (trial.fell and not measured):
        return least
    return max(value, least) if wanted.direction == "maximize" else min(value, least)


def _number(value: Value) -> float:
    return float(value) if isinstance(value, bool | int | float) else nan


def aggregated(how: Aggregate, values: Sequence[float], direction: Direction) -> float:
    """Many numbers as one; `cvar` as [Rockafellar2000], with the last number counted in part.

    A quantile is a number that occurs, the better of two is never taken: of 8 seeds
    `quantile: 0.5` is the fourth worst.
    """
    ranked = sorted(values, reverse=direction == "minimize")  # the worst first
    n = len(ranked)
    if how.kind == "mean":
        return fsum(ranked) / n
    if how.kind == "worst":
        return ranked[0]
    if how.kind == "quantile":
        return ranked[max(1, ceil(how.share * n - ROUNDING)) - 1]
    count = max(how.share * n, 1.0)  # of the worst, which need not be whole
    whole = min(floor(count + ROUNDING), len(ranked))
    part = count - whole
    rest = [part * ranked[whole]] if part > ROUNDING else []
    return fsum([*ranked[:whole], *rest]) / (whole + (part if rest else 0.0))


def _violation(constraint: Constraint, trials: Sequence[TrialOutcome]) -> float:
    """How far a constraint is missed, in sizes of its bound; more than FARTHEST with losses."""
    value = score(constraint, trials)
    if not isfinite(value):
        return FARTHEST + NO_VALUE + _mean_loss(trials)
    missing = constraint.bound - value if constraint.at_least else value - constraint.bound
    return min(missing / (abs(constraint.bound) or 1.0), FARTHEST)


def _loss(trials: Sequence[TrialOutcome], valued: bool, fulfilled: bool) -> float:
    """How badly trials were lost; 0 for a candidate that is allowed.

    A candidate that misses a constraint anyway is told apart by how soon it fell, because a
    search that starts among gaits that all fall has nothing else to go by.
    """
    if not valued:
        return NO_VALUE + _mean_loss(trials)
    allowed = fulfilled and all(trial.walked for trial in trials)
    return 0.0 if allowed else _mean_loss(trials)


def _mean_loss(trials: Sequence[TrialOutcome]) -> float:
    return fsum(_lost_share(trial) for trial in trials) / len(trials)


def _lost_share(trial: TrialOutcome) -> float:
    """0 for a trial on its feet, up to 1 the sooner the robot fell, more if it never walked."""
    if not trial.walked:
        return UNWALKED
    if not trial.fell:
        return 0.0
    walked = _number(trial.metrics.get("walked_time"))
    return 1.0 / (1.0 + walked) if 0.0 <= walked < inf else 1.0


def missing(experiment: Experiment, index: Index) -> list[str]:
    """Trials of an experiment that a store does not hold."""
    trials = (item.trial.id for item in plan(experiment).trials())
    return [trial_id for trial_id in trials if trial_id not in index.entries]
