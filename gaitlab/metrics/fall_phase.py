"""At which phase of the gait the robot fell."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "-"


def fall_phase(log: TrialLog) -> float:
    """Gait phase in [0, 1) at the tick that establishes the fall.

    NaN without a fall and for a fall in the start-up, which has no phase. Defined here.
    """
    return nan if log.fall_index is None else float(log["gait_phase"][log.fall_index])
