"""The largest moment by which a gantry kept the trunk from pitching."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.model import GANTRY_PITCH

UNIT = "N m"
NEEDS = ("gantry",)
BETTER = "lower"


def peak_balancing_moment(log: TrialLog) -> float:
    """Largest pitching moment of the gantry, either way, in [N m].

    What a balancing mechanism would have to supply in its place, impacts included. Over the walk
    before a fall. NaN for a robot on its own or when nothing was walked. Defined here.
    """
    if GANTRY_PITCH not in log.header.joints:
        return nan
    moment = log[f"{GANTRY_PITCH}_torque"][log.walking]
    return float(np.abs(moment).max()) if moment.size else nan
