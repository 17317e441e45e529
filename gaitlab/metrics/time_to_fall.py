"""When the robot fell."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "s"
BETTER = "higher"
COUNTS_FALLS = True


def time_to_fall(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall, in [s]; negative for a fall in the start-up.

    The fall is the tick that establishes it. NaN without a fall. Defined here.
    """
    if log.fall_index is None:
        return nan
    return float(log["time"][log.fall_index]) - log.header.startup_time
