"""How often the normalised ZMP of the NAO study leaves its bounds."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.kinematics.fsr import READING, averaged, normalised_zmp
from gaitlab.log import FEET, FSRS, TrialLog

UNIT = "-"
ROUNDING = 1e-6  # one foot in the air gives 1, up to the digits of the log


def zmp_normalised_outside(log: TrialLog) -> float:
    """Share of the readings at which the normalised x of the ZMP leaves [-1, 1] or is singular.

    The index is that of Shaari et al., (left - right) / (left + right) of what the force sensors
    of the two feet give, as printed; they call a robot stable inside. Sensors are averaged over
    10 ms. Over the walk before a fall; readings in flight do not count. NaN without sensors or
    without a walk.
    """
    walked, ticks = log.walking, max(1, round(READING / log.header.dt))
    if log.header.sensors is None or walked.stop - walked.start < ticks:
        return nan
    table = (log.vector(f"{side}_foot_fsr_", FSRS)[walked] for side in FEET)
    left, right = (averaged(loads, ticks) for loads in table)
    on_ground = left.sum(axis=1) + right.sum(axis=1) > 0.0
    x = normalised_zmp(left, right, log.header.sensors)[on_ground, 0]
    return float(np.mean(~(np.abs(x) <= 1.0 + ROUNDING))) if len(x) else nan
