"""How much the trunk rocks about its forward axis."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "rad"
NEEDS = ("cycle",)
BETTER = "lower"


def roll_amplitude(log: TrialLog) -> float:
    """Mean over gait cycles of half the range of the trunk roll, in [rad]; a mean lean cancels.

    The cycles are the steady ones: from the third on and, before a fall, those that end a period
    ahead of it, so that the fall itself is not measured. With fewer than two of them the first two
    count as well, with none the last before a fall; then `pitch_settled` is False. NaN without a
    complete cycle. Companion of `pitch_amplitude`.
    """
    roll = log["roll"]
    ranges = [np.ptp(roll[cycle]) for cycle in log.measured_cycles]
    return float(np.mean(ranges)) / 2.0 if ranges else nan
