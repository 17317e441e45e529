"""How often the robot lands on its toes."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET, FSRS

UNIT = "-"
BETTER = "lower"
TOE_LOAD = 2.0  # front over rear; a level sole carries the two alike, give or take the impact
TOE_DOWN = 0.02  # rad, 2 mm over a sole of 100 mm


def toe_first_share(log: TrialLog) -> float:
    """Share of landings in which the toe comes down first.

    A landing ends a completed swing, see `TrialLog.swings`. The toe is first when, at the first
    loaded tick, the front FSRs carry twice the load of the rear ones or the sole points down. A
    level landing is neither. NaN without a landing. Defined here.
    """
    toe_first = [
        _toe_first(log, side, swing.stop)
        for side, swings in zip(FEET, log.swings, strict=True)
        for swing in swings
    ]
    return float(np.mean(toe_first)) if toe_first else nan


def _toe_first(log: TrialLog, side: str, row: int) -> bool:
    """Whether one foot stands on its toe in a row, by its load or by its attitude."""
    loads = {fsr: float(log.arrays[f"{side}_foot_fsr_{fsr}"][row]) for fsr in FSRS}
    front = loads["front_left"] + loads["front_right"]
    rear = loads["rear_left"] + loads["rear_right"]
    return front > TOE_LOAD * rear or _slope(log, side, row) > TOE_DOWN


def _slope(log: TrialLog, side: str, row: int) -> float:
    """Sine of the angle by which the sole points below the horizon, -R31, in a row."""
    x, y, z, w = (float(log.arrays[f"{side}_foot_q{axis}"][row]) for axis in "xyzw")
    return 2.0 * (w * y - x * z)
