"""How hard the pile holds the feet back."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "N"
BETTER = "lower"


def peak_plough_force(log: TrialLog) -> float:
    """Largest horizontal force of the pile on the leading edges of either foot, in [N].

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    plough = np.abs(log.per_foot("plough_force")[log.walking])
    return float(plough.max()) if plough.size else nan
