"""How far a result hangs on what was assumed, from points that fill the box of the assumptions.

A straight plane is fitted through the response over the box, all quantities at once, and each
quantity's effect is the change of the plane from its low to its high end. Sobol' indices, which
need no plane, take (k + 2) samples of hundreds of points each for k quantities [Saltelli2008]; with
some tens of points, each of many walks, their error is as large as they are. Points of a scrambled
sequence are nearly uncorrelated [Owen1998], so that the plane's slopes are told apart with few, and
R^2 says how much of the response the plane leaves unsaid: curvature, and quantities that act
together.

References:
    Davidson2008: Davidson and Flachaire, The wild bootstrap, tamed at last, J. of Econometrics,
        2008.
    Freedman1983: Freedman and Lane, A nonstochastic interpretation of reported significance
        levels, J. of Business & Economic Statistics, 1983.
    Owen1998: Owen, Scrambling Sobol' and Niederreiter-Xing points, J. of Complexity, 1998.
    Saltelli2008: Saltelli et al., Global Sensitivity Analysis: The Primer, 2008.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import nan
from typing import NamedTuple

import numpy as np

from gaitlab.statistics.compare import holm
from gaitlab.statistics.proportions import Count, Interval

DRAWS = 4_999  # of bootstrap and permutations; with the data themselves a round 5 000
ROUNDING = 1e-9  # of the largest response; smaller differences are none


class SignShares(NamedTuple):
    """Among all points, those where a difference is positive, none or negative."""

    positive: Count
    zero: Count
    negative: Count


@dataclass(frozen=True, kw_only=True)
class LinearEffect:
    """What one quantity does to the response, the others held.

    Attributes:
        change: From the low to the high end of its range, in the unit of the response.
        interval: Of the change.
        p_value: That chance alone makes such a change, corrected for the number of quantities.
    """

    change: float
    interval: Interval
    p_value: float


@dataclass(frozen=True, kw_only=True)
class LinearEffects:
    """A plane through the response over the box.

    Attributes:
        effects: One for each quantity.
        r_squared: Share of the response's variance that the plane explains; NaN when it has none.
        adjusted: The same less what a plane explains of mere noise.
    """

    effects: tuple[LinearEffect, ...]
    r_squared: float
    adjusted: float


def sign_shares(differences: np.ndarray) -> SignShares:
    """How often a difference has which sign. Shape of differences (n,)."""
    n = len(differences)
    counts = (np.sum(differences > 0.0), np.sum(differences == 0.0), np.sum(differences < 0.0))
    return SignShares(*(Count(int(count), n) for count in counts))


def fewest_points(quantities: int) -> int:
    """Points below which a plane through them says too little: two for each of its numbers."""
    return 2 * (quantities + 1)


def linear_effects(
    points: np.ndarray,
    response: np.ndarray,
    box: np.ndarray | None = None,
    confidence: float = 0.95,
) -> LinearEffects:
    """Effect of each quantity on a response, from a regression on all of them.

    Intervals are of the wild bootstrap, each residual divided by 1 less its leverage
    [Davidson2008], so that a response may scatter more at one end of the box than at the other.
    p-values permute the residuals of the plane without the quantity [Freedman1983], corrected
    by Holm. Neither depends on the order of the points.

    Args:
        points: Places in the box. Shape (n, k).
        response: One value a point. Shape (n,).
        box: Low and high end of each quantity, in the unit of `points`; by default 0 and 1.
            Shape (2, k).
        confidence: Share of the intervals that hold the true change.

    Raises:
        ValueError: If there are fewer points than `fewest_points`, or some lie so that two
            quantities cannot be told apart.
    """
    low, high = (0.0, 1.0) if box is None else np.asarray(box, dtype=float)
    unit = np.asarray((np.asarray(points, dtype=float) - low) / (high - low))
    x, y = _ordered(unit, response)
    n, k = x.shape
    if n < fewest_points(k):
        raise ValueError(f"{n} points for {k} quantities; at least {fewest_points(k)} are needed")
    if np.linalg.matrix_rank(_with_constant(x)) <= k:
        raise ValueError("two quantities move together in all points, or one never moves")
    effects = [
        LinearEffect(change=change, interval=interval, p_value=p_value)
        for change, interval, p_value in zip(
            *_changes(x, y, confidence), holm(list(_p_values(x, y))), strict=True
        )
    ]
    total = float(y @ y)
    basis = np.linalg.qr(_with_constant(x))[0]
    rest = _beside(basis, y[None])[0]
    explained = 1.0 - float(rest @ rest) / total if total > 0.0 else nan
    freedom = (len(y) - 1) / (len(y) - x.shape[1] - 1)
    adjusted = 1.0 - (1.0 - explained) * freedom
    return LinearEffects(effects=tuple(effects), r_squared=explained, adjusted=adjusted)


def _ordered(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points in an order of their own, to which the draws belong; the response from its mean."""
    order = np.lexsort((y, *np.round(x, 9).T[::-1]))
    y = np.asarray(y, dtype=float)[order]
    centred = y - y.mean()
    return x[order], np.where(np.abs(centred) > ROUNDING * np.max(np.abs(y)), centred, 0.0)


def _with_constant(x: np.ndarray) -> np.ndarray:
    return np.column_stack([np.ones(len(x)), x])


def _changes(x: np.ndarray, y: np.ndarray, confidence: float) -> tuple[list[float], list[Interval]]:
    """Slopes of the plane over the whole range and their intervals."""
    solve = np.linalg.pinv(_with_constant(x))
    slopes = solve @ y
    leverage = np.sum(_with_constant(x) * solve.T, axis=1)
    residuals = (y - _with_constant(x) @ slopes) / np.maximum(1.0 - leverage, ROUNDING)
    drawn = np.abs((_signs(len(y)) * residuals) @ solve[1:].T)
    reach = np.quantile(drawn, confidence, axis=0)
    pairs = zip(slopes[1:].tolist(), reach.tolist(), strict=True)
    intervals = [Interval(slope - width, slope + width) for slope, width in pairs]
    return slopes[1:].tolist(), intervals


def _p_values(x: np.ndarray, y: np.ndarray) -> Iterator[float]:
    """Chance of each slope under permutations of the residuals of the plane without it."""
    order = _permutations(len(y))
    for j in range(x.shape[1]):
        basis = np.linalg.qr(_with_constant(np.delete(x, j, axis=1)))[0]
        rest, own = _beside(basis, y[None])[0], _beside(basis, x[None, :, j])[0]
        shuffled = _beside(basis, rest[order])
        size = np.linalg.norm(shuffled, axis=1)
        # A response that the others explain wholly leaves nothing to permute.
        found = np.abs(shuffled @ own) / np.where(size > 0.0, size, 1.0)
        norm = float(np.linalg.norm(rest))
        seen = float(abs(rest @ own)) / norm if norm > 0.0 else 0.0
        yield float((1 + np.sum(found >= seen * (1.0 - ROUNDING))) / (1 + DRAWS))


@lru_cache(maxsize=4)
def _signs(n: int) -> np.ndarray:
    """Signs of the wild bootstrap. Shape (DRAWS, n)."""
    return np.random.default_rng(20080901).choice([-1.0, 1.0], (DRAWS, n))


@lru_cache(maxsize=4)
def _permutations(n: int) -> np.ndarray:
    return np.argsort(np.random.default_rng(19831001).random((DRAWS, n)), axis=1)


def _beside(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What the basis leaves of each row. Shape (m, n)."""
    return rows - (rows @ basis) @ basis.T
