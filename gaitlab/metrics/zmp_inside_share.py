"""How much of the time the robot stands on its soles and not on their edges."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "higher"
EDGE = 0.001  # m, closer is on the edge, which rounded supports blur by as much


def zmp_inside_share(log: TrialLog) -> float:
    """Share of the ticks with a foot on the ground in which the ZMP lies clear of every edge.

    Forces that only push cannot bring the ZMP out of the polygon: a robot that rocks over an edge
    has its ZMP on it. Over the walk before a fall; ticks in flight do not count. NaN without any
    tick on the ground. Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(np.mean(margin > EDGE)) if len(margin) else nan
