"""The tests of the gate: each asks whether one quantity got worse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, nan, sqrt
from typing import Literal, TypeAlias

import numpy as np

from gaitlab.metrics import better
from gaitlab.regression.baseline import METRICS
from gaitlab.regression.matching import Matched
from gaitlab.statistics import (
    Alternative,
    Count,
    clustered_rank_sum,
    detectable_drop,
    detectable_mean,
    holm,
    mcnemar,
    signed_rank,
    stratified_difference,
)

FALSE_ALARMS = 0.01  # of nights without any change; all tests of a night together
Finding: TypeAlias = Literal["worse", "better", "as before"]


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One quantity, tonight against the baseline.

    Attributes:
        name: `stable`, or the name of a metric.
        surface: Ground it is taken on; empty for all.
        before: Share or mean of the baseline.
        tonight: The same of tonight.
        n: Pairs, or without pairs the walks of the smaller side.
        p_worse: Chance of so large a change for the worse if nothing changed.
        p_better: The same for the better.
        detectable: Smallest change for the worse that is found in four nights of five.
        finding: What can be said, all tests of the night together.
    """

    name: str
    surface: str
    before: float
    tonight: float
    n: int
    p_worse: float
    p_better: float
    detectable: float = inf
    finding: Finding = "as before"

    @property
    def difference(self) -> float:
        """Tonight less before."""
        return self.tonight - self.before


def tested(runs: Matched) -> list[Quantity]:
    """Every test of the gate with its finding; stability first, over all and on each ground."""
    grounds = runs.surfaces if len(runs.surfaces) > 1 else []
    parts = [("", runs), *((name, runs.on(name)) for name in grounds)]
    found = [_stability(part, name) for name, part in parts]
    found += [quantity for name in METRICS if (quantity := _metric(runs, name)).n]
    level = FALSE_ALARMS / len(found)
    worse = holm([quantity.p_worse for quantity in found])
    improved = holm([quantity.p_better for quantity in found])
    return [
        _judged(quantity, runs, level, p, q)
        for quantity, p, q in zip(found, worse, improved, strict=True)
    ]


def least_drop(cells: list[Count], tests: int) -> float:
    """Smallest drop of the stable share that these cells show among this many tests."""
    return detectable_drop(cells, FALSE_ALARMS / tests)


def test_count(surfaces: int) -> int:
    """Tests of a night over this many grounds."""
    return 1 + (surfaces if surfaces > 1 else 0) + len(METRICS)


def _judged(
    quantity: Quantity, runs: Matched, level: float, worse: float, improved: float
) -> Quantity:
    part = runs.on(quantity.surface) if quantity.surface else runs
    finding: Finding = "as before"
    if worse < FALSE_ALARMS or improved < FALSE_ALARMS:
        finding = "worse" if worse < FALSE_ALARMS else "better"
    return replace(quantity, detectable=_detectable(part, quantity.name, level), finding=finding)


def _stability(runs: Matched, surface: str) -> Quantity:
    counts = runs.counts()
    tonight, before = (sum(pair[k].successes for pair in counts) for k in (0, 1))
    sizes = [sum(pair[k].n for pair in counts) for k in (0, 1)]
    return Quantity(
        name="stable",
        surface=surface,
        before=before / sizes[1],
        tonight=tonight / sizes[0],
        n=runs.n,
        p_worse=_p_stable(runs, "less"),
        p_better=_p_stable(runs, "greater"),
    )


def _p_stable(runs: Matched, alternative: Alternative) -> float:
    if not runs.paired:
        return clustered_rank_sum(runs.values("stable"), runs.seeds("stable"), alternative)
    pairs = ((tonight.stable, before.stable) for tonight, before in runs.pairs())
    return mcnemar(pairs, alternative).p_value


def _metric(runs: Matched, name: str) -> Quantity:
    values = runs.values(name)
    if not values:
        return Quantity(
            name=name, surface="", before=nan, tonight=nan, n=0, p_worse=1.0, p_better=1.0
        )
    base = float(np.mean([np.mean(before) for _, before in values]))
    down, up = _p_metric(runs, name, "less"), _p_metric(runs, name, "greater")
    worse, improved = (up, down) if better(name) == "lower" else (down, up)
    return Quantity(
        name=name,
        surface="",
        before=base,
        tonight=base + stratified_difference(values),
        n=sum(min(len(a), len(b)) for a, b in values),
        p_worse=worse,
        p_better=improved,
    )


Values = list[tuple[np.ndarray, np.ndarray]]


def _p_metric(runs: Matched, name: str, alternative: Alternative) -> float:
    values = runs.values(name)
    if not runs.paired:
        return clustered_rank_sum(values, runs.seeds(name), alternative)
    return signed_rank(np.concatenate([a - b for a, b in values]), alternative)


def _detectable(runs: Matched, name: str, level: float) -> float:
    if name == "stable":
        drop = detectable_drop([_at_least(*pair) for pair in runs.counts()], level)
        return drop if runs.paired else max(drop, _between_seeds(runs, name, level))
    if not runs.paired:
        return _between_seeds(runs, name, level)
    return detectable_mean(*_deviation(runs.values(name)), level)


def _between_seeds(runs: Matched, name: str, level: float) -> float:
    """Smallest difference of means that as many other seeds show, by how seeds differ."""
    means: dict[float, list[float]] = {}
    for (_, values), (_, seeds) in zip(runs.values(name), runs.seeds(name), strict=True):
        for value, seed in zip(values - values.mean(), seeds.tolist(), strict=True):
            means.setdefault(seed, []).append(float(value))
    others = {seed for tonight, _ in runs.seeds(name) for seed in tonight.tolist()}
    if len(means) < 2 or not others:
        return inf
    deviation = float(np.std([np.mean(gaps) for gaps in means.values()], ddof=1))
    return detectable_mean(sqrt(2.0) * deviation, min(len(means), len(others)), level)


def _at_least(tonight: Count, before: Count) -> Count:
    """The baseline's share at the smaller of the two numbers of walks."""
    n = min(tonight.n, before.n)
    return Count(round(n * before.successes / before.n), n)


def _deviation(values: Values) -> tuple[float, float]:
    """Standard deviation of a difference within cells, and how many differences there are."""
    gaps = [a - b for a, b in values]
    n = float(sum(min(len(a), len(b)) for a, b in values))
    spread = _pooled(gaps)
    if spread > 0.0:
        return spread, n
    return sqrt(2.0) * _pooled([before for _, before in values]), n


def _pooled(groups: list[np.ndarray]) -> float:
    """Standard deviation within groups; 0 if none has two values."""
    freedom = sum(len(group) - 1 for group in groups)
    if freedom <= 0:
        return 0.0
    return sqrt(sum(float(np.sum((g - g.mean()) ** 2)) for g in groups) / freedom)
