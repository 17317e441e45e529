"""How often the servos give all they have."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "lower"
NEAR_LIMIT = 0.98  # of the limit; what quantised targets and float32 leave of it


def saturation_share(log: TrialLog) -> float:
    """Share of joints and ticks in which the torque reaches its limit.

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = np.abs(log.driven_table("torque")[log.walking])
    limits = np.array([limit for limit in log.header.torque_limits if limit > 0.0])
    reached = torque >= NEAR_LIMIT * limits
    return float(np.mean(reached)) if reached.size else nan
