"""How often the load goes back and forth between the feet."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.kinematics.fsr import READING, averaged, fluctuation, load_index
from gaitlab.log import TrialLog

UNIT = "-"


def load_index_fluctuation(log: TrialLog) -> float:
    """Total variation of the load index over twice the exchanges of support, less one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. 0 if every exchange carries all load from one foot to
    the other once; a load that goes half over, back and over again counts 1. Over the cycles that
    `roll_amplitude` uses; NaN without a complete one. Defined here.
    """
    force, ticks = log.per_foot("normal_force"), max(1, round(READING / log.header.dt))
    values = [
        fluctuation(load_index(*averaged(force[cycle], ticks).T), 2.0)
        for cycle in log.measured_cycles
    ]
    return float(np.mean(values)) if values else nan
