"""Proportions with their uncertainty: cells, surfaces, efficiency, and tests between two gaits.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
    Efron1979: Efron, Bootstrap methods: another look at the jackknife, Annals of Statistics, 1979.
    McNemar1947: McNemar, Note on the sampling error of the difference between correlated
        proportions or percentages, Psychometrika, 1947.
    Newcombe1998: Newcombe, Interval estimation for the difference between independent
        proportions: comparison of eleven methods, Statistics in Medicine, 1998.
    Student1908: Student, The probable error of a mean, Biometrika, 1908.
    Wilson1927: Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import hypot, inf, nan, sqrt
from typing import NamedTuple

import numpy as np

STABLE_SHARE = 0.5  # of its seeds; a cell with half of them on their feet counts as stable
RESAMPLES = 10_000  # the ends of a 95 % interval settle to some 1 % of its width


class Interval(NamedTuple):
    """A confidence interval, ends included."""

    low: float
    high: float


class Count(NamedTuple):
    """Successes among n trials of one cell."""

    successes: int
    n: int


class McNemar(NamedTuple):
    """Two treatments on the same cases: how often only one succeeded, and how likely by chance."""

    only_first: int
    only_second: int
    p_value: float


def _checked(successes: int, n: int) -> None:
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes among {n} trials; need 0 <= successes <= n")


def wilson(successes: int, n: int, confidence: float = 0.95) -> Interval:
    """Score interval of a proportion, [Wilson1927]; all of [0, 1] when n is 0.

    Raises:
        ValueError: If the successes are negative or more than n.
    """
    # scipy.stats takes half a second to import, which `gaitlab list` should not pay.
    from scipy.stats import binomtest

    _checked(successes, n)
    if n == 0:
        return Interval(0.0, 1.0)
    interval = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    return Interval(float(interval.low), float(interval.high))


def mean_interval(values: Sequence[float], confidence: float = 0.95) -> Interval:
    """Interval of the mean of values that scatter normally, [Student1908].

    All numbers when there are fewer than two values.
    """
    from scipy.stats import t

    if len(values) < 2:
        return Interval(-inf, inf)
    mean, n = float(np.mean(values)), len(values)
    reach = float(t.ppf(0.5 + confidence / 2.0, n - 1) * np.std(values, ddof=1) / sqrt(n))
    return Interval(mean - reach, mean + reach)


def difference_of_proportions(first: Count, second: Count, confidence: float = 0.95) -> Interval:
    """Interval of first share minus second share, unpaired, [Newcombe1998] method 10.

    The two Wilson intervals are combined by squares; [-1, 1] bounds it by construction.

    Raises:
        ValueError: If a count is impossible or empty.
    """
    if not first.n or not second.n:
        raise ValueError("a share of no trials cannot be compared; give counts with n > 0")
    p, q = first.successes / first.n, second.successes / second.n
    a, b = wilson(*first, confidence), wilson(*second, confidence)
    below, above = hypot(p - a.low, b.high - q), hypot(a.high - p, q - b.low)
    return Interval(p - q - below, p - q + above)


def mcnemar(pairs: Iterable[tuple[bool, bool]]) -> McNemar:
    """Exact test whether two treatments of the same cases succeed equally often, [McNemar1947].

    Args:
        pairs: For each case whether the first and whether the second treatment succeeded.

    Returns:
        The discordant counts and the two-sided p-value; 1 when no pair is discordant.
    """
    from scipy.stats import binomtest

    discordant = [bool(first) for first, second in pairs if bool(first) != bool(second)]
    only_first, n = sum(discordant), len(discordant)
    p_value = float(binomtest(only_first, n).pvalue) if n else 1.0
    return McNemar(only_first, n - only_first, p_value)


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
        _checked(*cell)
    successes, n = np.array(cells).T
    # n draws with replacement from n outcomes, counted, are one binomial draw.
    return generator.binomial(n, successes / n, (RESAMPLES, len(n))) / n
