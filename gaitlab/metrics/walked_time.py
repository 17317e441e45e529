"""How long the robot walked."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "s"
BETTER = "higher"
COUNTS_FALLS = True


def walked_time(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall or the end of the trial, in [s].

    Zero for a trial that ended in the start-up.
    """
    return log.walked_time
