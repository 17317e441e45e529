"""Whether the robot fell before it was to walk."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "lower"


def fell_standing(log: TrialLog) -> bool:
    """Whether the robot fell before its first commanded step, so that no walk was tried.

    The step begins as the gait first means a foot to be in the air; a motion that never does begins
    with its first movement, and who only stands has every fall counted here. Never in a log that
    does not know the instant. Defined here.
    """
    return log.fell_standing
