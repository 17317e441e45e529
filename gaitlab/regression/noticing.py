"""What the gate's tests would notice, and how many seeds it takes to notice enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, sqrt

import numpy as np

from gaitlab.regression.baseline import Walk
from gaitlab.regression.matching import Matched
from gaitlab.regression.quantities import FALSE_ALARMS, Quantity, test_count
from gaitlab.statistics import detectable_drop, detectable_shift

COARSEST = 0.5  # drop of the stable share; a gate that misses a larger one is none
MOST_SEEDS = 500  # a cell; nobody walks more


def noticed(runs: Matched, quantities: Sequence[Quantity]) -> list[Quantity]:
    """The quantities with the smallest change for the worse that is found in four nights of five.

    At the strictest level of Holm, as if nothing else got worse.
    """
    level = FALSE_ALARMS / len(quantities)
    return [
        replace(q, detectable=_detectable(runs.on(q.surface) if q.surface else runs, q, level))
        for q in quantities
    ]


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


def _detectable(runs: Matched, quantity: Quantity, level: float) -> float:
    tonight, before = runs.seed_counts(quantity.name)
    if quantity.name == "stable":
        outcomes = _outcomes([cell.before for cell in runs.cells])
        return detectable_drop(outcomes, min(tonight, before), level, paired=runs.paired)
    values = _scatter(runs, quantity.name)
    if not values.size:
        return inf
    return detectable_shift(values, min(tonight, before), level, paired=runs.paired)


def _scatter(runs: Matched, name: str) -> np.ndarray:
    """How values scatter about the mean of their cell, NaN for none. Shape (seeds, cells).

    Of the differences of pairs; if all of a cell are alike, of its baseline as if both sides were
    fresh. Without pairs of the baseline. Cells without any scatter are left out.
    """
    columns = []
    for (now, then), (_, labels) in zip(runs.values(name), runs.seeds(name), strict=True):
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
