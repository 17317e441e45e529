"""Gait phases behind curves over time: which foot the gait means to be in the air."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.model import Robot
from gaitlab.model.commands import Reactive, feet_of
from gaitlab.model.gait import Gait
from gaitlab.render.figure_style import BAND, FAINT, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

HATCH = "////"  # of the right foot's swing, so that the two differ in grey


class Span(NamedTuple):
    """A stretch of time in [s] in which one foot swings; foot 0 is the left."""

    start: float
    end: float
    foot: int


def walking_time(log: TrialLog) -> np.ndarray:
    """Time since full-amplitude walking started, in [s]. Shape (n,)."""
    return log["time"] - log.header.startup_time


def swings(log: TrialLog, gait: Gait, robot: Robot) -> list[Span]:
    """Commanded swings of both feet, in the time of `walking_time`."""
    if isinstance(gait, Reactive):
        sent = [log[f"{joint.name}_target"].astype(float) for joint in robot.tree.joints]
        swing = gait.feet_sent(robot, np.stack(sent, axis=-1), log["time"]).swing
    else:
        swing = feet_of(gait, robot, log["time"]).swing
    time = walking_time(log)
    return sorted(span for foot in (0, 1) for span in _spans(time, swing[:, foot], foot))


def _spans(time: np.ndarray, flags: np.ndarray, foot: int) -> Iterator[Span]:
    for start, end in runs(flags):
        yield Span(float(time[start]), float(time[end - 1]), foot)


def runs(flags: np.ndarray) -> Iterator[tuple[int, int]]:
    """First row and row past the end of every run of true values."""
    edges = np.flatnonzero(np.diff(np.r_[False, flags, False].astype(int)))
    for start, end in edges.reshape(-1, 2):
        yield int(start), int(end)


def shade(axis: Axes, spans: list[Span]) -> None:
    """Grey where the left foot swings, hatched where the right does, white in double support."""
    for span in spans:
        face, hatch = (BAND, None) if span.foot == 0 else (PAPER, HATCH)
        axis.axvspan(
            span.start,
            span.end,
            facecolor=face,
            edgecolor=BAND,
            hatch=hatch,
            linewidth=0.0,
            zorder=-3,
        )


def phase_keys() -> list[Patch]:
    """Entries of a legend for the shading."""
    from matplotlib.patches import Patch

    left = Patch(facecolor=BAND, label="left foot swings")
    right = Patch(facecolor=PAPER, edgecolor=FAINT, hatch=HATCH, label="right foot swings")
    return [left, right]
