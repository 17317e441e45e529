"""How often the feet change roles in one exchange of support."""

from __future__ import annotations

from math import nan

from gaitlab.kinematics.fsr import crossings
from gaitlab.log import TrialLog
from gaitlab.log.sensing import exchanges, load_index_signal

UNIT = "-"
NEEDS = ("cycle",)
BETTER = "lower"


def load_index_crossings(log: TrialLog) -> float:
    """Sign changes of the load index an exchange of support, less one: 0 if each is a clean one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. From the first mid-step to the last of the cycles that
    `roll_amplitude` uses; NaN without any. Defined here.
    """
    rows, count = exchanges(log)
    return crossings(load_index_signal(log, rows)) / count - 1.0 if count else nan
