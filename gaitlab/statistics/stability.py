"""Stability as the EROS paper counts it: cells, surfaces and efficiency, with their intervals.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
    Efron1979: Efron, Bootstrap methods: another look at the jackknife, Annals of Statistics, 1979.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import nan

import numpy as np

from gaitlab.statistics.proportions import Count, Interval, require_possible

STABLE_SHARE = 0.5  # of its seeds; a cell with half of them on their feet counts as stable
RESAMPLES = 10_000  # the ends of a 95 % interval settle to some 1 % of its width


def stable_cell(share: float) -> bool:
    """Whether a cell is stable: at least half of its seeds are."""
    return share >= STABLE_SHARE


def stability_percent(cells: Sequence[bool]) -> float:
    """Stability percentage of a surface [EROS2018]: stable cells over all, NaN without any."""
    return 100.0 * sum(map(bool, cells)) / len(cells) if len(cells) else nan


def efficiency(per_surface: Sequence[float]) -> float:
    """Mean of the surfaces' stability percentages [EROS2018]; nothing to do with energy.

    Args:
        per_surface: Stability percentage of each surface. NaN without any.
    """
    return float(np.mean(per_surface)) if len(per_surface) else nan


def distance_difference(with_it: float, without: float, longest: float = 6.0) -> float:
    """Difference of distance in percent of the longest possible, in [m] all three, [EROS2018]."""
    return 100.0 * (with_it - without) / longest


def efficiency_interval(
    surfaces: Sequence[Sequence[Count]], *, seed: int = 0, confidence: float = 0.95
) -> Interval:
    """Bootstrap interval of the efficiency, in percent, [Efron1979].

    The cells are fixed by the experiment; the seeds are resampled within each. A cell whose seeds
    all agree never changes, so the interval tells nothing of what an untried seed would do: read
    it beside the Wilson intervals of the cells.

    Args:
        surfaces: For each surface the stable seeds among all seeds of each cell.
        seed: Of the resampling; the same seed gives the same interval.
        confidence: Share of the resamples between the two ends.

    Raises:
        ValueError: If a surface has no cells or a cell no seeds.
    """
    return _bootstrap(surfaces, lambda shares: 100.0 * _stable_share(shares), seed, confidence)


def mean_share_interval(
    surfaces: Sequence[Sequence[Count]], *, seed: int = 0, confidence: float = 0.95
) -> Interval:
    """Bootstrap interval of the mean over surfaces of the cells' mean shares, [Efron1979].

    Arguments and errors as for `efficiency_interval`; no cell is called stable or not here, so
    every seed counts.
    """
    return _bootstrap(surfaces, lambda shares: shares.mean(axis=-1), seed, confidence)


def _stable_share(shares: np.ndarray) -> np.ndarray:
    """Share of cells that are stable. Shape (..., cells) to (...)."""
    return (shares >= STABLE_SHARE).mean(axis=-1)


def _bootstrap(
    surfaces: Sequence[Sequence[Count]],
    score: Callable[[np.ndarray], np.ndarray],
    seed: int,
    confidence: float,
) -> Interval:
    """Percentile interval of the mean over surfaces of a score of the resampled shares."""
    if not surfaces or not all(surfaces) or not all(c.n for cells in surfaces for c in cells):
        raise ValueError("every surface needs a cell and every cell a seed to be resampled")
    generator = np.random.default_rng(seed)
    draws = np.mean([score(_resampled(cells, generator)) for cells in surfaces], axis=0)
    low, high = np.quantile(draws, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    return Interval(float(low), float(high))


def _resampled(cells: Sequence[Count], generator: np.random.Generator) -> np.ndarray:
    """Shares of the cells when their seeds are drawn again. Shape (resamples, cells)."""
    for cell in cells:
        require_possible(*cell)
    successes, n = np.array(cells).T
    # n draws with replacement from n outcomes, counted, are one binomial draw.
    return generator.binomial(n, successes / n, (RESAMPLES, len(n))) / n
