"""How often the robot lands on its toes."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import FEET, FSRS, TrialLog

UNIT = "-"


def toe_first_share(log: TrialLog) -> float:
    """Share of landings in which the toe comes down first.

    A landing ends a completed swing, see `TrialLog.swings`. The toe is first when the front FSRs
    carry more than the rear ones at the first loaded tick, or, if they carry the same, when the
    sole points down. NaN without a landing. Defined here.
    """
    toe_first = [
        _toe_first(log, side, swing.stop)
        for side, swings in zip(FEET, log.swings, strict=True)
        for swing in swings
    ]
    return float(np.mean(toe_first)) if toe_first else nan


def _toe_first(log: TrialLog, side: str, row: int) -> bool:
    """Whether the toe of one foot carries more than its heel, or the sole points down, in a row."""
    loads = {fsr: float(log.arrays[f"{side}_foot_fsr_{fsr}"][row]) for fsr in FSRS}
    front = loads["front_left"] + loads["front_right"]
    rear = loads["rear_left"] + loads["rear_right"]
    return front > rear if front != rear else _toe_down(log, side, row)


def _toe_down(log: TrialLog, side: str, row: int) -> bool:
    """Whether the x axis of the foot points below the horizon, -R31 > 0, in a row."""
    x, y, z, w = (float(log.arrays[f"{side}_foot_q{axis}"][row]) for axis in "xyzw")
    return w * y - x * z > 0.0
