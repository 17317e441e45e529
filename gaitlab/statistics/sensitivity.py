"""How far a result hangs on what was assumed, from points that fill the box of the assumptions.

A Gaussian process stands for the response over the box (`surrogate`), and Sobol' indices are those
of its mean [Marrel2009]: the first-order index of a quantity is the share of the response's
variance over the box that it explains alone, the total index the share that would be left if all
others were known [Saltelli2010]. Of a response that no model predicts better than its mean there is
no index.

References:
    Marrel2009: A. Marrel, B. Iooss, B. Laurent, O. Roustant, Calculations of Sobol indices for the
        Gaussian process metamodel, Reliability Engineering & System Safety, 2009.
    Saltelli2010: A. Saltelli et al., Variance based sensitivity analysis of model output. Design
        and estimator for the total sensitivity index, Computer Physics Communications, 2010.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import sobol_indices, uniform

from gaitlab.statistics.proportions import Count, Interval
from gaitlab.statistics.surrogate import Function, Quality, fit_process, quality

DRAWS = 200  # of values and functions, for intervals
SAMPLES = 512  # of the box, times k + 2 for k quantities; a power of two
SEED = 20100201  # of everything drawn here
ROUNDING = 1e-9  # of the largest value; a smaller scatter is none


class SignShares(NamedTuple):
    """Among all points, those where a difference is positive, none or negative."""

    positive: Count
    zero: Count
    negative: Count


class Estimate(NamedTuple):
    """A number and its interval."""

    value: float
    interval: Interval


@dataclass(frozen=True, kw_only=True)
class QuantityEffect:
    """What one quantity does to the response.

    Attributes:
        first: Share of the variance over the box that it explains alone.
        total: Share that it has a part in, alone or with others.
        change: From the low to the high end of its range, the mean over the others, in the unit of
            the response.
    """

    first: Estimate
    total: Estimate
    change: Estimate


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """A model of a response over a box.

    Attributes:
        quality: How well it predicts.
        effects: One for each quantity; empty where no model predicts better than the mean.
    """

    quality: Quality
    effects: tuple[QuantityEffect, ...]


def sign_shares(differences: np.ndarray) -> SignShares:
    """How often a difference has which sign. Shape of differences (n,)."""
    n = len(differences)
    counts = (np.sum(differences > 0.0), np.sum(differences == 0.0), np.sum(differences < 0.0))
    return SignShares(*(Count(int(count), n) for count in counts))


def fewest_points(quantities: int) -> int:
    """Points below which a model of them says too little: two for each of its length scales."""
    return 2 * (quantities + 1)


def sensitivity_of(
    points: np.ndarray,
    values: np.ndarray,
    *,
    noise: np.ndarray | float = 0.0,
    resampled: np.ndarray | None = None,
    confidence: float = 0.95,
) -> Sensitivity:
    """Sobol' indices of a response, if a model predicts it better than its mean.

    Intervals are of functions drawn from the model, length scales held, each through values that
    were resampled; they reach to the indices of the mean, which a drawn function, being rougher,
    may lie beside.

    Args:
        points: Places in the unit box. Shape (n, k).
        values: The response. Shape (n,).
        noise: Known variance of the values, of each point or of all.
        resampled: The values of other seeds, one column a draw; by default the values themselves.
            Shape (n, draws).
        confidence: Share of the intervals that hold the true number.

    Raises:
        ValueError: If there are fewer points than `fewest_points`.
    """
    points, values = np.asarray(points, dtype=float), np.asarray(values, dtype=float)
    k = points.shape[1]
    if len(points) < fewest_points(k):
        raise ValueError(f"{len(points)} points, {k} quantities; {fewest_points(k)} are needed")
    order = np.lexsort((values, *np.round(points, 9).T[::-1]))  # the folds belong to the points
    points, values = points[order], values[order]
    noise = np.broadcast_to(np.asarray(noise, dtype=float), values.shape)[order]
    if np.ptp(values) <= ROUNDING * float(np.max(np.abs(values))):
        return Sensitivity(quality=Quality(0.0, predicts=False), effects=())
    found = quality(points, values, noise)
    if not found.predicts:
        return Sensitivity(quality=found, effects=())
    model = fit_process(points, values, noise)
    drawn = np.tile(values[:, None], DRAWS) if resampled is None else np.asarray(resampled)[order]
    mean = _numbers(lambda places: model.predict(places)[:, None], k)[..., 0]
    draws = _numbers(model.paths(np.random.default_rng(SEED), drawn), k)
    tails = [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0]
    low, high = np.quantile(draws, tails, axis=-1)
    low, high = np.minimum(low, mean), np.maximum(high, mean)
    effects = [
        QuantityEffect(
            **{
                name: Estimate(float(mean[i, j]), Interval(float(low[i, j]), float(high[i, j])))
                for i, name in enumerate(("first", "total", "change"))
            }
        )
        for j in range(k)
    ]
    return Sensitivity(quality=found, effects=tuple(effects))


def _numbers(function: Function, k: int) -> np.ndarray:
    """First-order and total indices, and changes from end to end, of functions over the unit box.

    Args:
        function: From places of shape (m, k) to values of shape (m, draws).
        k: Edges of the box.

    Returns:
        Shape (3, k, draws).
    """
    found = sobol_indices(
        func=lambda places: function(np.asarray(places).T).T,
        n=SAMPLES,
        dists=[uniform()] * k,
        random_state=np.random.default_rng(SEED),  # `rng` from SciPy 1.15 on
    )
    shares = [np.clip(np.atleast_2d(index), 0.0, 1.0).T
              for index in (found.first_order, found.total_order)]  # fmt: skip
    others = np.random.default_rng(SEED).random((SAMPLES, k))
    changes = []
    for j in range(k):
        ends = []
        for end in (0.0, 1.0):
            places = others.copy()
            places[:, j] = end
            ends.append(function(places).mean(axis=0))
        changes.append(ends[1] - ends[0])
    return np.stack([*shares, np.array(changes)])
