"""How much of something is survived in half of the trials, from counts at rising levels of it.

More is taken to be never easier, and nothing else: no curve is fitted. The estimate is where the
isotonic regression of the shares [Barlow1972], straight between two levels, goes through one half.

The interval is a chain of sign tests. Rising from the lowest level, each has to be survived more
often than not, tested at half of the error allowed; the last that is, before one is not, is a lower
bound. That it lies above the truth takes a wrong rejection at the first level beyond the truth, so
that the chain errs no more often than one test, however the trials of several levels hang together:
they mostly share their seeds. The upper bound falls from the highest level likewise. Both are
levels that were tried, and exact at any number of trials. Derived here.

References:
    Barlow1972: Barlow, Bartholomew, Bremner and Brunk, Statistical Inference under Order
        Restrictions, Wiley, 1972.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from gaitlab.statistics.proportions import STABLE_SHARE, Count, Interval, require_possible


class HalfPoint(NamedTuple):
    """The level that half of the trials survive.

    Attributes:
        value: The estimate; infinite where half survive even the highest level, minus infinite
            where fewer survive even the lowest.
        bounds: Confidence interval; an end that no level that was tried bounds is infinite.
    """

    value: float
    bounds: Interval


def half_point(
    levels: Sequence[float], counts: Sequence[Count], confidence: float = 0.95
) -> HalfPoint:
    """The level that half of the trials survive.

    Args:
        levels: Rising.
        counts: Survivors and trials at each.
        confidence: That the interval holds the true level.

    Raises:
        ValueError: If there is no level, they do not rise, or one has no trial.
    """
    if not levels or len(levels) != len(counts):
        raise ValueError(f"{len(levels)} levels and {len(counts)} counts; give one count a level")
    if any(low >= high for low, high in itertools.pairwise(levels)):
        raise ValueError(f"levels {list(levels)} do not rise")
    for successes, n in counts:
        require_possible(successes, n)
        if not n:
            raise ValueError("a level without a trial says nothing; leave it out")
    error = (1.0 - confidence) / 2.0
    low = _last(levels, (_tail(n - k, n) <= error for k, n in counts))
    high = _last(levels[::-1], (_tail(k, n) <= error for k, n in reversed(counts)))
    bounds = Interval(-inf if low is None else low, inf if high is None else high)
    return HalfPoint(_crossing(levels, counts), bounds)


def _tail(at_most: int, n: int) -> float:
    """How likely no more than so many of n are heads of a fair coin."""
    from scipy.special import bdtr

    return float(bdtr(at_most, n, STABLE_SHARE))


def _last(levels: Sequence[float], holds: Iterable[bool]) -> float | None:
    """The last level before the first at which something does not hold."""
    found = None
    for level, true in zip(levels, holds, strict=True):
        if not true:
            break
        found = level
    return found


def _crossing(levels: Sequence[float], counts: Sequence[Count]) -> float:
    from scipy.optimize import isotonic_regression

    survivors, n = np.array(counts, dtype=float).T
    shares = isotonic_regression(survivors / n, weights=n, increasing=False).x
    if shares[0] < STABLE_SHARE:
        return -inf
    k = int(np.flatnonzero(shares >= STABLE_SHARE)[-1])
    if k == len(levels) - 1:
        return inf
    way = (shares[k] - STABLE_SHARE) / (shares[k] - shares[k + 1])
    return float(levels[k] + way * (levels[k + 1] - levels[k]))
