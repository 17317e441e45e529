"""How much the trunk rocks about its lateral axis.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "rad"
NEEDS = ("cycle",)
BETTER = "lower"


def pitch_amplitude(log: TrialLog) -> float:
    """Mean over gait cycles of half the range of the trunk pitch, in [rad]; a mean lean cancels.

    The cycles are the steady ones: from the third on and, before a fall, those that end a period
    ahead of it, so that the fall itself is not measured. With fewer than two of them the first two
    count as well, with none the last before a fall; then `pitch_settled` is False. NaN without a
    complete cycle. Meant to be the pitch vibration of [EROS2018], which leaves it undefined.
    """
    pitch = log["pitch"]
    ranges = [np.ptp(pitch[cycle]) for cycle in log.measured_cycles]
    return float(np.mean(ranges)) / 2.0 if ranges else nan
