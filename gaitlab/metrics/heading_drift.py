"""How far the robot turned."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "rad"


def heading_drift(log: TrialLog) -> float:
    """Change of the trunk's yaw over the walk, whole turns included, in [rad]; left is positive.

    The end is the last tick before a fall. NaN when nothing was walked. Defined here.
    """
    yaw = np.unwrap(log["yaw"][log.walking])
    return float(yaw[-1] - yaw[0]) if len(yaw) else nan
