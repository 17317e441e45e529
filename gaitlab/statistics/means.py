"""Quantities on a scale: their means, and whether two treatments differ in them.

References:
    Efron1987: Efron, Better bootstrap confidence intervals, J. of the American Statistical
        Association, 1987.
    Student1908: Student, The probable error of a mean, Biometrika, 1908.
    Wilcoxon1945: Wilcoxon, Individual comparisons by ranking methods, Biometrics Bulletin, 1945.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from gaitlab.statistics.proportions import Alternative, Interval

RESAMPLES = 10_000  # of a bootstrap; the ends settle to some 1 % of the interval's width
MOST_DRAWN = 4_000_000  # values a bootstrap draws; with many values fewer resamples do
FEW_RESAMPLES = 1000

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


def mean_difference_interval(differences: np.ndarray, confidence: float = 0.95) -> Interval:
    """Bootstrap interval of the mean of paired differences, bias-corrected and accelerated.

    BCa as of [Efron1987] eq. (6.6); always the same resamples, so equal data give equal ends.

    Args:
        differences: One value a pair. Shape (n,).
        confidence: Share of the intervals that hold the true mean.

    Returns:
        All numbers for fewer than two values; the value itself when all are equal.
    """
    from scipy.stats import norm

    if len(differences) < 2:
        return Interval(-inf, inf)
    mean = float(np.mean(differences))
    centred = differences - mean
    if not np.any(centred):
        return Interval(mean, mean)
    draws = _mean_draws(differences)
    below = np.mean(draws < mean) + 0.5 * np.mean(draws == mean)
    bias = float(norm.ppf(np.clip(below, 1.0 / len(draws), 1.0 - 1.0 / len(draws))))
    acceleration = float(np.sum(centred**3) / (6.0 * np.sum(centred**2) ** 1.5))
    z = bias + norm.ppf([0.5 - confidence / 2.0, 0.5 + confidence / 2.0])
    low, high = np.quantile(draws, norm.cdf(bias + z / (1.0 - acceleration * z)))
    return Interval(float(low), float(high))


def _mean_draws(values: np.ndarray) -> np.ndarray:
    """Means of resamples, in the order of the drawing. Shape (resamples,)."""
    generator = np.random.default_rng(19870301)
    count = int(np.clip(MOST_DRAWN // len(values), FEW_RESAMPLES, RESAMPLES))
    means = [values[generator.integers(0, len(values), (100, len(values)))].mean(axis=1)]
    while 100 * len(means) < count:
        means.append(values[generator.integers(0, len(values), (100, len(values)))].mean(axis=1))
    return np.concatenate(means)


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


def signed_rank(differences: np.ndarray, alternative: Alternative = "two-sided") -> float:
    """p-value of Wilcoxon's signed-rank test, [Wilcoxon1945]; pairs without a difference drop out.

    Exact for up to 50 differences without ties; 1 when nothing differs.
    """
    from scipy.stats import wilcoxon

    changed = differences[differences != 0.0]
    if not len(changed):
        return 1.0
    tied = len(np.unique(np.abs(changed))) < len(changed)
    method = "exact" if len(changed) <= 50 and not tied else "approx"
    return float(wilcoxon(changed, alternative=alternative, method=method).pvalue)
