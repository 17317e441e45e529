"""Whether the robot stayed on its feet and went where it was told."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "higher"


def stable_strict(log: TrialLog) -> bool:
    """Whether the robot neither fell nor stalled.

    A robot that is told to step on the spot only has to stay up. Defined here.
    """
    return log.fall_index is None and not log.stalled
