"""How fast the robot walked."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "m/s"
BETTER = "higher"


def walking_speed(log: TrialLog) -> float:
    """Distance over walked time, in [m/s]; positive in the commanded direction.

    NaN when nothing was walked. Defined here.
    """
    return log.distance / log.walked_time if log.walked_time else nan
