"""Tests between two sides whose values hang together in clusters.

A seed draws the same friction, servo gains and ground in every cell, so its values in all cells are
one cluster: they share luck, and only whole clusters may be exchanged between the sides. A test
that takes them one by one counts the same luck many times and raises false alarms.

References:
    Fisher1935: Fisher, The Design of Experiments, 1935, section 21.
    vanElteren1960: van Elteren, On the combination of independent two-sample tests of Wilcoxon,
        Bulletin of the International Statistical Institute, 1960.
    Winkler2014: Winkler et al., Permutation inference for the general linear model, NeuroImage,
        2014; whole blocks change their sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from gaitlab.statistics.proportions import Alternative

Stratum = tuple[np.ndarray, np.ndarray]
SHUFFLES = 20_000  # of a permutation test; p-values down to 1e-4 are told apart
SIGNS = 4_000_000  # drawn at once, which bounds the memory
EXACT = 30  # clusters whose 2^30 signs are counted exactly, in two halves of 2^15 sums
ROUNDING = 1e-9  # of the sum of all sizes; closer sums are equal


def sign_flip(sums: np.ndarray, alternative: Alternative = "two-sided") -> float:
    """p-value of the sign-flip test over clusters, [Fisher1935] section 21, [Winkler2014].

    If nothing changed, the two values of a pair may be exchanged, for all pairs of a cluster
    together, and the sum of the cluster's differences changes its sign. The p-value is the share
    of all signs whose total is as extreme as the one seen: exact for up to `EXACT` clusters that
    differ, whatever the values' distribution and however they hang together within a cluster;
    beyond them from `SHUFFLES` random signs. It is never below 2^-n with n clusters that differ.

    Args:
        sums: Sum of the differences of each cluster, first less second. Shape (clusters,).
        alternative: `less` asks whether the first values are the smaller ones.

    Returns:
        1 when no cluster differs.
    """
    changed = sums[sums != 0.0]
    if not len(changed):
        return 1.0
    tails = {"less": _tail(-changed), "greater": _tail(changed)}
    tails["two-sided"] = min(2.0 * min(tails.values()), 1.0)
    return tails[alternative]


def _tail(sums: np.ndarray) -> float:
    """Share of the signs whose total is at least the one seen."""
    seen = float(np.sum(sums)) - ROUNDING * float(np.sum(np.abs(sums)))
    if len(sums) > EXACT:
        generator, reached, at_once = np.random.default_rng(19350101), 0, max(1, SIGNS // len(sums))
        for start in range(0, SHUFFLES, at_once):
            count = min(at_once, SHUFFLES - start)
            signs = generator.choice([-1.0, 1.0], (count, len(sums)))
            reached += int(np.sum(signs @ sums >= seen))
        return (1 + reached) / (1 + SHUFFLES)
    first, second = _totals(sums[::2]), np.sort(_totals(sums[1::2]))
    beyond = len(second) - np.searchsorted(second, seen - first)
    return float(np.sum(beyond) / 2.0 ** len(sums))


def _totals(sums: np.ndarray) -> np.ndarray:
    """Totals under all signs. Shape (2^n,)."""
    totals = np.zeros(1)
    for size in sums.tolist():
        totals = np.concatenate([totals - size, totals + size])
    return totals


def clustered_rank_sum(
    strata: Sequence[Stratum],
    clusters: Sequence[Stratum],
    alternative: Alternative = "two-sided",
) -> float:
    """p-value of the rank-sum test over strata, [vanElteren1960], for values that hang together.

    Each stratum's ranks are weighted by 1 / (n + 1) and summed over the values of a cluster, a
    seed for instance that draws the same servos in every cell. Whole clusters are shuffled between
    the two sides, so that what a cluster shares is not taken for a difference between the sides.

    Args:
        strata: First and second values of each stratum.
        clusters: For each of these values the label of its cluster; no cluster is on both sides.
        alternative: `less` asks whether the first values are the smaller ones.
    """
    sides: tuple[dict[float, float], dict[float, float]] = ({}, {})
    for values, labels in zip(strata, clusters, strict=True):
        for side, scores, names in zip(sides, _ranked(*values), labels, strict=True):
            for label, score in zip(names.tolist(), scores.tolist(), strict=True):
                side[label] = side.get(label, 0.0) + score
    first, second = (np.array(list(side.values())) for side in sides)
    if not len(first) or not len(second) or not np.ptp(np.concatenate([first, second])):
        return 1.0
    return _shuffled(first, second, alternative)


def _ranked(first: np.ndarray, second: np.ndarray) -> Stratum:
    """Weighted ranks about their mean."""
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate([first, second]))
    scores = (ranks - ranks.mean()) / (len(ranks) + 1.0)
    return scores[: len(first)], scores[len(first) :]


def _shuffled(first: np.ndarray, second: np.ndarray, alternative: Alternative) -> float:
    """Share of shuffles whose first sum is as extreme as the one seen."""
    scores = np.concatenate([first, second])
    sums = scores[_shuffles(len(first), len(scores))].sum(axis=1)
    seen, rounding = float(np.sum(first)), 1e-9
    less = (1 + np.sum(sums <= seen + rounding)) / (1 + SHUFFLES)
    greater = (1 + np.sum(sums >= seen - rounding)) / (1 + SHUFFLES)
    tails = {"less": less, "greater": greater, "two-sided": min(2.0 * min(less, greater), 1.0)}
    return float(tails[alternative])


@lru_cache(maxsize=2)
def _shuffles(first: int, n: int) -> np.ndarray:
    """Which of n clusters come first in each shuffle. Shape (SHUFFLES, first)."""
    table = np.broadcast_to(np.arange(n), (SHUFFLES, n))
    return np.random.default_rng(19600101).permuted(table, axis=1)[:, :first].copy()
