"""The largest torque any servo gave."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "N m"
BETTER = "lower"


def peak_torque(log: TrialLog) -> float:
    """Largest torque of any servo, either way, in [N m].

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = np.abs(log.driven_table("torque")[log.walking])
    return float(torque.max()) if torque.size else nan
