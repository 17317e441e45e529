"""How deep soles enter the hard base of the simulation."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"


def sole_penetration(log: TrialLog) -> float:
    """Deepest that a corner of a sole dips into the base below any pile, in [m]; 0 if none does.

    A figure of the simulation: the base is rigid. Over the walk before a fall. NaN when nothing was
    walked. Defined here.
    """
    depth = (log.per_foot("sink") - log.header.pile_height)[log.walking]
    return float(np.maximum(depth.max(), 0.0)) if depth.size else nan
