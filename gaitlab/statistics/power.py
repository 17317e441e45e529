"""How many trials would tell, and what the trials at hand can tell at all.

References:
    CornishFisher1938: Cornish and Fisher, Moments and cumulants in the specification of
        distributions, Revue de l'Institut International de Statistique, 1938.
    Guenther1981: Guenther, Sample size formulas for normal theory t tests, The American
        Statistician, 1981.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, comb, inf, sqrt

import numpy as np

POWER = 0.8  # chance to find what is there
LEVEL = 0.05  # two-sided
STEPS = 10  # of a bisection; drops of a share to 0.001
FARTHEST = 20.0  # shift, in standard deviations of a cell; what needs more is not told
TINY = 1e-12  # below any difference of counts
DRAWS = 500  # pairs of runs; their power scatters by 2 points


def values_for_mean(deviation: float, difference: float, level: float = LEVEL) -> float:
    """Values whose mean tells a difference of this size from 0, given their standard deviation.

    Normal quantiles, and as many more as Student's t asks for, [Guenther1981].
    """
    if not difference:
        return inf
    alpha, beta = _quantiles(level / 2.0)
    enough = ((alpha + beta) * deviation / difference) ** 2 + alpha**2 / 2.0
    return float(max(ceil(enough), 2))


def detectable_shift(
    scatter: np.ndarray, clusters: int, level: float, *, paired: bool = True
) -> float:
    """Smallest shift, alike in all cells, that a test over clusters would show, one-sided.

    Whole clusters are drawn again, so what a cluster shares, and in how many cells it has a value,
    stays together. Each cell is divided by its root mean square, as the sums of `sign_flip` are.

    Args:
        scatter: Values about the mean of their cell, NaN where there is none; differences of pairs
            if `paired`. Shape (clusters, cells).
        clusters: Of a run, and of each of the two if they are not paired.
        level: Chance of a false alarm.
        paired: Whether `sign_flip` tests pairs of clusters, or clusters are shuffled.

    Returns:
        In the unit of the values; infinite when no shift whatever would be told.
    """
    size = np.sqrt(np.nanmean(scatter**2, axis=0))
    rng = np.random.default_rng(19350102)
    rows = scatter[rng.integers(0, len(scatter), (DRAWS, 2, clusters))]
    rows *= sqrt(len(scatter) / max(len(scatter) - 1.0, 1.0))  # about an estimated mean

    def shows(shift: float) -> bool:
        weights = 1.0 / np.hypot(size, shift)
        moved = np.nansum((rows[:, 0] + shift) * weights, axis=2)
        if paired:
            return bool(np.mean(_flips(moved, level)) >= POWER)
        other = np.nansum(rows[:, 1] * weights, axis=2)
        return bool(np.mean(_shuffles(moved, other, level)) >= POWER)

    top = FARTHEST * float(np.max(size))
    if not top or not shows(top):
        return inf
    low, high = 0.0, top
    for _ in range(STEPS + 5):
        middle = (low + high) / 2.0
        low, high = (low, middle) if shows(middle) else (middle, high)
    return high


def detectable_drop(
    outcomes: np.ndarray, clusters: int, level: float, *, paired: bool = True
) -> float:
    """Smallest drop of the stable share that a test over clusters would show, one-sided.

    Every cell loses the same share, or all that it has. Two runs are drawn, each from whole
    clusters of the outcomes, as if none of tonight's were known, so what a cluster shares stays
    together; then stable trials of the second are lost. Each cell's share is drawn as
    (k + 1/2) / (n + 1), so that none is certain.

    Args:
        outcomes: 1 for a stable trial, 0 for another, NaN for none. Shape (clusters, cells).
        clusters: Of each of the two runs.
        level: Chance of a false alarm.
        paired: Whether `sign_flip` tests pairs of clusters, or clusters are shuffled.

    Returns:
        Drop of the mean share over the cells' trials, in (0, 1]; infinite when even the loss of
        everything would not show.
    """
    drawn = _Runs.draw(outcomes, clusters)
    possible = 2**clusters if paired else comb(2 * clusters, clusters)
    if possible < 1.0 / level or not drawn.show(1.0, level, paired):
        return inf
    low, high = 0.0, 1.0
    for _ in range(STEPS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if drawn.show(middle, level, paired) else (middle, high)
    return float(np.sum(drawn.weights * np.minimum(drawn.shares, high)))


@dataclass(frozen=True)
class _Runs:
    """Two runs of the same cells, drawn many times.

    Attributes:
        before: Outcomes. Shape (draws, clusters, cells).
        tonight: The same of the second run, before anything is lost.
        luck: Number in (0, 1] of each of its trials; the smallest are lost first.
        shares: Stable share of each cell. Shape (cells,).
        weights: Share of the trials that are in each cell. Shape (cells,).
    """

    before: np.ndarray
    tonight: np.ndarray
    luck: np.ndarray
    shares: np.ndarray
    weights: np.ndarray

    @classmethod
    def draw(cls, outcomes: np.ndarray, clusters: int) -> _Runs:
        rng = np.random.default_rng(19620301)
        n = np.maximum(np.sum(np.isfinite(outcomes), axis=0), 1)
        shares = (np.nansum(outcomes, axis=0) + 0.5) / (n + 1.0)
        before, tonight = (_redrawn(outcomes, n, clusters, rng) for _ in range(2))
        return cls(before, tonight, 1.0 - rng.random(tonight.shape), shares, n / np.sum(n))

    def show(self, drop: float, level: float, paired: bool) -> bool:
        """Whether a drop in every cell is found with the wanted power."""
        lost = self.luck <= np.minimum(drop / self.shares, 1.0)
        before = np.nansum(self.before, axis=2)
        tonight = np.nansum(np.where(lost, 0.0, self.tonight), axis=2)
        found = _flips(before - tonight, level) if paired else _shuffles(before, tonight, level)
        return bool(np.mean(found) >= POWER)


def _redrawn(
    outcomes: np.ndarray, n: np.ndarray, clusters: int, rng: np.random.Generator
) -> np.ndarray:
    """Whole clusters drawn again, one trial in n + 1 of a cell tossed like a coin."""
    rows = outcomes[rng.integers(0, len(outcomes), (DRAWS, clusters))]
    tossed = (rng.random(rows.shape) < 1.0 / (n + 1.0)) & np.isfinite(rows)
    return np.where(tossed, rng.integers(0, 2, rows.shape), rows)


def _critical(level: float, peaked: np.ndarray | float) -> np.ndarray:
    """Sum over the root of the sum of squares that `sign_flip` asks for, [CornishFisher1938].

    Under random signs the sum's excess kurtosis is -2 times the sum of fourth powers over the
    square of the sum of squares, `peaked`.
    """
    z = _quantiles(level)[0]
    return np.asarray(z - 2.0 * np.asarray(peaked) * (z**3 - 3.0 * z) / 24.0)


def _flips(losses: np.ndarray, level: float) -> np.ndarray:
    """Whether `sign_flip` finds each run's losses. Shape (draws, clusters) to (draws,)."""
    squares = np.maximum(np.sum(losses**2, axis=1), TINY)
    critical = _critical(level, np.sum(losses**4, axis=1) / squares**2)
    smallest = 0.5 ** np.sum(losses != 0.0, axis=1)
    return (np.sum(losses, axis=1) >= critical * np.sqrt(squares)) & (smallest <= level)


def _shuffles(before: np.ndarray, tonight: np.ndarray, level: float) -> np.ndarray:
    """Whether shuffled clusters find each run's losses. Shapes (draws, clusters) to (draws,)."""
    both, n = np.concatenate([before, tonight], axis=1), before.shape[1]
    scatter = np.maximum(np.var(both, axis=1, ddof=1), TINY)
    seen = np.mean(before, axis=1) - np.mean(tonight, axis=1)
    return np.asarray(seen >= _quantiles(level)[0] * np.sqrt(2.0 * scatter / n))


def _quantiles(tail: float) -> tuple[float, float]:
    """Normal quantiles of the level's tail and of the power."""
    from scipy.special import ndtri

    return -float(ndtri(tail)), float(ndtri(POWER))
