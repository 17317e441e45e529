"""How far a point stands inside the support polygon.

The signed distance of p to a convex set is the minimum over unit directions u of h(u) - u p, where
h is the set's support function. Every direction gives an upper bound, so it suffices to try all
that can attain the minimum: normals of lines through two corners and directions from a corner to
p. No hull is built, and corners may coincide. Derived here.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.compiled import njit

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
    return _margins(point, corners, np.asarray(loaded, dtype=bool))


def hull_margin(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Signed distance of points to the boundary of convex hulls.

    Args:
        point: In [m]. Shape (n, 2).
        corners: Points that span the hull, k >= 1, in [m]. Shape (n, k, 2).

    Returns:
        Distance in [m], positive inside. Shape (n,).
    """
    return _margins(point, corners[:, None], np.ones((len(point), 1), dtype=bool))


@njit
def _margins(point: np.ndarray, corners: np.ndarray, loaded: np.ndarray) -> np.ndarray:
    """Margins to the hulls of the loaded ones of some groups of corners; NaN where none is."""
    _, groups, each, _ = corners.shape
    x, y = np.empty(groups * each), np.empty(groups * each)  # relative to the point
    found = np.empty(len(point))
    for k in range(len(point)):
        count = 0
        for group in range(groups):
            for corner in range(each if loaded[k, group] else 0):
                x[count] = corners[k, group, corner, 0] - point[k, 0]
                y[count] = corners[k, group, corner, 1] - point[k, 1]
                count += 1
        margin = np.inf if count and np.isfinite(x[0] + y[0]) else np.nan
        for i in range(count):
            for j in range(i):
                margin = _bounded(margin, x, y, count, y[j] - y[i], x[i] - x[j], True)
        if not 0.0 < margin < np.inf:  # inside, an edge is nearest
            for i in range(count):
                margin = _bounded(margin, x, y, count, -x[i], -y[i], False)
        found[k] = 0.0 if margin == np.inf else margin  # point and corners all coincide
    return found


@njit(inline="always")
def _bounded(
    margin: float, x: np.ndarray, y: np.ndarray, count: int, ux: float, uy: float, both: bool
) -> float:
    """A margin, or the extent of the corners along a direction, or both ways, if that is less."""
    # Most directions are dismissed by two corners, before anything is divided.
    enough = margin * np.sqrt(ux * ux + uy * uy)
    enough += ROUNDING * abs(enough)
    high, low = -np.inf, -np.inf if both else np.inf
    for i in range(count):
        along = x[i] * ux + y[i] * uy
        high, low = max(high, along), max(low, -along)
        if high > enough and low > enough:
            return margin
    length = np.hypot(ux, uy)
    if length == 0.0:
        return margin
    scale = 1.0 / length
    ux, uy, high, low = ux * scale, uy * scale, -np.inf, -np.inf if both else np.inf
    for i in range(count):
        along = x[i] * ux + y[i] * uy
        high, low = max(high, along), max(low, -along)
    return min(margin, high, low)
