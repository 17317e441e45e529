"""Smallest stability margin of the walk."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"


def zmp_margin_min(log: TrialLog) -> float:
    """Smallest margin of the ZMP to the edge of the support polygon, in [m]; positive inside.

    Over the walk before a fall; ticks in flight do not count. NaN without any tick on the ground.
    Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(margin.min()) if len(margin) else nan
