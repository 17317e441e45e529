"""How far a point stands inside the support polygon.

The signed distance of p to a convex set is the minimum over unit directions u of h(u) - u p, where
h is the set's support function. Every direction gives an upper bound, so it suffices to try all
that can attain the minimum: normals of lines through two corners and directions from a corner to
p. No hull is built, and corners may coincide. Derived here.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np


def support_margin(point: np.ndarray, corners: np.ndarray, loaded: np.ndarray) -> np.ndarray:
    """Signed distance of points to the edge of the convex hull of the loaded soles.

    Args:
        point: In the plane of the soles, in [m]. Shape (n, 2).
        corners: Sole corners of the left and right foot in any order, in [m]. Shape (n, 2, 4, 2).
        loaded: Which feet carry load. Shape (n, 2).

    Returns:
        Distance in [m], positive inside, NaN where no foot is loaded. Shape (n,).
    """
    loaded = np.asarray(loaded, dtype=bool)
    # An unloaded foot's corners repeat the other's, which leaves the hull as it is.
    standing = np.where(loaded[:, :, None, None], corners, corners[:, ::-1])
    margin = hull_margin(point, standing.reshape(len(standing), -1, 2))
    return np.where(loaded.any(axis=1), margin, np.nan)


def hull_margin(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Signed distance of points to the boundary of convex hulls.

    Args:
        point: In [m]. Shape (n, 2).
        corners: Points that span the hull, k >= 1, in [m]. Shape (n, k, 2).

    Returns:
        Distance in [m], positive inside. Shape (n,).
    """
    # Corners relative to the point, instants last: each operation runs over contiguous memory.
    x, y = np.ascontiguousarray(np.moveaxis(corners - point[:, None], 0, -1).transpose(1, 0, 2))
    margin = np.full(len(point), np.inf)
    for i, j in combinations(range(len(x)), 2):
        low, high = _extent(x, y, y[i] - y[j], x[j] - x[i])
        margin = np.minimum(margin, np.minimum(high, -low))
    for i in range(len(x)):
        margin = np.minimum(margin, _extent(x, y, -x[i], -y[i])[1])
    return np.where(np.isinf(margin), 0.0, margin)  # point and corners all coincide


def _extent(
    x: np.ndarray, y: np.ndarray, ux: np.ndarray, uy: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Extent of the corners along a direction; unbounded where the direction is null."""
    length = np.hypot(ux, uy)
    null = length == 0.0
    scale = 1.0 / np.where(null, 1.0, length)
    along = x * (ux * scale) + y * (uy * scale)
    low, high = along.min(axis=0), along.max(axis=0)
    return np.where(null, -np.inf, low), np.where(null, np.inf, high)
