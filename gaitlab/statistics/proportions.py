"""Intervals of shares, of differences of shares and of means; stability as EROS2018 counts it.

References:
    BonettPrice2012: Bonett and Price, Adjusted Wald confidence interval for a difference of
        binomial proportions based on paired data, J. of Educational and Behavioral Statistics,
        2012.
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
    Newcombe1998: Newcombe, Interval estimation for the difference between independent
        proportions: comparison of eleven methods, Statistics in Medicine, 1998.
    Student1908: Student, The probable error of a mean, Biometrika, 1908.
    Wilson1927: Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from math import hypot, inf, nan, sqrt
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

# Of the first treatment against the second, as scipy words it.
Alternative: TypeAlias = Literal["two-sided", "less", "greater"]
STABLE_SHARE = 0.5  # of its seeds; a cell with half of them on their feet counts as stable


class Interval(NamedTuple):
    """A confidence interval, ends included."""

    low: float
    high: float


class Count(NamedTuple):
    """Successes among n trials of one cell."""

    successes: int
    n: int


def require_possible(successes: int, n: int) -> None:
    """Refuse a count that cannot be.

    Raises:
        ValueError: If the successes are negative or more than n.
    """
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes among {n} trials; need 0 <= successes <= n")


@lru_cache(maxsize=4096)
def wilson(successes: int, n: int, confidence: float = 0.95) -> Interval:
    """Score interval of a proportion, [Wilson1927]; all of [0, 1] when n is 0.

    Raises:
        ValueError: If the successes are negative or more than n.
    """
    # From scipy.special: scipy.stats takes half a second to import, which no page should pay.
    from scipy.special import ndtri

    require_possible(successes, n)
    if n == 0:
        return Interval(0.0, 1.0)
    z = float(ndtri(0.5 + confidence / 2.0))
    p, scale = successes / n, 2.0 * (n + z**2)
    middle = (2.0 * n * p + z**2) / scale
    reach = z / scale * sqrt(4.0 * n * p * (1.0 - p) + z**2)
    low = middle - reach if successes else 0.0
    return Interval(low, middle + reach if successes < n else 1.0)


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


def paired_difference(pairs: Iterable[tuple[bool, bool]], confidence: float = 0.95) -> Interval:
    """Interval of first share minus second share of the same cases, [BonettPrice2012].

    An adjusted Wald interval: one discordant pair is added either way, so that it keeps a width
    when no pair is discordant. [-1, 1] bounds it.

    Raises:
        ValueError: If there is no pair.
    """
    from scipy.special import ndtri

    found = list(pairs)
    if not found:
        raise ValueError("a difference of no pairs cannot be told; give at least one")
    n = len(found) + 2
    p = (1 + sum(bool(first) and not second for first, second in found)) / n
    q = (1 + sum(bool(second) and not first for first, second in found)) / n
    reach = float(ndtri(0.5 + confidence / 2.0)) * sqrt((p + q - (p - q) ** 2) / n)
    return Interval(max(p - q - reach, -1.0), min(p - q + reach, 1.0))


def mean_interval(values: Sequence[float], confidence: float = 0.95) -> Interval:
    """Interval of the mean of values that scatter normally, [Student1908].

    All numbers when there are fewer than two values.
    """
    from scipy.special import stdtrit

    if len(values) < 2:
        return Interval(-inf, inf)
    mean, n = float(np.mean(values)), len(values)
    reach = float(stdtrit(n - 1, 0.5 + confidence / 2.0) * np.std(values, ddof=1) / sqrt(n))
    return Interval(mean - reach, mean + reach)


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
