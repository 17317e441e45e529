"""One quantity of two variants: the difference, its interval, its test, and what n would tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, isfinite, nan, sqrt
from typing import Literal, TypeAlias

import numpy as np

from gaitlab.metrics import Better, better
from gaitlab.report.comparison.matching import Matched
from gaitlab.statistics import (
    Count,
    Interval,
    clustered_rank_sum,
    difference_of_proportions,
    holm,
    mcnemar,
    mean_difference_interval,
    paired_difference,
    pairs_for_shares,
    signed_rank,
    stratified_difference,
    stratified_difference_interval,
    trials_for_shares,
    values_for_mean,
)

LEVEL = 0.05  # two-sided, for the whole family of a table
Verdict: TypeAlias = Literal["better", "worse", "higher", "lower", "cannot tell", "no data"]


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """Second variant against the first, in one quantity.

    Attributes:
        quantity: `stable`, or the name of a metric.
        first: Share or mean of the first variant over the runs compared.
        second: The same of the second.
        difference: Second less first.
        interval: 95 % interval of the difference.
        n: Pairs, or without pairs the runs of the smaller side.
        p_value: Two-sided, of this quantity alone.
        seeds: Seeds a cell with which a difference of this size would show.
    """

    quantity: str
    first: float
    second: float
    difference: float
    interval: Interval
    n: int
    p_value: float
    seeds: float

    def verdict(self, adjusted: float) -> Verdict:
        """What can be said, given the p-value corrected for the family."""
        if not self.n:
            return "no data"
        sure = adjusted < LEVEL and not self.interval.low <= 0.0 <= self.interval.high
        if not sure:
            return "cannot tell"
        return _side(better(self.quantity), self.difference > 0.0)


def _side(direction: Better, up: bool) -> Verdict:
    if direction == "neither":
        return "higher" if up else "lower"
    return "better" if up == (direction == "higher") else "worse"


def verdicts(contrasts: Sequence[Contrast]) -> list[Verdict]:
    """Verdict of each, all in one family; what has no data is no test."""
    tested = [contrast.p_value for contrast in contrasts if contrast.n]
    adjusted = iter(holm(tested))
    return [c.verdict(next(adjusted) if c.n else 1.0) for c in contrasts]


def stable_contrast(runs: Matched) -> Contrast:
    """Share of stable runs: exact McNemar test of pairs, ranks within cells without them."""
    if not runs.n:
        return _nothing("stable")
    first, second = runs.flags()
    shares = float(first.mean()), float(second.mean())
    test = _paired_shares if runs.paired else _unpaired_shares
    p_value, interval, needed = test(runs)
    return Contrast(
        quantity="stable",
        first=shares[0],
        second=shares[1],
        difference=shares[1] - shares[0],
        interval=interval,
        n=runs.n,
        p_value=p_value,
        seeds=_per_cell(needed, runs),
    )


def _paired_shares(runs: Matched) -> tuple[float, Interval, float]:
    first, second = runs.flags()
    pairs = list(zip(second.tolist(), first.tolist(), strict=True))
    test = mcnemar(pairs)
    discordant = (test.only_first + test.only_second) / len(pairs)
    gap = (test.only_first - test.only_second) / len(pairs)
    return test.p_value, paired_difference(pairs), pairs_for_shares(discordant, gap)


def _unpaired_shares(runs: Matched) -> tuple[float, Interval, float]:
    counts = [(second, first) for first, second in runs.counts()]
    sides = [[pair[side] for pair in counts] for side in (0, 1)]
    second, first = (Count(sum(c.successes for c in s), sum(c.n for c in s)) for s in sides)
    shares = first.successes / first.n, second.successes / second.n
    interval = difference_of_proportions(second, first)
    p_value = clustered_rank_sum(runs.strata("stable"), runs.seeds("stable"))
    return p_value, interval, trials_for_shares(*shares)


def metric_contrast(runs: Matched, metric: str) -> Contrast:
    """Mean of a metric: bootstrap and signed ranks of pairs, ranks within cells without them."""
    if metric not in runs.first.columns or metric not in runs.second.columns:
        return _nothing(metric)
    return _paired_means(runs, metric) if runs.paired else _unpaired_means(runs, metric)


def _paired_means(runs: Matched, metric: str) -> Contrast:
    gaps = runs.differences(metric)
    if not len(gaps):
        return _nothing(metric)
    mean = float(np.mean(gaps))
    base = runs.base(metric)
    deviation = float(np.std(gaps, ddof=1)) if len(gaps) > 1 else inf
    needed = values_for_mean(deviation, mean) if isfinite(deviation) else inf
    return Contrast(
        quantity=metric,
        first=base,
        second=base + mean,
        difference=mean,
        interval=mean_difference_interval(gaps),
        n=len(gaps),
        p_value=signed_rank(gaps),
        seeds=_per_cell(needed * runs.n / len(gaps), runs),
    )


def _unpaired_means(runs: Matched, metric: str) -> Contrast:
    strata = runs.strata(metric)
    if not strata:
        return _nothing(metric)
    gap = stratified_difference(strata)
    interval = stratified_difference_interval(strata)
    base = float(np.mean([np.mean(first) for _, first in strata]))
    smaller = [min(len(a), len(b)) for a, b in strata]
    deviation = (interval.high - interval.low) / (2.0 * 1.96) * sqrt(float(np.mean(smaller)))
    needed = values_for_mean(deviation, gap) if isfinite(deviation) else inf
    return Contrast(
        quantity=metric,
        first=base,
        second=base + gap,
        difference=gap,
        interval=interval,
        n=sum(smaller),
        p_value=clustered_rank_sum(strata, runs.seeds(metric)),
        seeds=needed,
    )


def _per_cell(trials: float, runs: Matched) -> float:
    return float(ceil(trials / runs.cells)) if isfinite(trials) else inf


def _nothing(quantity: str) -> Contrast:
    return Contrast(
        quantity=quantity,
        first=nan,
        second=nan,
        difference=nan,
        interval=Interval(nan, nan),
        n=0,
        p_value=1.0,
        seeds=inf,
    )
