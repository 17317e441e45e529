"""The tests of the gate: each asks whether one quantity got worse.

Seeds are the independent units: what a seed draws, it draws in every cell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, nan
from typing import Literal, TypeAlias

import numpy as np

from gaitlab.metrics import better
from gaitlab.regression.baseline import METRICS
from gaitlab.regression.matching import Matched
from gaitlab.statistics import (
    Alternative,
    clustered_rank_sum,
    holm,
    sign_flip,
    stratified_difference,
)

FALSE_ALARMS = 0.01  # of nights without any change; all tests of a night together
Finding: TypeAlias = Literal["worse", "better", "as before", "undecided"]


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One quantity, tonight against the baseline.

    Attributes:
        name: `stable`, or the name of a metric.
        surface: Ground it is taken on; empty for all.
        before: Share or mean of the baseline.
        tonight: The same of tonight.
        n: Pairs, or without pairs the walks of the smaller side.
        seeds: Independent units among them; of the smaller side without pairs.
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
    seeds: int
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
    worse = holm([quantity.p_worse for quantity in found])
    improved = holm([quantity.p_better for quantity in found])
    return [
        replace(quantity, finding=_finding(p, q))
        for quantity, p, q in zip(found, worse, improved, strict=True)
    ]


def test_count(surfaces: int) -> int:
    """Tests of a night over this many grounds."""
    return 1 + (surfaces if surfaces > 1 else 0) + len(METRICS)


def _finding(worse: float, improved: float) -> Finding:
    if worse < FALSE_ALARMS:
        return "worse"
    return "better" if improved < FALSE_ALARMS else "as before"


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
        seeds=min(runs.seed_counts("stable")),
        p_worse=_p(runs, "stable", "less"),
        p_better=_p(runs, "stable", "greater"),
    )


def _metric(runs: Matched, name: str) -> Quantity:
    values = runs.values(name)
    if not values:
        return Quantity(
            name=name, surface="", before=nan, tonight=nan, n=0, seeds=0, p_worse=1.0, p_better=1.0
        )
    base = float(np.mean([np.mean(before) for _, before in values]))
    down, up = _p(runs, name, "less"), _p(runs, name, "greater")
    worse, improved = (up, down) if better(name) == "lower" else (down, up)
    return Quantity(
        name=name,
        surface="",
        before=base,
        tonight=base + stratified_difference(values),
        n=sum(min(len(a), len(b)) for a, b in values),
        seeds=min(runs.seed_counts(name)),
        p_worse=worse,
        p_better=improved,
    )


def _p(runs: Matched, name: str, alternative: Alternative) -> float:
    if runs.paired:
        return sign_flip(runs.seed_changes(name), alternative)
    return clustered_rank_sum(runs.values(name), runs.seeds(name), alternative)
