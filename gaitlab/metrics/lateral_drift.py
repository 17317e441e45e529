"""How far the robot strayed to the side."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "m"


def lateral_drift(log: TrialLog) -> float:
    """Trunk position across its first heading at the end, in [m]; left is positive.

    The first heading is that at the end of the start-up; the end is the last tick before a fall.
    NaN when nothing was walked. Defined here.
    """
    across = log.displacement[log.walking, 1]
    return float(across[-1]) if len(across) else nan
