"""Pitch, roll and ZMP against time with the gait phases behind them, one column a walk.

The pitch has the layout of Figures 24, 26 and 28 of [EROS2018].

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.render.figure_style import (
    BLUE,
    INK,
    ORANGE,
    SKY,
    VERMILLION,
    new_figure,
    style,
    wrapped,
)
from gaitlab.report.figures.gait_phases import phase_keys, runs, shade, swings, walking_time
from gaitlab.report.figures.heading import AXES, seen, support_extent
from gaitlab.report.representative import RepresentativeTrial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

THIN = "#8F8F8F"  # seeds beside the shown one
LARGEST_SHOWN = 30.0  # degrees; a robot lying down would flatten the walk before it
SMALLEST_SHOWN = 8.0  # degrees
LONGEST_SHOWN = 15.0  # s, the end of longer walks
BEFORE = 0.2  # s, shown of the start-up, or before the first fall in it
TICKS = 6  # of the time axis at most
POINTS = 1500  # of a curve; more than the page has pixels
OUTSIDE = 0.002  # m beyond the support polygon's edge from which on the ZMP is marked
HEIGHTS = (1.5, 1.3, 1.3, 1.3, 0.45)  # in, of the rows


@dataclass(frozen=True, kw_only=True, eq=False)
class WalkPanel:
    """One column of the figure.

    Attributes:
        walk: The walk that is drawn thick.
        others: Logs of other seeds, drawn thin.
    """

    walk: RepresentativeTrial
    others: Sequence[TrialLog]

    @property
    def logs(self) -> list[TrialLog]:
        """All logs, the shown one first."""
        return [self.walk.log, *self.others]


def balance_figure(columns: Sequence[WalkPanel]) -> Figure:
    """Pitch and roll of all seeds; ZMP, support polygon and loaded feet of the shown one."""
    from matplotlib.ticker import MaxNLocator

    with style():
        figure = new_figure(height=sum(HEIGHTS) + 1.0)
        axes = figure.subplots(
            len(HEIGHTS),
            len(columns),
            sharex=True,
            sharey="row",
            squeeze=False,
            height_ratios=HEIGHTS,
        )
        # First and last instant shown, in [s].
        ends = [float(walking_time(log)[_last(log)]) for c in columns for log in c.logs]
        begin, end = min(0.0, *ends) - BEFORE, max(ends)  # some fall before they walk
        window = max(begin, end - LONGEST_SHOWN), end + 0.02 * min(abs(end), LONGEST_SHOWN) + 0.02
        for axis, column in zip(axes.T, columns, strict=True):
            _draw(axis, column, window)
            axis[0].set_title(wrapped(column.walk.title, width=84 // len(columns)))
            axis[-1].set_xlabel("time since walking at full amplitude [s]")
            axis[-1].xaxis.set_major_locator(MaxNLocator(TICKS))
        _finish(axes, columns, window)
        figure.legend(handles=_keys(), loc="outside lower center", ncols=4, fontsize=7.5)
    return figure


def _last(log: TrialLog) -> int:
    """Row of the fall, or the last one."""
    return len(log) - 1 if log.fall_index is None else log.fall_index


def _rows(log: TrialLog, window: tuple[float, float]) -> slice:
    """Rows to draw: those in the window up to the fall, thinned to what a page shows."""
    time = walking_time(log)
    start = int(np.searchsorted(time, window[0] - 0.1))
    stop = _last(log) + 1
    return slice(start, stop, max(1, (stop - start) // POINTS))


def _draw(axes: Sequence[Axes], column: WalkPanel, window: tuple[float, float]) -> None:
    spans = swings(column.walk.log, column.walk.trial.gait, column.walk.trial.robot)
    for axis in axes[:-1]:
        shade(axis, spans)
    for axis, name in zip(axes[:2], ("pitch", "roll"), strict=True):
        _draw_angle(axis, column, name, window)
    _amplitude(axes[0], column.walk)
    for axis, index in zip(axes[2:4], (0, 1), strict=True):
        _draw_zmp(axis, column.walk.log, index, window)
    _draw_contacts(axes[4], column.walk.log)


def _draw_angle(axis: Axes, column: WalkPanel, name: str, window: tuple[float, float]) -> None:
    for log in column.others:
        rows = _rows(log, window)
        axis.plot(walking_time(log)[rows], np.degrees(log[name][rows]), color=THIN, linewidth=0.5)
        _mark_fall(axis, log, name, window, size=4.0)
    log = column.walk.log
    rows = _rows(log, window)
    axis.plot(walking_time(log)[rows], np.degrees(log[name][rows]), color=BLUE, linewidth=1.3)
    _mark_fall(axis, log, name, window, size=8.0)


def _mark_fall(
    axis: Axes, log: TrialLog, name: str, window: tuple[float, float], size: float
) -> None:
    if log.fall_index is None or walking_time(log)[log.fall_index] < window[0]:
        return
    value = float(np.clip(np.degrees(log[name][log.fall_index]), -LARGEST_SHOWN, LARGEST_SHOWN))
    at, edge = walking_time(log)[log.fall_index], size / 4.0
    axis.plot(
        at, value, "x", color=VERMILLION, markersize=size, markeredgewidth=edge, clip_on=False
    )


def _amplitude(axis: Axes, walk: RepresentativeTrial) -> None:
    walked = walk.log["pitch"][walk.log.walking]
    if np.isnan(walk.amplitude) or not len(walked):
        return
    mean, amplitude = np.degrees(np.median(walked)), np.degrees(walk.amplitude)
    for level in (mean - amplitude, mean + amplitude):
        axis.axhline(level, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    axis.annotate(
        f"± {amplitude:.1f}°",
        (1.0, mean + amplitude),
        (-2, 2),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        color=INK,
        fontsize=8.0,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.5},
    )


def _draw_zmp(axis: Axes, log: TrialLog, index: int, window: tuple[float, float]) -> None:
    rows = _rows(log, window)
    time, support = walking_time(log)[rows], support_extent(log)[rows, index]
    zmp = seen(log, log.vector("zmp_", "xy"))[rows, index]
    axis.fill_between(time, *support.T, color=SKY, alpha=0.55, linewidth=0.0)
    axis.plot(time, zmp, color=INK, linewidth=0.8)
    outside = log["zmp_margin"][rows] < -OUTSIDE
    axis.plot(time[outside], zmp[outside], ".", color=VERMILLION, markersize=2.5)
    _limit_to(axis, np.concatenate([support.ravel(), zmp]), support)


def _limit_to(axis: Axes, values: np.ndarray, support: np.ndarray) -> None:
    """Show the support polygon whole and of the ZMP what lies within its size beside it."""
    if not np.isfinite(support).any():
        return
    low, high = np.nanmin(support), np.nanmax(support)
    beside = 0.35 * (high - low) + 0.01
    axis.update_datalim([(0.0, max(np.nanmin(values), low - beside))])
    bounds = np.clip([np.nanmin(values), np.nanmax(values)], low - beside, high + beside)
    old = axis.get_ylim() if axis.get_autoscaley_on() is False else bounds
    axis.set_ylim(min(old[0], bounds[0]), max(old[1], bounds[1]))


def _draw_contacts(axis: Axes, log: TrialLog) -> None:
    time, contact = walking_time(log), log.per_foot("contact").astype(bool)
    for foot in (0, 1):
        bars = [(time[a], time[b - 1] - time[a]) for a, b in runs(contact[: _last(log) + 1, foot])]
        axis.broken_barh(bars, (0.55 - foot, 0.8), facecolors=INK, linewidth=0.0)
    axis.set_yticks([0.95, -0.05], ["left", "right"])
    axis.set_ylim(-0.6, 1.5)
    axis.tick_params(axis="y", length=0)


def _finish(axes: np.ndarray, columns: Sequence[WalkPanel], window: tuple[float, float]) -> None:
    for row, name in enumerate(("pitch", "roll")):
        largest = max(np.abs(log[name][: _last(log) + 1]).max() for c in columns for log in c.logs)
        limit = float(np.clip(1.15 * np.degrees(largest), SMALLEST_SHOWN, LARGEST_SHOWN))
        axes[row, 0].set_ylim(-limit, limit)
    axes[0, 0].set_xlim(*window)
    labels = ("pitch [°]", "roll [°]", *(f"ZMP\n{name} [m]" for name in AXES), "loaded")
    for axis, label in zip(axes[:, 0], labels, strict=True):
        axis.set_ylabel(label)
    axes[0, 0].get_figure().align_ylabels(axes[:, 0])


def _keys() -> list[Line2D | Patch]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        *phase_keys(),
        Patch(facecolor=SKY, alpha=0.55, label="support polygon"),
        Line2D([], [], color=INK, linewidth=0.8, label="ZMP"),
        Line2D([], [], color=VERMILLION, marker=".", linewidth=0.0, label="ZMP over 2 mm outside"),
        Line2D([], [], color=ORANGE, linestyle=(0, (4, 2)), label="pitch amplitude"),
        Line2D([], [], color=THIN, linewidth=0.5, label="other seeds"),
        Line2D([], [], color=VERMILLION, marker="x", linewidth=0.0, label="fall"),
    ]
