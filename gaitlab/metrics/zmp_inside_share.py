"""How much of the time the ZMP lies in the support polygon."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "-"


def zmp_inside_share(log: TrialLog) -> float:
    """Share of the ticks with a foot on the ground in which the ZMP lies inside or on the edge.

    Over the walk before a fall; ticks in flight do not count. NaN without any tick on the ground.
    Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(np.mean(margin >= 0.0)) if len(margin) else nan
