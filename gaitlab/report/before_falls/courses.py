"""What changes from gait cycle to gait cycle on the way to a fall: rocking that grows, a ZMP that
drifts."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log_columns import FEET

FEWEST = 3  # cycles; a line through two points has no scatter to doubt it by


class Courses(NamedTuple):
    """How a walk changes over its cycles at full amplitude; NaN with fewer than three.

    Attributes:
        pitch_growth: Growth of the pitch amplitude a cycle; 0.1 is 10 percent.
        roll_growth: The same of the roll.
        zmp_drift: Change of the ZMP ahead of the soles' centre a cycle, in [m].
        cycles: Cycles that were used.
    """

    pitch_growth: float
    roll_growth: float
    zmp_drift: float
    cycles: int


def courses(log: TrialLog, row: int) -> Courses:
    """Rates over the complete gait cycles that were walked at full amplitude up to a row."""
    pieces = [cycle for cycle in log.cycles if cycle.stop <= row + 1]
    if len(pieces) < FEWEST:
        return Courses(nan, nan, nan, len(pieces))
    ahead = zmp_ahead(log)
    offsets = np.array([median(ahead[piece]) for piece in pieces])
    pitch, roll = (
        growth([float(np.ptp(log[name][piece])) for piece in pieces]) for name in ("pitch", "roll")
    )
    return Courses(pitch, roll, slope(offsets), len(pieces))


def growth(ranges: list[float]) -> float:
    """Rate a cycle at which amplitudes grow: exp of the slope of their logarithm, less 1."""
    if min(ranges) <= 0.0:
        return nan
    return float(np.expm1(slope(np.log(ranges))))


def slope(values: np.ndarray) -> float:
    """Least-squares slope over the index of those that are defined; NaN with fewer than three."""
    known = np.flatnonzero(np.isfinite(values))
    return float(np.polyfit(known, values[known], 1)[0]) if len(known) >= FEWEST else nan


def zmp_ahead(log: TrialLog) -> np.ndarray:
    """ZMP ahead of the centre of the soles that carry load, along the trunk's heading, in [m].

    Of two loaded soles the middle between them. NaN in flight. Shape (n,).
    """
    loaded = log.per_foot("contact").astype(bool)
    centres = np.stack([log.vector(f"{side}_foot_", "xy") for side in FEET], axis=1)
    count = loaded.sum(axis=1)
    weights = loaded / np.maximum(count, 1)[:, None]
    offset = log.vector("zmp_", "xy") - (weights[:, :, None] * centres).sum(axis=1)
    ahead = offset[:, 0] * np.cos(log["yaw"]) + offset[:, 1] * np.sin(log["yaw"])
    return np.where(count > 0, ahead, np.nan)


def median(values: np.ndarray) -> float:
    """Median of those that are defined; NaN with none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else nan
