"""How often the load goes back and forth between the feet."""

from __future__ import annotations

from math import nan

from gaitlab.kinematics.fsr import fluctuation
from gaitlab.log import TrialLog
from gaitlab.log.sensing import exchanges, load_index_signal

UNIT = "-"
NEEDS = ("cycle",)
BETTER = "lower"


def load_index_fluctuation(log: TrialLog) -> float:
    """Total variation of the load index over twice the exchanges of support, less one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. 0 if every exchange carries all load from one foot to
    the other once; a load that goes half over, back and over again counts 0.5. From the first
    mid-step to the last of the cycles that `roll_amplitude` uses; NaN without any. Defined here.
    """
    rows, count = exchanges(log)
    return fluctuation(load_index_signal(log, rows), count) if count else nan
