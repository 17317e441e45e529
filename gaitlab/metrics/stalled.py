"""Whether the robot stayed on its feet but hardly moved."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "lower"


def stalled(log: TrialLog) -> bool:
    """Whether the robot did not fall but covered less than half of the commanded distance.

    Never when no distance is commanded. Defined here.
    """
    return log.stalled
