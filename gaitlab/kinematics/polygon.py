"""How far a point stands inside the support polygon.

The signed distance of p to a convex set is the minimum over unit directions u of h(u) - u p, where
h is the set's support function. Every direction gives an upper bound, so it suffices to try all
that can attain the minimum: normals of lines through two corners and directions from a corner to
p. No hull is built, and corners may coincide. Derived here.
"""

from __future__ import annotations

import numpy as np
from numba import njit

ROUNDING = 1e-12  # of a length


def support_margin(point: np.ndarray, corners: np.ndarray, loaded: np.ndarray) -> np.ndarray:
    """Signed distance of points to the edge of the convex hull of the loaded soles.

    Args:
        point: In the plane of the soles, in [m]. Shape (n, 2).
        corners: Sole corners of the left and right foot in any order, in [m]. Shape (n, 2, 4, 2).
        loaded: Which feet carry load. Shape (n, 2).

    Returns:
        Distance in [m], positive inside, NaN where no foot is loaded. Shape (n,).
    """
    margin = np.full(len(point), np.nan)
    for feet in ([0], [1], [0, 1]):
        rows = np.flatnonzero((loaded == np.isin((0, 1), feet)).all(axis=1))
        standing = corners[rows[:, None], feet].reshape(len(rows), 4 * len(feet), 2)
        margin[rows] = hull_margin(point[rows], standing)
    return margin


def hull_margin(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Signed distance of points to the boundary of convex hulls.

    Args:
        point: In [m]. Shape (n, 2).
        corners: Points that span the hull, k >= 1, in [m]. Shape (n, k, 2).

    Returns:
        Distance in [m], positive inside. Shape (n,).
    """
    x, y = np.moveaxis(corners - point[:, None], -1, 0)
    return np.where(np.isnan(point).any(axis=1), np.nan, _margins(x, y))


@njit(cache=True)
def _margins(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Margins of corners relative to the point. Shapes (n, k) to (n,)."""
    found = np.empty(len(x))
    for k in range(len(x)):
        margin = np.inf
        for i in range(x.shape[1]):
            for j in range(i):
                across, along = y[k, j] - y[k, i], x[k, i] - x[k, j]
                margin = _bounded(margin, x[k], y[k], across, along, True)
        if not 0.0 < margin < np.inf:  # inside, an edge is nearest
            for i in range(x.shape[1]):
                margin = _bounded(margin, x[k], y[k], -x[k, i], -y[k, i], False)
        found[k] = 0.0 if margin == np.inf else margin  # point and corners all coincide
    return found


@njit(cache=True)
def _bounded(
    margin: float, x: np.ndarray, y: np.ndarray, ux: float, uy: float, both: bool
) -> float:
    """A margin, or the extent of the corners along a direction, or both ways, if that is less."""
    # Most directions are dismissed by two corners, before anything is divided.
    enough = margin * np.sqrt(ux * ux + uy * uy)
    enough += ROUNDING * abs(enough)
    high, low = -np.inf, -np.inf if both else np.inf
    for i in range(len(x)):
        along = x[i] * ux + y[i] * uy
        high, low = max(high, along), max(low, -along)
        if high > enough and low > enough:
            return margin
    length = np.hypot(ux, uy)
    if length == 0.0:
        return margin
    scale = 1.0 / length
    ux, uy, high, low = ux * scale, uy * scale, -np.inf, -np.inf if both else np.inf
    for i in range(len(x)):
        along = x[i] * ux + y[i] * uy
        high, low = max(high, along), max(low, -along)
    return min(margin, high, low)
