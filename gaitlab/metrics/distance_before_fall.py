"""How far the robot got, on the scale of the EROS experiments.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "m"
BETTER = "higher"
COUNTS_FALLS = True
LONGEST = 6.0  # m, length of a run in [EROS2018]


def distance_before_fall(log: TrialLog) -> float:
    """Largest distance reached before the fall or the end, clipped to [0, 6] m, in [m].

    Six metres is the run of [EROS2018]. Zero for a fall in the start-up; NaN when the trial ended
    in the start-up without a fall.
    """
    walked = log.displacement[log.walking, 0]
    if not len(walked):
        return nan if log.fall_index is None else 0.0
    return float(np.clip(walked.max(), 0.0, LONGEST))
