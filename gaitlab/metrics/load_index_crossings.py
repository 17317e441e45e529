"""How often the feet change roles in one exchange of support."""

from __future__ import annotations

from math import nan

from gaitlab.kinematics.fsr import READING, averaged, crossings, load_index
from gaitlab.log import TrialLog

UNIT = "-"


def load_index_crossings(log: TrialLog) -> float:
    """Sign changes of the load index an exchange of support, less one: 0 if each is a clean one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. Over the cycles that `roll_amplitude` uses; NaN
    without a complete one. Defined here.
    """
    cycles = log.measured_cycles
    if not cycles:
        return nan
    force = log.per_foot("normal_force")[cycles[0].start : cycles[-1].stop]
    signal = load_index(*averaged(force, max(1, round(READING / log.header.dt))).T)
    return crossings(signal) / (2.0 * len(cycles)) - 1.0
