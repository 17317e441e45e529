"""Shares of trials: their intervals, and whether two treatments succeed equally often.

References:
    BonettPrice2012: Bonett and Price, Adjusted Wald confidence interval for a difference of
        binomial proportions based on paired data, J. of Educational and Behavioral Statistics,
        2012.
    Gart1970: Gart, Point and interval estimation of the common odds ratio in the combination of
        2 x 2 tables with fixed marginals, Biometrika, 1970.
    McNemar1947: McNemar, Note on the sampling error of the difference between correlated
        proportions or percentages, Psychometrika, 1947.
    Newcombe1998: Newcombe, Interval estimation for the difference between independent
        proportions: comparison of eleven methods, Statistics in Medicine, 1998.
    Wilson1927: Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from math import hypot, sqrt
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

# Of the first treatment against the second, as scipy words it.
Alternative: TypeAlias = Literal["two-sided", "less", "greater"]


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
    # scipy.stats takes half a second to import, which `gaitlab list` should not pay.
    from scipy.stats import binomtest

    require_possible(successes, n)
    if n == 0:
        return Interval(0.0, 1.0)
    interval = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    return Interval(float(interval.low), float(interval.high))


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


def mcnemar(pairs: Iterable[tuple[bool, bool]], alternative: Alternative = "two-sided") -> McNemar:
    """Exact test whether two treatments of the same cases succeed equally often, [McNemar1947].

    Args:
        pairs: For each case whether the first and whether the second treatment succeeded.
        alternative: `less` asks whether the first one succeeds less often.

    Returns:
        The discordant counts and the p-value; 1 when no pair is discordant.
    """
    from scipy.stats import binomtest

    discordant = [bool(first) for first, second in pairs if bool(first) != bool(second)]
    only_first, n = sum(discordant), len(discordant)
    p_value = float(binomtest(only_first, n, alternative=alternative).pvalue) if n else 1.0
    return McNemar(only_first, n - only_first, p_value)


def paired_difference(pairs: Iterable[tuple[bool, bool]], confidence: float = 0.95) -> Interval:
    """Interval of first share minus second share of the same cases, [BonettPrice2012].

    An adjusted Wald interval: one discordant pair is added either way, so that it keeps a width
    when no pair is discordant. [-1, 1] bounds it.

    Raises:
        ValueError: If there is no pair.
    """
    from scipy.stats import norm

    found = list(pairs)
    if not found:
        raise ValueError("a difference of no pairs cannot be told; give at least one")
    test, n = mcnemar(found), len(found) + 2
    p, q = (test.only_first + 1) / n, (test.only_second + 1) / n
    reach = float(norm.ppf(0.5 + confidence / 2.0)) * sqrt((p + q - (p - q) ** 2) / n)
    return Interval(max(p - q - reach, -1.0), min(p - q + reach, 1.0))


def stratified_exact(
    strata: Sequence[tuple[Count, Count]], alternative: Alternative = "two-sided"
) -> float:
    """Exact test whether the first of two counts succeeds equally often, [Gart1970].

    Given the successes of each stratum, those of its first count are hypergeometric; their sum is
    compared with its exact distribution. With one trial on each side it is McNemar's test.

    Returns:
        The p-value; two-sided it is twice the smaller tail.
    """
    from scipy.stats import hypergeom

    chances = np.ones(1)
    for first, second in strata:
        successes = first.successes + second.successes
        support = np.arange(first.n + 1)
        law = hypergeom.pmf(support, first.n + second.n, successes, first.n)
        chances = np.convolve(chances, law)
    seen = sum(first.successes for first, _ in strata)
    tails = {"less": chances[: seen + 1].sum(), "greater": chances[seen:].sum()}
    p_value = 2.0 * min(tails.values()) if alternative == "two-sided" else tails[alternative]
    return float(min(p_value, 1.0))
