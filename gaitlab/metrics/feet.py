"""How the feet pass over the ground and each other."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET, FSRS
from gaitlab.metrics.metric import metric

TOE_LOAD = 2.0  # front over rear; a level sole carries the two alike, give or take the impact
TOE_DOWN = 0.02  # rad, 2 mm over a sole of 100 mm


@metric(unit="m", better="higher")
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


@metric(unit="-", better="lower")
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


@metric(unit="m", better="higher", counts_falls=True)
def feet_gap(log: TrialLog) -> float:
    """Smallest distance between the two lower legs before the fall, standing included, in [m].

    Feet, and what lies below the knees; negative by the depth where they overlap, which the engine
    lets them do by the tenth of a millimetre that a blow takes to be pushed out. NaN in a log that
    was written before it was looked at. Defined here.
    """
    gaps = log["feet_gap"][: log.fall_index]
    return float(np.min(gaps)) if len(gaps) else nan


@metric(unit="N", better="lower")
def peak_plough_force(log: TrialLog) -> float:
    """Largest horizontal force of the pile on the leading edges of either foot, in [N].

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    plough = np.abs(log.per_foot("plough_force")[log.walking])
    return float(plough.max()) if plough.size else nan


@metric(unit="m")
def sole_penetration(log: TrialLog) -> float:
    """Deepest that a corner of a sole dips into the base below any pile, in [m]; 0 if none does.

    A figure of the simulation: the base is rigid. Over the walk before a fall. NaN when nothing was
    walked. Defined here.
    """
    depth = (log.per_foot("sink") - log.header.pile_height)[log.walking]
    return float(np.maximum(depth.max(), 0.0)) if depth.size else nan
