"""Objectives on seeds that the search never saw, with intervals from drawing the seeds again.

A seed stands for one draw of everything that differs between replicates, so whole seeds are drawn,
with all grounds they walked on, and two gaits are compared seed by seed.

References:
    Efron1979: Efron, Bootstrap methods: another look at the jackknife, Annals of Statistics, 1979.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from gaitlab.experiment.study import Constraint, Objective, Study
from gaitlab.search.fresh import Rerun
from gaitlab.search.objectives import TrialOutcome
from gaitlab.search.objectives import score as scored
from gaitlab.statistics import Count, Interval

RESAMPLES = 2000  # the ends of a 95 % interval settle to some 3 % of its width
ENDS = (0.025, 0.975)
SEED = 0  # of the resampling; the same walks give the same interval


class Score(NamedTuple):
    """A number with the interval that drawing the seeds again gives it, and the seeds drawn."""

    value: float
    interval: Interval
    seeds: int


def score(study: Study, walks: Sequence[TrialOutcome], place: int) -> Score:
    """One objective of some walks, in the metric's unit.

    Raises:
        ValueError: If there are no walks.
    """
    by_seed, objective = _by_seed(walks), study.objectives[place]
    return _resampled(sorted(by_seed), lambda seeds: _value(objective, by_seed, seeds))


def gain(study: Study, one: Rerun, other: Rerun, place: int, grounds: Sequence[str]) -> Score:
    """How much better one combination is than another on the same seeds; above 0 is better.

    Raises:
        ValueError: If they share no seed.
    """
    objective = study.objectives[place]
    sign = 1.0 if objective.direction == "maximize" else -1.0
    first, second = _by_seed(one.on(grounds)), _by_seed(other.on(grounds))

    def lead(seeds: Sequence[int]) -> float:
        here, there = _value(objective, first, seeds), _value(objective, second, seeds)
        return 0.0 if here == there else sign * (here - there)  # equally infinite is equal

    return _resampled(sorted(first.keys() & second.keys()), lead)


def constraint_value(constraint: Constraint, walks: Sequence[TrialOutcome]) -> float:
    """What a constraint bounds, over some walks, in the metric's unit."""
    return scored(constraint, walks)


def stable_of(walks: Sequence[TrialOutcome]) -> Count:
    """Walks that stayed on their feet among all."""
    return Count(sum(walk.stable for walk in walks), len(walks))


def verdict(lead: Score) -> str:
    """`better`, `worse` or `cannot tell`, by whether the interval of a lead excludes zero."""
    return (
        "better" if lead.interval.low > 0 else "worse" if lead.interval.high < 0 else "cannot tell"
    )


def optimism(told: float, again: float, objective: Objective) -> float | None:
    """How much better the search made a gait look than it is; None if that has no value."""
    if not (isfinite(told) and isfinite(again)):
        return None
    return told - again if objective.direction == "maximize" else again - told


def _by_seed(walks: Sequence[TrialOutcome]) -> dict[int, list[TrialOutcome]]:
    """Walks by seed, only those seeds that have walked on every ground."""
    grounds = {walk.surface for walk in walks}
    found: dict[int, list[TrialOutcome]] = {}
    for walk in walks:
        found.setdefault(walk.seed, []).append(walk)
    return {seed: outcomes for seed, outcomes in found.items() if len(outcomes) == len(grounds)}


def _value(
    wanted: Objective, by_seed: dict[int, list[TrialOutcome]], seeds: Sequence[int]
) -> float:
    return scored(wanted, [outcome for seed in seeds for outcome in by_seed[seed]])


def _resampled(seeds: Sequence[int], value: Callable[[Sequence[int]], float]) -> Score:
    """A value of all seeds, and its percentile interval when they are drawn again, [Efron1979]."""
    if not seeds:
        raise ValueError("an objective of no walks has no value")
    generator = np.random.default_rng(SEED)
    draws = generator.choice(np.array(seeds), size=(RESAMPLES, len(seeds)))
    values = [value([int(seed) for seed in draw]) for draw in draws]
    # Objectives can be infinitely bad, and nothing lies halfway to infinity.
    low, high = np.quantile(values, ENDS, method="inverted_cdf")
    return Score(value(seeds), Interval(float(low), float(high)), len(seeds))
