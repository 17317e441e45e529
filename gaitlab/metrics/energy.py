"""The mechanical work of the servos."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "J"


def energy(log: TrialLog) -> float:
    """Positive mechanical work of all servos, the sum of max(torque x velocity, 0) dt, in [J].

    The velocity is the mean one of each tick. Braking gives nothing back, joint by joint. Over the
    walk before a fall. NaN when nothing was walked. Defined here.
    """
    return log.work
