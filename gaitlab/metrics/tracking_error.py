"""How far the joints are from where they were told to be."""

from __future__ import annotations

from math import nan, sqrt

import numpy as np

from gaitlab.log import TrialLog

UNIT = "rad"
BETTER = "lower"


def tracking_error(log: TrialLog) -> float:
    """Root mean square of target less position over all joints with a servo, in [rad].

    The target is what was sent, so the servo's lag and latency count as much as the load does. Over
    the walk before a fall. NaN when nothing was walked. Defined here.
    """
    errors = (log.driven_table("target") - log.driven_table("position"))[log.walking]
    return sqrt(float(np.mean(errors**2))) if errors.size else nan
