"""Pitch of the trunk against time, in the layout of Figures 24, 26 and 28 of the EROS paper.

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.log import TrialLog
from gaitlab.report.figure_style import BLUE, FAINT, INK, ORANGE, VERMILLION, new_figure, style
from gaitlab.report.markdown import escape
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Value, Variant, value_text
from gaitlab.report.words import column_text, is_length, path_text

LARGEST_SHOWN = 60.0  # degrees; a robot lying down would flatten the walk before it
SMALLEST_SHOWN = 12.0  # degrees
PANELS = 4  # variants shown at most
LINES = 12  # seeds shown at most in one panel


@dataclass(frozen=True, kw_only=True, eq=False)
class PitchPanel:
    """One panel: the seeds of one cell.

    Attributes:
        title: Variant and what happened.
        shown: Log of the representative seed.
        others: Logs of the other seeds.
        amplitude: Pitch amplitude of the representative seed, in [rad]; NaN if not defined.
    """

    title: str
    shown: TrialLog
    others: Sequence[TrialLog]
    amplitude: float


def representative(trials: pd.DataFrame) -> str:
    """Id of the seed of median distance; of two in the middle the shorter."""
    ordered = trials.sort_values(["distance", "seed"], kind="stable")
    return str(ordered["trial_id"].iloc[(len(ordered) - 1) // 2])


def telling_cell(results: Results) -> tuple[Value, Value] | None:
    """Row and column in which the variants' shares differ most, the first such; None if no logs."""
    best: tuple[float, tuple[Value, Value]] | None = None
    for column in results.column_values:
        for row in results.row_values:
            cells = [results.cell(variant, row, column) for variant in results.variants]
            shares = [cell.share() for cell in cells if cell.n and cell.feasible]
            spread = max(shares) - min(shares) + 2.0 * len(shares) if shares else -1.0
            if shares and (best is None or spread > best[0] + 1e-12):
                best = (spread, (row, column))
    return best and best[1]


def pitch_panels(results: Results, row: Value, column: Value) -> list[PitchPanel]:
    """The seeds of one cell, one panel a variant."""
    panels = []
    for variant in results.variants[:PANELS]:
        trials = results.at(variant, row, column)
        trials = trials[trials["state"] == "DONE"]
        if len(trials):
            panels.append(_panel(results, variant, trials))
    return panels


def _panel(results: Results, variant: Variant, trials: pd.DataFrame) -> PitchPanel:
    shown = representative(trials)
    falls = int(truth(trials["fell"]).sum())
    ids = [str(name) for name in trials["trial_id"] if name != shown][: LINES - 1]
    chosen = trials[trials["trial_id"] == shown].iloc[0]
    outcome = f"{falls} of {len(trials)} seeds fell"
    return PitchPanel(
        title=f"{variant.label}: {outcome} (thick: seed {chosen['seed']})",
        shown=results.log(shown),
        others=[results.log(name) for name in ids],
        amplitude=float(chosen.get("pitch_amplitude", np.nan)),
    )


def pitch_figure(panels: Sequence[PitchPanel]) -> Figure:
    """Pitch over walking time, panels above each other on the same axes."""
    with style():
        figure = new_figure(height=0.6 + 1.9 * len(panels))
        axes = figure.subplots(len(panels), 1, sharex=True, sharey=True, squeeze=False).ravel()
        limit = _limit(panels)
        for axis, panel in zip(axes, panels, strict=True):
            _draw_panel(axis, panel, limit)
        axes[-1].set_ylim(-limit, limit)
        axes[-1].set_xlabel("time since walking at full amplitude [s]")
        axes[-1].set_xlim(
            -0.2, max(_time(log)[-1] for panel in panels for log in _logs(panel)) + 0.3
        )
    return figure


def _logs(panel: PitchPanel) -> list[TrialLog]:
    return [panel.shown, *panel.others]


def _time(log: TrialLog) -> np.ndarray:
    return log["time"] - log.header.startup_time


def _limit(panels: Sequence[PitchPanel]) -> float:
    largest = max(np.abs(log["pitch"]).max() for panel in panels for log in _logs(panel))
    return float(np.clip(1.15 * np.degrees(largest), SMALLEST_SHOWN, LARGEST_SHOWN))


def _draw_panel(axis: Axes, panel: PitchPanel, limit: float) -> None:
    _shade_steps(axis, panel.shown)
    for log in panel.others:
        axis.plot(_time(log), np.degrees(log["pitch"]), color=FAINT, linewidth=0.5)
        _mark_fall(axis, log, size=4.0, limit=limit)
    axis.plot(_time(panel.shown), np.degrees(panel.shown["pitch"]), color=BLUE, linewidth=1.2)
    _mark_fall(axis, panel.shown, size=9.0, limit=limit)
    _amplitude_lines(axis, panel)
    axis.set_title(panel.title)
    axis.set_ylabel("pitch [°]")


def _shade_steps(axis: Axes, log: TrialLog) -> None:
    """Every second footstep of the commanded gait in light grey."""
    step, time = log["step_index"], _time(log)
    edges = np.flatnonzero(np.diff(step)) + 1
    starts, ends = np.r_[0, edges], np.r_[edges, len(step)]
    for start, end in zip(starts, ends, strict=True):
        if step[start] >= 0 and step[start] % 2 == 1:
            axis.axvspan(time[start], time[end - 1], color="#F1F1F1", linewidth=0.0, zorder=-2)


def _mark_fall(axis: Axes, log: TrialLog, size: float, limit: float) -> None:
    if log.fall_index is None:
        return
    at = (_time(log)[log.fall_index], np.degrees(log["pitch"][log.fall_index]))
    inside = float(np.clip(at[1], -0.9 * limit, 0.9 * limit))
    axis.plot(at[0], inside, "x", color=VERMILLION, markersize=size, markeredgewidth=size / 4.0)
    if size > 5.0:
        axis.annotate("fall", (at[0], inside), (6, 0), textcoords="offset points", color=VERMILLION)


def _amplitude_lines(axis: Axes, panel: PitchPanel) -> None:
    walked = panel.shown["pitch"][panel.shown.walking]
    if np.isnan(panel.amplitude) or not len(walked):
        return
    mean, amplitude = np.degrees(np.median(walked)), np.degrees(panel.amplitude)
    for level in (mean - amplitude, mean + amplitude):
        axis.axhline(level, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    text = f"± {amplitude:.1f}°"
    axis.annotate(
        text,
        (1.0, mean + amplitude),
        (-2, 2),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        color=INK,
        fontsize=8.0,
    )


def pitch_caption(results: Results, row: Value, column: Value) -> str:
    """What the figure shows and how its cell and seed were chosen."""
    place = escape(column_text(results, column))
    if results.rows != ONE_ROW:
        metres = " m" if is_length(results.rows) else ""
        place += f", {escape(path_text(results.rows))} {escape(value_text(row))}{metres}"
    return (
        f"Trunk pitch, positive leans forward; {place}: the cell in which the variants' stable "
        "shares differ most (the first of equals). The thick line is the seed of median distance "
        "in its cell, thin lines are the other seeds; dashed lines are the median pitch of the "
        "walk ± the seed's pitch amplitude, bands are every second footstep, a cross is a fall."
    )
