"""How hard the servos work on average."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "N m"
BETTER = "lower"


def rms_torque(log: TrialLog) -> float:
    """Root mean square of the torque over all joints and ticks, in [N m]; what heats the motors.

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = log.driven_table("torque")[log.walking]
    return float(np.sqrt(np.mean(torque**2))) if torque.size else nan
