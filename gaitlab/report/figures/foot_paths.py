"""Where heels, toes and ankles go in the sagittal plane, over the height of the grass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET
from gaitlab.render.figure_style import (
    BLACK,
    BLUE,
    FAINT,
    GREEN,
    INK,
    VERMILLION,
    new_figure,
    style,
    wrapped,
)
from gaitlab.report.figures.heading import foot_rotation, seen
from gaitlab.report.representative import RepresentativeTrial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

CYCLES = 2.0  # shown before the fall, or in the middle of the walk
SOLES = 8  # drawn a cycle
PANEL = 1.55  # in, height of a panel
HIGHEST = 0.10  # m over the pile, shown of a foot that kicks up in a fall
NARROWEST = 0.30  # m, shown of a robot that steps in place
STUBBLE = 0.006  # m between two drawn blades
Dashes = tuple[float, tuple[float, ...]]
LOOKS: dict[str, tuple[str, Dashes]] = {
    "heel": (VERMILLION, (0.0, (4.0, 1.5))),
    "toe": (BLUE, (0.0, ())),
    "ankle": (BLACK, (0.0, (1.0, 1.5))),
}


class Paths(NamedTuple):
    """Three points of one foot, forward and up, in [m]. Shape (n, 2) each."""

    heel: np.ndarray
    toe: np.ndarray
    ankle: np.ndarray


def foot_paths(walk: RepresentativeTrial, foot: int, rows: slice) -> Paths:
    """Lowest edges of heel and toe and the ankle of a foot along the first heading."""
    log, sole = walk.log, walk.trial.robot.sole
    centre, rotation = log.vector(f"{FEET[foot]}_foot_")[rows], foot_rotation(log, foot)[rows]
    along = 0.5 * log.header.sole_length * rotation[:, :, 0]
    across = 0.5 * log.header.sole_width * rotation[:, :, 1]
    # Of a sole that rolls the edge that digs in is the lower one.
    lower = -np.sign(across[:, 2:]) * across
    ankle = centre - rotation @ np.array(sole.centre_of(foot))
    return Paths(
        *(_sagittal(log, p) for p in (centre - along + lower, centre + along + lower, ankle))
    )


def _sagittal(log: TrialLog, points: np.ndarray) -> np.ndarray:
    return np.column_stack([seen(log, points)[:, 0], points[:, 2]])


def shown_rows(log: TrialLog) -> slice:
    """Rows of two cycles: those before the fall, or from the middle of a walk without one."""
    length = round(CYCLES * log.header.gait_period / log.header.dt)
    stop = log.walking.stop
    if log.fall_index is None:
        middle = (log.walking.start + stop) // 2
        stop = min(stop, middle + length // 2)
    else:
        stop = log.fall_index + 1
    return slice(max(0, stop - length), max(stop, 1))


def foot_figure(walks: Sequence[RepresentativeTrial]) -> Figure:
    """Left foot above the right one, one column a walk; heights are stretched."""
    rows = [shown_rows(walk.log) for walk in walks]
    paths = [[foot_paths(w, foot, r) for foot in (0, 1)] for w, r in zip(walks, rows, strict=True)]
    width = max(NARROWEST, 1.08 * max(_span(both) for both in paths))
    with style():
        figure = new_figure(height=2 * (PANEL + 0.45) + 0.8)
        axes = figure.subplots(2, len(walks), squeeze=False, sharey=True)
        for column, walk, both, shown in zip(axes.T, walks, paths, rows, strict=True):
            x = np.concatenate([point[:, 0] for foot in both for point in foot])
            left = float(0.5 * (x.min() + x.max()) - 0.5 * width)
            for foot, axis in enumerate(column):
                _draw(axis, walk, both[foot], shown)
                axis.set_xlim(left, left + width)
                name = axis.text(0.01, 0.96, f"{FEET[foot]} foot", transform=axis.transAxes)
                name.set(va="top", fontsize=8.0, bbox={"facecolor": "white", "linewidth": 0.3})
            head = f"{walk.label}, seed {walk.seed}" if walk.label else f"seed {walk.seed}"
            column[0].set_title(wrapped(head, 84 // len(walks)))
            column[1].set_xlabel("forward of the start [m]")
        for axis in axes[:, 0]:
            axis.set_ylabel("height [m]")
            axis.set_ylim(*_heights(paths, walks))
        figure.legend(handles=_keys(walks), loc="outside lower center", ncols=6, fontsize=7.5)
    return figure


def _span(both: Sequence[Paths]) -> float:
    """How far the points of both feet reach along the walk, in [m]."""
    return float(np.ptp(np.concatenate([point[:, 0] for foot in both for point in foot])))


def _heights(
    paths: Sequence[Sequence[Paths]], walks: Sequence[RepresentativeTrial]
) -> tuple[float, float]:
    """Lowest and highest point shown, in [m]; what kicks up in a fall leaves the picture."""
    top = max(point[:, 1].max() for both in paths for foot in both for point in foot)
    bottom = min(point[:, 1].min() for both in paths for foot in both for point in foot)
    fallen = [
        both for both, walk in zip(paths, walks, strict=True) if walk.log.fall_index is not None
    ]
    if fallen:
        top = min(top, max(walk.log.header.pile_height for walk in walks) + HIGHEST)
        top = max(top, *(foot.toe[-1, 1] for both in fallen for foot in both))  # where crosses are
    return min(-0.008, float(bottom) - 0.004), float(top) + 0.012


def _draw(axis: Axes, walk: RepresentativeTrial, paths: Paths, rows: slice) -> None:
    _ground(axis, walk.log.header.pile_height, paths)
    every = max(1, round(walk.log.header.gait_period / walk.log.header.dt / SOLES))
    for k in range(0, len(paths.heel), every):
        axis.plot(*np.stack([paths.heel[k], paths.toe[k]]).T, color=FAINT, linewidth=0.7, zorder=2)
    for (colour, dashes), path in zip(LOOKS.values(), paths, strict=True):
        axis.plot(*path.T, color=colour, linestyle=dashes, linewidth=1.1, zorder=3)
    if walk.log.fall_index is not None and rows.stop == walk.log.fall_index + 1:
        axis.plot(*paths.toe[-1], "x", color=VERMILLION, markersize=8, markeredgewidth=2, zorder=4)


def _ground(axis: Axes, height: float, paths: Paths) -> None:
    x = np.concatenate([point[:, 0] for point in paths])
    low, high = x.min() - NARROWEST, x.max() + NARROWEST
    axis.axhspan(-1.0, 0.0, facecolor=FAINT, zorder=0)
    axis.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    if height > 0.0:
        axis.axhspan(0.0, height, facecolor="#E3F1EA", zorder=0)
        blades = np.arange(low, high, STUBBLE)
        axis.vlines(blades, 0.0, height, color=GREEN, linewidth=0.5, alpha=0.5, zorder=0.5)
        axis.axhline(height, color=GREEN, linewidth=1.0, zorder=1)


def _keys(walks: Sequence[RepresentativeTrial]) -> list[Line2D | Patch]:
    from matplotlib.lines import Line2D

    keys: list[Line2D | Patch] = [
        Line2D([], [], color=colour, linestyle=dashes, label=name)
        for name, (colour, dashes) in LOOKS.items()
    ]
    keys.append(Line2D([], [], color=FAINT, linewidth=1.2, label="sole"))
    if any(walk.log.header.pile_height > 0.0 for walk in walks):
        keys.append(Line2D([], [], color=GREEN, label="top of the pile"))
    if any(walk.log.fall_index is not None for walk in walks):
        keys.append(Line2D([], [], color=VERMILLION, marker="x", linewidth=0.0, label="fall"))
    return keys
