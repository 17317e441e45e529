"""How much the normalised ZMP of the NAO study fluctuates between exchanges of support."""

from __future__ import annotations

from math import nan

from gaitlab.kinematics.fsr import fluctuation
from gaitlab.log import TrialLog
from gaitlab.log.sensing import exchanges, normalised_zmp_signal

UNIT = "-"
NEEDS = ("force sensors", "cycle")
BETTER = "lower"


def zmp_normalised_fluctuation(log: TrialLog) -> float:
    """Total variation of the normalised x of the ZMP over twice the exchanges, less one.

    The index is that of Shaari et al., as printed, from sensors averaged over 10 ms; its values
    beyond [-1, 1], which come from a division by almost nothing, count as they are. From the first
    mid-step to the last of the cycles that `roll_amplitude` uses; NaN without sensors or without
    a cycle. The measure of fluctuation is defined here.
    """
    rows, count = exchanges(log)
    if not count or log.header.sensors is None:
        return nan
    return fluctuation(normalised_zmp_signal(log, rows)[:, 0], count)
