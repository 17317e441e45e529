"""Stability as the EROS paper counts it: cells, surfaces and efficiency.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

import numpy as np

STABLE_SHARE = 0.5  # of its seeds; a cell with half of them on their feet counts as stable


def stable_cell(share: float) -> bool:
    """Whether a cell is stable: at least half of its seeds are."""
    return share >= STABLE_SHARE


def stability_percent(cells: Sequence[bool]) -> float:
    """Stability percentage of a surface [EROS2018]: stable cells over all, NaN without any."""
    return 100.0 * sum(map(bool, cells)) / len(cells) if len(cells) else nan


def efficiency(per_surface: Sequence[float]) -> float:
    """Mean of the surfaces' stability percentages [EROS2018]; nothing to do with energy.

    Args:
        per_surface: Stability percentage of each surface. NaN without any.
    """
    return float(np.mean(per_surface)) if len(per_surface) else nan


def distance_difference(with_it: float, without: float, longest: float = 6.0) -> float:
    """Difference of distance in percent of the longest possible, in [m] all three, [EROS2018]."""
    return 100.0 * (with_it - without) / longest
