"""How much the normalised ZMP of the NAO study fluctuates between exchanges of support."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.kinematics.fsr import READING, averaged, fluctuation, normalised_zmp
from gaitlab.log import FEET, FSRS, TrialLog

UNIT = "-"


def zmp_normalised_fluctuation(log: TrialLog) -> float:
    """Total variation of the normalised x of the ZMP over twice the exchanges, less one.

    The index is that of Shaari et al., as printed, from sensors averaged over 10 ms; its values
    beyond [-1, 1], which come from a division by almost nothing, count as they are. Over the
    cycles that `roll_amplitude` uses. NaN without sensors or a complete cycle. The measure of
    fluctuation is defined here.
    """
    sensors, ticks = log.header.sensors, max(1, round(READING / log.header.dt))
    if sensors is None or not log.measured_cycles:
        return nan
    tables = [log.vector(f"{side}_foot_fsr_", FSRS) for side in FEET]
    values = [
        fluctuation(normalised_zmp(*(averaged(t[cycle], ticks) for t in tables), sensors)[:, 0], 2)
        for cycle in log.measured_cycles
    ]
    return float(np.mean(values))
