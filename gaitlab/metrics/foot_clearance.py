"""How high the swing foot passes over the surface."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"


def foot_clearance(log: TrialLog) -> float:
    """Median over swings of the lowest sole corner's height over the pile in mid-swing, in [m].

    For each completed swing the smallest height in the middle third of it; negative when the foot
    drags through the pile. `TrialLog.swings` says when a foot swings. NaN without a completed
    swing. Defined here.
    """
    sink = log.per_foot("sink")
    heights = [
        -np.max(sink[_middle(swing), foot]) for foot in range(2) for swing in log.swings[foot]
    ]
    return float(np.median(heights)) if heights else nan


def _middle(swing: slice) -> slice:
    """Middle third of a swing, one row at least."""
    third = (swing.stop - swing.start) // 3
    return slice(swing.start + third, swing.stop - third)
