"""How far the robot walked."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"
COUNTS_FALLS = True


def distance(log: TrialLog) -> float:
    """How far the trunk came from the end of the start-up to the fall or the end, in [m].

    Measured along the trunk's heading at the end of the start-up; positive in the commanded
    direction, so a robot that walks backwards as told scores positive. Toppling moves the trunk,
    too, and counts until the fall is established. NaN when nothing was walked. Defined here.
    """
    return log.distance
