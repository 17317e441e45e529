"""The moment by which a gantry kept the trunk from pitching, on average."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.model import GANTRY_PITCH

UNIT = "N m"
NEEDS = ("gantry",)
BETTER = "lower"


def rms_balancing_moment(log: TrialLog) -> float:
    """Root mean square of the pitching moment of the gantry, in [N m].

    What a balancing mechanism would have to supply in its place. Over the walk before a fall. NaN
    for a robot on its own or when nothing was walked. Defined here.
    """
    if GANTRY_PITCH not in log.header.joints:
        return nan
    moment = log[f"{GANTRY_PITCH}_torque"][log.walking]
    return float(np.sqrt(np.mean(moment**2))) if moment.size else nan
