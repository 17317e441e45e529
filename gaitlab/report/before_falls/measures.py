"""What is measured in one gait cycle of a walk, to be compared with the same cycle of another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import degrees, inf, nan
from typing import NamedTuple

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log_columns import FEET
from gaitlab.metrics.peak_plough_force import peak_plough_force
from gaitlab.metrics.pitch_amplitude import pitch_amplitude
from gaitlab.metrics.roll_amplitude import roll_amplitude
from gaitlab.metrics.toe_first_share import toe_first_share
from gaitlab.metrics.zmp_margin_min import zmp_margin_min
from gaitlab.metrics.zmp_margin_p5 import zmp_margin_p5
from gaitlab.report.before_falls.courses import median, zmp_ahead

LANDINGS = 2  # gait cycles; a swing that begins before a single one would not count as a landing


class Piece(NamedTuple):
    """The end of a walk.

    Attributes:
        cycle: Its last gait cycle, as a log of its own.
        two: Its last two, or all there is.
    """

    cycle: TrialLog
    two: TrialLog


@dataclass(frozen=True)
class Measure:
    """One quantity of a piece.

    Attributes:
        name: What a table calls it.
        unit: In which it is shown.
        scale: From SI to that unit.
        of: The quantity, in SI units; NaN where it is not defined.
        widest: Largest difference there can be, in SI units.
    """

    name: str
    unit: str
    scale: float
    of: Callable[[Piece], float]
    widest: float = inf


def piece_before(log: TrialLog, row: int) -> Piece | None:
    """The gait cycles that end in a row; None if the log does not hold a whole one."""
    period = round(log.header.gait_period / log.header.dt)
    stop = row + 1
    if stop < period or stop > len(log):
        return None
    two = _cut(log, max(0, stop - LANDINGS * period), stop)
    return Piece(_cut(log, stop - period, stop), two)


def _cut(log: TrialLog, start: int, stop: int) -> TrialLog:
    """Rows of a log as a log in which everything is walked."""
    arrays = {name: array[start:stop] for name, array in log.arrays.items()}
    arrays["time"] = log.header.dt * np.arange(1, stop - start + 1)
    arrays["fall_cause"] = np.zeros(stop - start)
    return TrialLog(header=replace(log.header, startup_time=0.0), arrays=arrays)


def stance_sink(piece: Piece) -> float:
    """Median depth of the centre of the only loaded sole below the top of the pile, in [m]."""
    log, foot = piece.cycle, _stance(piece.cycle)
    height = np.where(foot == 0, log["left_foot_z"], log["right_foot_z"])
    return median(log.header.pile_height - height[foot >= 0])


def stance_pitch(piece: Piece) -> float:
    """Median pitch of the only loaded sole, toe down positive, in [rad]."""
    return median(_sole_pitch(piece.cycle))


def stance_rocking(piece: Piece) -> float:
    """Half the range of that pitch between its 5th and 95th percentile, in [rad]."""
    pitch = _sole_pitch(piece.cycle)
    return float(np.ptp(np.percentile(pitch, [5, 95]))) / 2.0 if len(pitch) else nan


def lift(piece: Piece) -> float:
    """Mean over the feet of the largest height of the lowest corner over the pile, in [m]."""
    return float(np.mean(-piece.cycle.per_foot("sink").min(axis=0)))


def single_support(piece: Piece) -> float:
    """Share of the time in which one foot alone carries load."""
    return float(np.mean(_stance(piece.cycle) >= 0))


def _stance(log: TrialLog) -> np.ndarray:
    """The only loaded foot: 0 left, 1 right, -1 when it is not one. Shape (n,)."""
    support = log["support"]
    return np.where((support == 1) | (support == 2), support - 1, -1)


def _sole_pitch(log: TrialLog) -> np.ndarray:
    """Pitch of the only loaded sole against the horizon, in [rad]. Shape (ticks of it,)."""
    foot = _stance(log)
    pitch = np.stack([_pitch_of(log, side) for side in FEET])
    return np.where(foot == 0, pitch[0], pitch[1])[foot >= 0]


def _pitch_of(log: TrialLog, side: str) -> np.ndarray:
    x, y, z, w = log.vector(f"{side}_foot_q", "xyzw").T
    return np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))


DEGREES, MM = degrees(1.0), 1000.0
MEASURES: dict[str, Measure] = {
    "toe_first": Measure("toe-first landings", "%", 100.0, lambda p: toe_first_share(p.two), 1.0),
    "plough": Measure("peak plough force", "N", 1.0, lambda p: peak_plough_force(p.cycle)),
    "plough_share": Measure(
        "peak plough force over weight",
        "%",
        100.0,
        lambda p: peak_plough_force(p.cycle) / p.cycle.header.weight,
    ),
    "sink": Measure("sink of the stance sole", "mm", MM, stance_sink),
    "lift": Measure("swing foot over the tips", "mm", MM, lift),
    "lift_base": Measure(
        "swing foot over the base", "mm", MM, lambda p: lift(p) + p.cycle.header.pile_height
    ),
    "single": Measure("time on one foot", "%", 100.0, single_support, 1.0),
    "margin_min": Measure("smallest ZMP margin", "mm", MM, lambda p: zmp_margin_min(p.cycle)),
    "margin_p5": Measure("ZMP margin, 5th percentile", "mm", MM, lambda p: zmp_margin_p5(p.cycle)),
    "ahead": Measure(
        "ZMP ahead of the soles' centre", "mm", MM, lambda p: median(zmp_ahead(p.cycle))
    ),
    "lean": Measure("trunk's mean pitch", "°", DEGREES, lambda p: float(p.cycle["pitch"].mean())),
    "pitch": Measure("pitch amplitude", "°", DEGREES, lambda p: pitch_amplitude(p.cycle)),
    "roll": Measure("roll amplitude", "°", DEGREES, lambda p: roll_amplitude(p.cycle)),
    "tip": Measure("stance sole's pitch", "°", DEGREES, stance_pitch),
    "rock": Measure("stance sole's rocking, half range", "°", DEGREES, stance_rocking),
}


def measured(piece: Piece | None) -> dict[str, float]:
    """Every measure of a piece by its key; NaN without one."""
    if piece is None:
        return dict.fromkeys(MEASURES, nan)
    return {key: measure.of(piece) for key, measure in MEASURES.items()}
