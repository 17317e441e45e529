"""What a robot's own force sensors tell of a log, read as slowly as sensors are read.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.fsr import averaged, load_index, normalised_zmp
from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET, FSRS

READING = 0.01  # s between two readings; NAO's own


def readings(log: TrialLog, table: np.ndarray) -> np.ndarray:
    """Means of rows of a log over each reading. Shape (n, ...) to (readings, ...)."""
    return averaged(table, max(1, round(READING / log.header.dt)))


def load_index_signal(log: TrialLog, rows: slice) -> np.ndarray:
    """Share of the left foot less share of the right in the load, in [-1, 1]. Shape (readings,)."""
    return load_index(*readings(log, log.per_foot("normal_force")[rows]).T)


def normalised_zmp_signal(log: TrialLog, rows: slice) -> np.ndarray:
    """Normalised x and y of the ZMP as printed, [Shaari2015] eq. (2.17). Shape (readings, 2).

    NaN in flight, where it is singular, and throughout for a robot without sensors.
    """
    if log.header.sensors is None:
        return np.full((len(readings(log, log["time"][rows])), 2), np.nan)
    left, right = (readings(log, log.vector(f"{side}_foot_fsr_", FSRS)[rows]) for side in FEET)
    return normalised_zmp(left, right, log.header.sensors)


def exchanges(log: TrialLog) -> tuple[slice, int]:
    """Rows of the measured cycles from the first mid-step to the last, and how often in them the
    feet exchange roles by the gait's clock; no rows without a measured cycle.
    """
    cycles = log.measured_cycles
    if not cycles:
        return slice(0, 0), 0
    quarter = round(0.25 * log.header.gait_period / log.header.dt)
    return slice(cycles[0].start + quarter, cycles[-1].stop - quarter), 2 * len(cycles) - 1
