"""Quantities on a scale: their means, and whether two treatments differ in them.

References:
    Student1908: Student, The probable error of a mean, Biometrika, 1908.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from gaitlab.statistics.proportions import Interval

Stratum = tuple[np.ndarray, np.ndarray]


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


def stratified_difference(strata: Sequence[Stratum]) -> float:
    """Mean over strata of the mean of the first less the mean of the second values."""
    return float(np.mean([np.mean(first) - np.mean(second) for first, second in strata]))


def stratified_difference_interval(strata: Sequence[Stratum], confidence: float = 0.95) -> Interval:
    """Interval of `stratified_difference`: strata are fixed, values within them are drawn again.

    Normal, with the variances of Welch; all numbers when a stratum has a single value.
    """
    from scipy.stats import norm

    if not strata or any(len(side) < 2 for pair in strata for side in pair):
        return Interval(-inf, inf)
    variances = [np.var(a, ddof=1) / len(a) + np.var(b, ddof=1) / len(b) for a, b in strata]
    middle = stratified_difference(strata)
    reach = float(norm.ppf(0.5 + confidence / 2.0)) * sqrt(float(np.sum(variances))) / len(strata)
    return Interval(middle - reach, middle + reach)
