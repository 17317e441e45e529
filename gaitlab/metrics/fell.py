"""Whether the robot fell."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "lower"


def fell(log: TrialLog) -> bool:
    """Whether the robot fell within the horizon, in the start-up or later.

    The rule is that of `gaitlab.log.fall`.
    """
    return log.fall_index is not None
