"""How often the normalised ZMP of the NAO study leaves its bounds."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.sensing import normalised_zmp_signal

UNIT = "-"
NEEDS = ("force sensors",)
BETTER = "lower"
ROUNDING = 1e-6  # one foot in the air gives 1, up to the digits of the log


def zmp_normalised_outside(log: TrialLog) -> float:
    """Share of the readings at which the normalised x of the ZMP leaves [-1, 1].

    The index is that of Shaari et al., (left - right) / (left + right) of what the force sensors
    of the two feet give, as printed; they call a robot stable inside. Sensors are averaged over
    10 ms. Over the walk before a fall; readings at which the index is not defined do not count.
    NaN without sensors or without a walk.
    """
    x = normalised_zmp_signal(log, log.walking)[:, 0]
    x = x[np.isfinite(x)]
    return float(np.mean(np.abs(x) > 1.0 + ROUNDING)) if len(x) else nan
