"""A study as pictures: how far its winner may drift, where it walks, and how the search went."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.transforms import Transform

from gaitlab.experiment.study import Numbers
from gaitlab.render.figure_style import (
    BLACK,
    BLUE,
    FAINT,
    INK,
    PAPER,
    SKY,
    VERMILLION,
    letters_on,
    new_figure,
    share_colours,
    style,
)
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import Crossing
from gaitlab.report.study.words import better, number, objective_axis, short_paths
from gaitlab.report.words import surface_text
from gaitlab.search import Candidate
from gaitlab.search.candidates import moved
from gaitlab.search.margins import Margin, Reach

BAR = 0.5  # of the distance of two rows


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
            borders = [
                b.number - 0.5 for a, b in pairwise(findings.candidates) if a.batch != b.batch
            ]
            for border in borders if len(borders) <= MANY_BATCHES else ():
                label = "border of a batch" if border == borders[0] else None
                axis.axvline(border, color=FAINT, linewidth=0.5, zorder=0, label=label)
            for kind, look in KINDS.items():
                chosen = [c for c in findings.candidates if kind_of(c) == kind]
                numbers = [float(c.number) for c in chosen]
                if kind == "infeasible":
                    floor = [0.02] * len(chosen)
                    _draw(axis, look, numbers, floor, 5.0, axis.get_xaxis_transform())
                else:
                    _draw(axis, look, numbers, [objective_of(c, place) for c in chosen], 4.0)
            _best_so_far(axis, findings, place)
            axis.set_ylabel(
                f"{objective_axis(objectives[place])}\n{better(objectives[place])} is better"
            )
        axes[-1].set_xlabel("candidate, in the order of the search")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3, fontsize=8.0)
    return figure


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


def margins(findings: Findings, found: Sequence[Margin]) -> Figure:
    """How far each parameter moves before a fall, the winner at 0, in shares of the range."""
    names = short_paths([margin.path for margin in found])
    with style():
        figure = new_figure(height=1.2 + 0.36 * len(found))
        axis = figure.subplots()
        for row, margin in enumerate(found):
            item = findings.parameter(margin.path)
            if isinstance(item, Numbers):
                _margin(axis, row, margin, item)
        axis.axvline(0.0, color=INK, lw=1.0)
        axis.set_yticks(range(len(found)), [names[margin.path] for margin in found])
        axis.set_ylim(len(found) - 0.5, -0.5)
        axis.use_sticky_edges = False
        axis.margins(x=0.04)
        axis.set_xlabel("distance from the winner's value, in shares of the searched range [-]")
        handles = dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside upper left", ncols=3, fontsize=8.0)
    return figure


def _margin(axis: Axes, row: int, margin: Margin, item: Numbers) -> None:
    low, high = moved(item, margin.value, item.low), moved(item, margin.value, item.high)
    span = axis.plot([low, high], [row, row], marker="|", ms=9.0, color=FAINT, zorder=0)
    span[0].set_label("searched range")
    start = moved(item, margin.value, margin.below.holds)
    end = moved(item, margin.value, margin.above.holds)
    axis.barh(row, end - start, left=start, height=BAR, color=SKY, edgecolor=BLUE, label="no fall")
    for reach, sign in ((margin.below, -1.0), (margin.above, 1.0)):
        _ending(axis, row, reach, moved(item, margin.value, reach.holds), sign, margin, item)


def _ending(
    axis: Axes, row: int, reach: Reach, edge: float, sign: float, margin: Margin, item: Numbers
) -> None:
    if reach.fails is None:
        marker = "<" if sign < 0 else ">"
        axis.plot(edge, row, ls="", marker=marker, color=BLUE, ms=6.0, label="farther not walked")
        return
    at = moved(item, margin.value, reach.fails)
    axis.plot([edge, at], [row, row], color=VERMILLION, lw=1.0, ls=(0, (2, 2)))
    fell = reach.ending == "fell"
    label, marker = ("a seed falls", "x") if fell else ("out of reach", "s")
    axis.plot(
        at, row, ls="", marker=marker, color=VERMILLION, mfc=PAPER, mew=1.8, ms=6.0, label=label
    )


def crossings(rows: Mapping[str, Mapping[str, Crossing]], units: str) -> Figure:
    """Where a gait tuned on one ground stays up on others; a frame where it was tuned.

    Args:
        rows: By what was walked and by ground.
        units: Name and unit of the number under each share, empty for none.
    """
    grounds = list(dict.fromkeys(name for row in rows.values() for name in row))
    with style():
        figure = new_figure(height=1.1 + 0.55 * len(rows))
        axis = figure.subplots()
        for y, row in enumerate(rows.values()):
            for x, ground in enumerate(grounds):
                _crossing(axis, x, y, row.get(ground))
        axis.set_xlim(-0.52, len(grounds) - 0.48)
        axis.set_ylim(len(rows) - 0.48, -0.52)
        axis.tick_params(length=0)
        axis.spines[:].set_visible(False)
        names = [surface_text(ground).replace(" ", "\n", 1) for ground in grounds]
        axis.set_xticks(range(len(grounds)), names)
        axis.set_yticks(range(len(rows)), [label.replace(", ", "\n", 1) for label in rows])
        below = f"; below it: {units}" if units else ""
        axis.set_xlabel(f"run on; stable of all fresh seeds{below}")
        axis.set_ylabel("tuned on")
    return figure


def _crossing(axis: Axes, x: int, y: int, cell: Crossing | None) -> None:
    known = cell is not None and cell.n > 0
    share = cell.stable / cell.n if cell is not None and known else 0.0
    tuned = cell is not None and cell.tuned
    axis.add_patch(
        Rectangle(
            (x - 0.47, y - 0.46),
            0.94,
            0.92,
            facecolor=share_colours()(share) if known else PAPER,
            edgecolor=INK if tuned else (PAPER if known else FAINT),
            hatch=None if known else "////",
            linewidth=2.5 if tuned else 1.0,
        )
    )
    if cell is None or not known:
        axis.text(x, y, "no data", ha="center", va="center", fontsize=8.0, backgroundcolor=PAPER)
        return
    ink = letters_on(share)
    below = number(cell.objective) if cell.objective == cell.objective else ""
    axis.text(
        x,
        y,
        f"{cell.stable}/{cell.n}" + (f"\n{below}" if below else ""),
        ha="center",
        va="center",
        color=ink,
        fontsize=8.5,
    )
