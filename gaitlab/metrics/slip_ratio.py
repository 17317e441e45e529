"""Share of the commanded distance that was covered."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "-"
NEEDS = ("distance",)
BETTER = "higher"


def slip_ratio(log: TrialLog) -> float:
    """Distance over the distance commanded in the walked time: 1 without slip, 0 for marking time.

    Negative when the robot went the wrong way. NaN when no distance is commanded or nothing was
    walked. Defined here.
    """
    return log.distance / log.commanded_distance if log.commanded_distance else nan
