"""Until when a robot stood well, and how it left that stand."""

from __future__ import annotations

from math import cos, inf, nan, radians
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.log import LogHeader, TrialLog

GOOD_MARGIN = 0.005  # m, ZMP inside the support polygon; the last millimetres are impact noise
GOOD_TILT = cos(radians(20.0))  # -, R33; walks that stay up hardly ever lean farther
COLUMNS = ("time", "zmp_margin", "trunk_qx", "trunk_qy", "fall_cause")  # what `stand` reads
SUPPORTS = ("flight", "left foot", "right foot", "both feet")  # by the log's code
Axis = Literal["fore-aft", "sideways", "neither"]


class Stand(NamedTuple):
    """Until when a robot stood well.

    Attributes:
        row: Row of the log; -1 if it never did.
        cycles: Gait cycles since walking at full amplitude began; negative in the start-up.
        lead: Time from then to the fall, in [s]; NaN without one.
    """

    row: int
    cycles: float
    lead: float


def stand(header: LogHeader, arrays: dict[str, np.ndarray]) -> Stand:
    """The last instant before a fall at which the ZMP was well inside and the trunk upright.

    Well inside is `GOOD_MARGIN`, upright a tilt of up to 20 degrees. Without a fall it is the
    end of the log. Defined here.

    Args:
        header: Of the log.
        arrays: The columns `COLUMNS`. Shape (n,) each.
    """
    fallen = np.flatnonzero(arrays["fall_cause"])
    end = int(fallen[0]) if len(fallen) else len(arrays["time"]) - 1
    row = end
    if len(fallen):
        upright = 1.0 - 2.0 * (arrays["trunk_qx"] ** 2 + arrays["trunk_qy"] ** 2)
        good = (arrays["zmp_margin"] >= GOOD_MARGIN) & (upright >= GOOD_TILT)
        found = np.flatnonzero(good[: end + 1])
        row = int(found[-1]) if len(found) else -1
    cycles = ((row + 1) * header.dt - header.startup_time) / header.gait_period
    return Stand(row, cycles, (end - row) * header.dt if len(fallen) else nan)


def row_at(header: LogHeader, cycles: float) -> int:
    """Row of the log that ends so many gait cycles after the start-up."""
    return round((header.startup_time + cycles * header.gait_period) / header.dt) - 1


def support_at(log: TrialLog, row: int) -> str:
    """Which feet carried load in a row."""
    return SUPPORTS[int(log["support"][max(row, 0)])]


def first_axis(log: TrialLog, row: int) -> Axis:
    """In which axis the trunk first left what it had done in the gait cycle before a row.

    Fore-aft if the pitch left its range first, sideways if the roll did. Defined here.
    """
    start = max(0, row + 1 - round(log.header.gait_period / log.header.dt))
    pitch, roll = (_leaves(log[name], start, row + 1) for name in ("pitch", "roll"))
    if pitch == roll:
        return "neither"
    return "fore-aft" if pitch < roll else "sideways"


def _leaves(angle: np.ndarray, start: int, stop: int) -> float:
    """Rows after `stop` until an angle leaves its range over the rows before."""
    if start >= stop:
        return inf
    low, high = angle[start:stop].min(), angle[start:stop].max()
    beyond = np.flatnonzero((angle[stop:] < low) | (angle[stop:] > high))
    return float(beyond[0]) if len(beyond) else inf
