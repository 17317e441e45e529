"""What walking costs."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.metrics.metric import metric


@metric(unit="J")
def energy(log: TrialLog) -> float:
    """Positive mechanical work of all servos, the sum of max(torque x velocity, 0) dt, in [J].

    The velocity is the mean one of each tick. Braking gives nothing back, joint by joint. Over the
    walk before a fall. NaN when nothing was walked. Defined here.
    """
    return log.work


@metric(unit="J")
def absolute_work(log: TrialLog) -> float:
    """Sum of |torque x velocity| dt over all servos, in [J]: what servos cost that brake actively.

    The velocity is the mean one of each tick. Over the walk before a fall. NaN when nothing was
    walked. Defined here.
    """
    power = log.joint_power[log.walking]
    return float(np.abs(power).sum()) * log.header.dt if power.size else nan


@metric(unit="-", better="lower", needs=("distance",))
def cost_of_transport(log: TrialLog) -> float:
    """Positive mechanical work of the servos over weight times distance, E / (m g d).

    The work is that of `energy`, without the heat of the motors. NaN when no distance is commanded
    or the robot did not get ahead. Defined here.
    """
    if not log.commanded_distance or not log.distance > 0.0:
        return nan
    return log.work / (log.header.weight * log.distance)
