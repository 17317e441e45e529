"""The tests of the gate: whether a quantity got worse, and what such a test would notice.

Seeds are the independent units: what a seed draws, it draws in every cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Literal, TypeAlias

import numpy as np

from gaitlab.metrics import lookup
from gaitlab.regression.baseline import METRICS, Walk
from gaitlab.regression.matching import MatchedWalks
from gaitlab.statistics import Runs, detectable_drop, detectable_shift, holm

FALSE_ALARMS = 0.01  # of nights without any change; all tests of a night together
COARSEST = 0.5  # drop of the stable share; a gate that misses a larger one is none
MOST_SEEDS = 500  # a cell; nobody walks more
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


def tested(runs: MatchedWalks) -> list[Quantity]:
    """Every test of the gate with its finding; stability first, over all and on each ground."""
    grounds = runs.surfaces if len(runs.surfaces) > 1 else []
    asked = [("stable", name) for name in ("", *grounds)] + [(name, "") for name in METRICS]
    parts = [(name, surface, runs.on(surface).runs(name)) for name, surface in asked]
    found = [_quantity(*part) for part in parts if len(part[2].first.values)]
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


def _quantity(name: str, surface: str, runs: Runs) -> Quantity:
    before, tonight = runs.means
    less, more = runs.p_value("less"), runs.p_value("greater")
    lower_is_better = name != "stable" and lookup(name).better == "lower"
    return Quantity(
        name=name,
        surface=surface,
        before=before,
        tonight=tonight,
        n=runs.n,
        seeds=min(runs.seeds),
        p_worse=more if lower_is_better else less,
        p_better=less if lower_is_better else more,
    )


def noticed(runs: MatchedWalks, quantities: Sequence[Quantity]) -> list[Quantity]:
    """The quantities with the smallest change for the worse that is found in four nights of five.

    At the strictest level of Holm, as if nothing else got worse.
    """
    level = FALSE_ALARMS / len(quantities)
    return [replace(q, detectable=_detectable(runs.on(q.surface), q, level)) for q in quantities]


def too_few(
    cells: Sequence[Sequence[Walk]], seeds: int, *, paired: bool, coarsest: float = COARSEST
) -> str:
    """Why a gate over these cells would not notice a large loss of stability; empty if it would.

    Args:
        cells: Walks of the baseline, cell by cell.
        seeds: That can be compared; of the smaller side if there are no pairs.
        paired: Whether both sides have the same seeds.
        coarsest: Smallest drop of the stable share that must show at the latest.
    """
    surfaces = {walk.cell.get("surface") for cell in cells for walk in cell}
    level = FALSE_ALARMS / test_count(len(surfaces))
    outcomes = _outcomes(cells)
    if detectable_drop(outcomes, seeds, level, paired=paired) <= coarsest:
        return ""
    tries = (n for n in sorted({round(1.15**k) for k in range(1, 46)}) if seeds < n <= MOST_SEEDS)
    enough = (n for n in tries if detectable_drop(outcomes, n, level, paired=paired) <= COARSEST)
    needed = next(enough, None) if np.nansum(outcomes) else None
    advice = (
        f"some {needed} seeds a cell would do, in the experiment and in the baseline"
        if needed
        else "more seeds do not help: choose cells in which the robot stays up more often"
    )
    return (
        f"too few walks to tell: with {seeds} seeds a cell in {len(cells)} cells, "
        f"{100.0 * float(np.nanmean(outcomes)):.0f} % of them stable, a loss of "
        f"{100.0 * COARSEST:.0f} points of stability could pass unseen; {advice}"
    )


def _detectable(runs: MatchedWalks, quantity: Quantity, level: float) -> float:
    if quantity.name == "stable":
        outcomes = _outcomes([cell.before for cell in runs.cells])
        return detectable_drop(outcomes, quantity.seeds, level, paired=runs.paired)
    values = _scatter(runs.runs(quantity.name))
    if not values.size:
        return inf
    return detectable_shift(values, quantity.seeds, level, paired=runs.paired)


def _scatter(runs: Runs) -> np.ndarray:
    """How values scatter about the mean of their cell, NaN for none. Shape (seeds, cells).

    Of the differences of pairs; if all of a cell are alike, of its baseline as if both sides were
    fresh. Without pairs of the baseline. Cells without any scatter are left out.
    """
    columns = []
    for (now, then), (_, labels) in zip(runs.strata, runs.labels, strict=True):
        found = then - then.mean()
        if runs.paired:
            gap = now - then
            found = gap - gap.mean() if np.ptp(gap) > 0.0 else sqrt(2.0) * found
        if np.any(found):
            columns.append(dict(zip(labels.tolist(), found.tolist(), strict=True)))
    seeds = sorted(set().union(*columns))
    return np.array([[column.get(seed, np.nan) for column in columns] for seed in seeds])


def _outcomes(cells: Sequence[Sequence[Walk]]) -> np.ndarray:
    """1 for a stable walk, 0 for another, NaN for none. Shape (seeds, cells)."""
    seeds = sorted({walk.seed for cell in cells for walk in cell})
    outcomes = np.full((len(seeds), len(cells)), np.nan)
    for column, cell in enumerate(cells):
        for walk in cell:
            outcomes[seeds.index(walk.seed), column] = walk.stable
    return outcomes
