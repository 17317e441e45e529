"""How near the two lower legs come to each other."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"
COUNTS_FALLS = True


def feet_gap(log: TrialLog) -> float:
    """Smallest distance between the two lower legs before the fall, standing included, in [m].

    Feet, and what lies below the knees; negative by the depth where they overlap, which the engine
    lets them do by the tenth of a millimetre that a blow takes to be pushed out. NaN in a log that
    was written before it was looked at. Defined here.
    """
    gaps = log["feet_gap"][: log.fall_index]
    return float(np.min(gaps)) if len(gaps) else nan
