"""How many trials would tell, and what the trials at hand can tell at all.

References:
    Connor1987: Connor, Sample size for testing differences in proportions for the paired-sample
        design, Biometrics, 1987.
    CornishFisher1938: Cornish and Fisher, Moments and cumulants in the specification of
        distributions, Revue de l'Institut International de Statistique, 1938.
    JohnsonWelch1940: Johnson and Welch, Applications of the non-central t-distribution,
        Biometrika, 1940.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, comb, inf, sqrt

import numpy as np

POWER = 0.8  # chance to find what is there
LEVEL = 0.05  # two-sided
STEPS = 10  # of a bisection; drops of a share to 0.001
ROUNDS = 6  # of a fixed point that settles in three
TINY = 1e-12  # below any difference of counts
DRAWS = 500  # pairs of runs; their power scatters by 2 points


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


def detectable_mean(deviation: float, clusters: int, level: float) -> float:
    """Smallest mean over clusters that `sign_flip` tells from 0, one-sided.

    Clusters scatter normally. The total over all signs asks for a z as of `_critical`, and so for
    a t of z sqrt((n - 1) / (n - z^2)), whose power is that of [JohnsonWelch1940].

    Args:
        deviation: Standard deviation between clusters.
        clusters: How many; with n of them no p-value is below 2^-n.
        level: Chance of a false alarm.

    Returns:
        In the unit of the deviation; infinite when no change whatever would be told.
    """
    if 2.0**-clusters > level:
        return inf
    mean = 1.0
    for _ in range(ROUNDS):  # the larger the mean, the more alike the clusters' sizes
        peaked = (mean**4 + 6.0 * mean**2 + 3.0) / (mean**2 + 1.0) ** 2
        z = float(_critical(level, peaked / clusters))
        if clusters <= z**2:
            return inf
        mean = _noncentrality(z, clusters, clusters - 1) / sqrt(clusters)
    return mean * deviation


def _critical(level: float, peaked: np.ndarray | float) -> np.ndarray:
    """Sum over the root of the sum of squares that `sign_flip` asks for, [CornishFisher1938].

    Under random signs the sum's excess kurtosis is -2 times the sum of fourth powers over the
    square of the sum of squares, `peaked`.
    """
    z = _quantiles(level)[0]
    return np.asarray(z - 2.0 * np.asarray(peaked) * (z**3 - 3.0 * z) / 24.0)


def detectable_difference(deviation: float, first: int, second: int, level: float) -> float:
    """Smallest difference of means that shuffling clusters between the sides tells, one-sided.

    As `detectable_mean`, with other clusters on each side: so many on the first and the second.
    """
    z, both = _quantiles(level)[0], first + second
    if min(first, second) < 1 or comb(both, first) < 1.0 / level or both - 1 <= z**2:
        return inf
    reach = _noncentrality(z, both - 1, both - 2)
    return reach * deviation * sqrt(1.0 / first + 1.0 / second)


def _noncentrality(z: float, n: int, freedom: int) -> float:
    """Of the t that exceeds its critical value with the wanted power, [JohnsonWelch1940] eq. 3."""
    critical = z * sqrt(freedom / (n - z**2))
    spread = sqrt(1.0 + critical**2 / (2.0 * freedom))
    return critical * (1.0 - 0.25 / freedom) + _quantiles(0.5)[1] * spread


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
    from scipy.stats import norm

    return float(norm.isf(tail)), float(norm.ppf(POWER))
