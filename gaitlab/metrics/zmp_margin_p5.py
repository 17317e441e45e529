"""Stability margin that is undercut in one tick of twenty."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"


def zmp_margin_p5(log: TrialLog) -> float:
    """5th percentile of the margin of the ZMP to the edge of the support polygon, in [m].

    Over the walk before a fall; ticks in flight do not count. NaN without any tick on the ground.
    Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(np.percentile(margin, 5.0)) if len(margin) else nan
