"""The search as pictures: its history, every parameter against the objective, the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Transform

from gaitlab.experiment import Value
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.render.figure_style import (
    BLACK,
    BLUE,
    FAINT,
    INK,
    PAPER,
    SKY,
    VERMILLION,
    new_figure,
    style,
)
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.words import better, objective_axis, short_paths, value, with_unit
from gaitlab.search import Candidate

PANELS = 3  # side by side


class Look(NamedTuple):
    """How candidates of one kind are drawn, told apart without colour."""

    label: str
    marker: str
    color: str
    face: str
    edge: float


KINDS = {
    "done": Look("all seeds, constraints hold", "o", BLUE, BLUE, 0.5),
    "broken": Look("all seeds, a constraint is broken", "o", SKY, PAPER, 1.0),
    "pruned": Look("given up early", "x", INK, INK, 0.9),
    "infeasible": Look("cannot be walked", "|", VERMILLION, VERMILLION, 1.2),
}
MANY_BATCHES = 40  # more borders than this would be a grey field


def kind_of(candidate: Candidate) -> str:
    """Which of `KINDS` a candidate is."""
    if candidate.state != "done":
        return candidate.state
    return "done" if candidate.feasible else "broken"


def objective_of(candidate: Candidate, place: int) -> float:
    """One objective of a candidate; NaN if it has none."""
    if candidate.state == "infeasible" or place >= len(candidate.objectives):
        return math.nan
    found = float(candidate.objectives[place])
    return found if math.isfinite(found) else math.nan


def history(findings: Findings) -> Figure:
    """Objectives in the order of the search, one panel each, with the best so far."""
    objectives = findings.study.objectives
    with style():
        figure = new_figure(height=0.9 + 2.3 * len(objectives))
        axes = figure.subplots(len(objectives), 1, sharex=True, squeeze=False).ravel()
        for place, axis in enumerate(axes):
            _batches(axis, findings.candidates)
            _points(axis, findings, place)
            _best_so_far(axis, findings, place)
            axis.set_ylabel(
                f"{objective_axis(objectives[place])}\n{better(objectives[place])} is better"
            )
        axes[-1].set_xlabel("candidate, in the order of the search")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3, fontsize=8.0)
    return figure


def _batches(axis: Axes, candidates: Sequence[Candidate]) -> None:
    borders = [b.number - 0.5 for a, b in pairwise(candidates) if a.batch != b.batch]
    for border in borders if len(borders) <= MANY_BATCHES else ():
        axis.axvline(border, color=FAINT, linewidth=0.5, zorder=0)


def _points(axis: Axes, findings: Findings, place: int) -> None:
    for kind, look in KINDS.items():
        chosen = [c for c in findings.candidates if kind_of(c) == kind]
        numbers = [float(c.number) for c in chosen]
        if kind == "infeasible":
            floor = [0.02] * len(chosen)
            _draw(axis, look, numbers, floor, 5.0, axis.get_xaxis_transform())
        else:
            _draw(axis, look, numbers, [objective_of(c, place) for c in chosen], 4.0)


def _draw(
    axis: Axes,
    look: Look,
    across: Sequence[float],
    up: Sequence[float],
    size: float,
    transform: Transform | None = None,
) -> None:
    """Candidates of one kind; a kind without any stays out of the legend."""
    if not across:
        return
    axis.plot(
        across,
        up,
        linestyle="",
        marker=look.marker,
        color=look.color,
        markerfacecolor=look.face,
        markeredgewidth=look.edge,
        markersize=size,
        label=look.label,
        transform=transform or axis.transData,
    )


def _best_so_far(axis: Axes, findings: Findings, place: int) -> None:
    """A stair; of several objectives each on its own, so no candidate need lie on all of them."""
    best, heights = math.nan, []
    largest = findings.study.objectives[place].direction == "maximize"
    for candidate in findings.candidates:
        if kind_of(candidate) == "done":
            found = objective_of(candidate, place)
            best = float(np.fmax(best, found) if largest else np.fmin(best, found))
        heights.append(best)
    if not all(map(math.isnan, heights)):
        numbers = [c.number for c in findings.candidates]
        axis.step(
            numbers, heights, where="post", color=BLACK, lw=1.2, label="best so far", zorder=1
        )
    winner = findings.chosen
    if winner is not None:
        _star(axis, winner.number, objective_of(winner, place), "winner")


def _star(axis: Axes, x: float, y: float, label: str | None = None) -> None:
    axis.plot(
        x, y, ls="", marker="*", ms=13.0, mfc=VERMILLION, mec=PAPER, mew=0.8, label=label, zorder=5
    )


def slices(findings: Findings, place: int = 0) -> Figure:
    """Every searched parameter against one objective: candidates, range, default and winner."""
    search = findings.study.search
    down = math.ceil(len(search) / PANELS)
    names = short_paths([item.path for item in search])
    with style():
        figure = new_figure(height=0.5 + 2.2 * down)
        grid = figure.subplots(down, min(PANELS, len(search)), squeeze=False, sharey=True)
        for axis, item in zip(grid.ravel(), search, strict=False):
            _slice(axis, findings, item, place)
            axis.set_xlabel(with_unit(names[item.path], findings.unit(item.path)))
        for axis in grid.ravel()[len(search) :]:
            axis.set_visible(False)
        for axis in grid[:, 0]:
            axis.set_ylabel(objective_axis(findings.study.objectives[place]))
        handles = {
            label: handle
            for axis in grid.ravel()
            for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles, loc="outside upper left", ncols=4, fontsize=8.0)
    return figure


def _slice(axis: Axes, findings: Findings, item: Numbers | Choices, place: int) -> None:
    for kind, look in KINDS.items():
        chosen = [c for c in findings.candidates if kind_of(c) == kind and item.path in c.values]
        if kind != "infeasible":
            across = [_across(item, c.values[item.path]) for c in chosen]
            _draw(axis, look, across, [objective_of(c, place) for c in chosen], 3.2)
    _range_of(axis, item)
    default = findings.defaults.get(item.path)
    if default is not None:
        where = _across(item, default)
        axis.axvline(where, color=INK, lw=1.0, ls=(0, (1, 2)), label="hand-set default", zorder=0)
    winner = findings.chosen
    if winner is not None and item.path in winner.values:
        height = objective_of(winner, place)
        _star(axis, _across(item, winner.values[item.path]), height, "winner")


def _across(item: Numbers | Choices, found: Value) -> float:
    """Where a value stands on its axis."""
    if isinstance(item, Choices):
        return float(item.options.index(found)) if found in item.options else math.nan
    return float(str(found))


def _range_of(axis: Axes, item: Numbers | Choices) -> None:
    if isinstance(item, Choices):
        axis.set_xticks(range(len(item.options)), [value(option) for option in item.options])
        axis.set_xlim(-0.6, len(item.options) - 0.4)
        return
    if item.log:
        axis.set_xscale("log")
        ticks = [item.low, math.sqrt(item.low * item.high), item.high]
        axis.set_xticks(ticks, [f"{tick:.3g}" for tick in ticks])
        axis.minorticks_off()
    for edge in (item.low, item.high):
        axis.axvline(edge, color=FAINT, lw=1.2, zorder=0)


def front(findings: Findings) -> Figure:
    """Objectives against each other, one panel a pair: candidates, front and winner."""
    pairs = list(combinations(range(len(findings.study.objectives)), 2))
    with style():
        figure = new_figure(width=5.5 if len(pairs) == 1 else 8.0, height=3.6)
        axes = figure.subplots(1, len(pairs), squeeze=False).ravel()
        for axis, (x, y) in zip(axes, pairs, strict=True):
            _front_panel(axis, findings, x, y)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3, fontsize=8.0)
    return figure


def _front_panel(axis: Axes, findings: Findings, x: int, y: int) -> None:
    objectives = findings.study.objectives
    on_front = {candidate.number for candidate in findings.front}
    for kind, look in KINDS.items():
        chosen = [c for c in findings.candidates if kind_of(c) == kind and c.number not in on_front]
        if kind != "infeasible":
            points = [_place(c, x, y) for c in chosen]
            _draw(axis, look, [p[0] for p in points], [p[1] for p in points], 3.5)
    ordered = sorted(_place(c, x, y) for c in findings.front)
    if ordered:
        across, up = zip(*ordered, strict=True)
        axis.plot(across, up, color=BLACK, lw=1.0, marker="s", ms=5.0, mfc=BLUE, label="front")
    if findings.chosen is not None:
        _star(axis, *_place(findings.chosen, x, y), "walked again")
    axis.set_xlabel(f"{objective_axis(objectives[x])}, {better(objectives[x])} is better")
    axis.set_ylabel(f"{objective_axis(objectives[y])}, {better(objectives[y])} is better")
    axis.margins(0.08)


def _place(candidate: Candidate, x: int, y: int) -> tuple[float, float]:
    return objective_of(candidate, x), objective_of(candidate, y)
