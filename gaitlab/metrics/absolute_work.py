"""The mechanical work of the servos, braking counted as driving."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "J"


def absolute_work(log: TrialLog) -> float:
    """Sum of |torque x velocity| dt over all servos, in [J]: what servos cost that brake actively.

    The velocity is the mean one of each tick. Over the walk before a fall. NaN when nothing was
    walked. Defined here.
    """
    power = log.joint_power[log.walking]
    return float(np.abs(power).sum()) * log.header.dt if power.size else nan
