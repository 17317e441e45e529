"""How many trials would tell, and what the trials at hand can tell at all.

References:
    Connor1987: Connor, Sample size for testing differences in proportions for the paired-sample
        design, Biometrics, 1987.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, inf, sqrt

import numpy as np

from gaitlab.statistics.proportions import Count

POWER = 0.8  # chance to find what is there
LEVEL = 0.05  # two-sided
STEPS = 30  # of a bisection; differences of shares to 1e-9


def pairs_for_shares(discordant: float, difference: float, level: float = LEVEL) -> float:
    """Pairs that McNemar's test needs to tell a difference, [Connor1987].

    Args:
        discordant: Share of the pairs in which only one treatment succeeds.
        difference: First share less second share.
        level: Two-sided.

    Returns:
        A whole number, infinite when there is no difference.
    """
    if not difference:
        return inf
    alpha, beta = _quantiles(level / 2.0)
    spread = alpha * sqrt(discordant) + beta * sqrt(max(discordant - difference**2, 0.0))
    return float(ceil((spread / difference) ** 2))


def trials_for_shares(first: float, second: float, level: float = LEVEL) -> float:
    """Trials on each side that tell two shares apart without pairs; infinite for equal ones."""
    if first == second:
        return inf
    alpha, beta = _quantiles(level / 2.0)
    mean = (first + second) / 2.0
    spread = alpha * sqrt(2.0 * mean * (1.0 - mean))
    spread += beta * sqrt(first * (1.0 - first) + second * (1.0 - second))
    return float(ceil((spread / (first - second)) ** 2))


def values_for_mean(deviation: float, difference: float, level: float = LEVEL) -> float:
    """Values that tell a mean of this size from 0, given their standard deviation."""
    if not difference:
        return inf
    alpha, beta = _quantiles(level / 2.0)
    return float(max(ceil(((alpha + beta) * deviation / difference) ** 2), 2))


def detectable_mean(deviation: float, n: float, level: float) -> float:
    """Smallest mean that n values with this deviation tell from 0, one-sided."""
    return float(sum(_quantiles(level)) * deviation / sqrt(n)) if n else inf


def detectable_drop(cells: Sequence[Count], level: float) -> float:
    """Smallest drop of the stable share that two runs of these cells would show, one-sided.

    Every cell loses the same share, or all that it has; the runs are as independent as with fresh
    seeds. Each cell's share is taken as (k + 1/2) / (n + 1), so that none is certain.

    Returns:
        Drop of the mean share over the cells' trials, in (0, 1]; infinite when even the loss of
        everything would not show.
    """
    if not _shows(cells, 1.0, level):
        return inf
    low, high = 0.0, 1.0
    for _ in range(STEPS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if _shows(cells, middle, level) else (middle, high)
    return _mean_drop(cells, high)


def _shows(cells: Sequence[Count], drop: float, level: float) -> bool:
    """Whether a drop in every cell is found with the wanted power; discordant pairs, as normal."""
    alpha, beta = _quantiles(level)
    before, after, n = _shares(cells, drop)
    lost, won = before * (1.0 - after), after * (1.0 - before)
    gap = float(np.sum(n * (lost - won)))
    null = sqrt(float(np.sum(n * (lost + won))))
    true = sqrt(float(np.sum(n * (lost + won - (lost - won) ** 2))))
    return gap >= alpha * null + beta * true


def _mean_drop(cells: Sequence[Count], drop: float) -> float:
    before, after, n = _shares(cells, drop)
    return float(np.sum(n * (before - after)) / np.sum(n))


def _shares(cells: Sequence[Count], drop: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share before, share after and trials of each cell. Shapes (cells,)."""
    successes, n = np.array(cells, dtype=float).reshape(-1, 2).T
    before = (successes + 0.5) / (n + 1.0)
    return before, np.maximum(before - drop, 0.0), n


def _quantiles(tail: float) -> tuple[float, float]:
    """Normal quantiles of the level's tail and of the power."""
    from scipy.stats import norm

    return float(norm.isf(tail)), float(norm.ppf(POWER))
