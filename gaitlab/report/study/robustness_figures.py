"""After the search as pictures: what mattered, how far the winner may drift, where it walks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gaitlab.experiment.study import Numbers
from gaitlab.render.figure_style import (
    BLUE,
    CYCLE,
    DARK,
    FAINT,
    HATCHES,
    INK,
    PAPER,
    SHARE,
    SKY,
    VERMILLION,
    new_figure,
    style,
)
from gaitlab.report.study.crossings import Crossing
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.words import metric_text, number, short_paths
from gaitlab.report.words import surface_text
from gaitlab.search.margins import Margin, Reach

BAR = 0.5  # of the distance of two rows


def importance(findings: Findings) -> Figure:
    """Share of each parameter in what separates good candidates from others, one bar each."""
    shares = findings.importance
    paths = sorted(shares[0], key=lambda path: -sum(of.get(path, 0.0) for of in shares))
    names = short_paths(paths)
    height = 0.8 / len(shares)
    with style():
        figure = new_figure(width=6.5, height=0.9 + (0.24 + 0.1 * len(shares)) * len(paths))
        axis = figure.subplots()
        for place, of in enumerate(shares):
            rows = np.arange(len(paths)) + (place - (len(shares) - 1) / 2) * height
            axis.barh(
                rows,
                [of.get(path, 0.0) for path in paths],
                height=height,
                color=CYCLE[place],
                hatch=HATCHES[place],
                edgecolor=PAPER,
                label=metric_text(findings.study.objectives[place].metric),
            )
        axis.set_yticks(range(len(paths)), [names[path] for path in paths])
        axis.invert_yaxis()
        axis.set_xlabel("importance (PED-ANOVA), shares of 1 [-]")
        if len(shares) > 1:
            axis.legend(loc="lower right")
    return figure


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
    low, high = share_of(margin.value, item.low, item), share_of(margin.value, item.high, item)
    span = axis.plot([low, high], [row, row], marker="|", ms=9.0, color=FAINT, zorder=0)
    span[0].set_label("searched range")
    start = share_of(margin.value, margin.below.holds, item)
    end = share_of(margin.value, margin.above.holds, item)
    axis.barh(row, end - start, left=start, height=BAR, color=SKY, edgecolor=BLUE, label="no fall")
    for reach, sign in ((margin.below, -1.0), (margin.above, 1.0)):
        _ending(axis, row, reach, share_of(margin.value, reach.holds, item), sign, margin, item)


def _ending(
    axis: Axes, row: int, reach: Reach, edge: float, sign: float, margin: Margin, item: Numbers
) -> None:
    if reach.fails is None:
        marker = "<" if sign < 0 else ">"
        axis.plot(edge, row, ls="", marker=marker, color=BLUE, ms=6.0, label="farther not walked")
        return
    at = share_of(margin.value, reach.fails, item)
    axis.plot([edge, at], [row, row], color=VERMILLION, lw=1.0, ls=(0, (2, 2)))
    fell = reach.ending == "fell"
    label, marker = ("a seed falls", "x") if fell else ("out of reach", "s")
    axis.plot(
        at, row, ls="", marker=marker, color=VERMILLION, mfc=PAPER, mew=1.8, ms=6.0, label=label
    )


def share_of(value: float, other: float, item: Numbers) -> float:
    """How far one value lies from another, in shares of a range or of its ratio if by ratio."""
    if item.log:
        return float(np.log(other / value) / np.log(item.high / item.low))
    return (other - value) / (item.high - item.low)


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
            facecolor=SHARE(share) if known else PAPER,
            edgecolor=INK if tuned else (PAPER if known else FAINT),
            hatch=None if known else "////",
            linewidth=2.5 if tuned else 1.0,
        )
    )
    if cell is None or not known:
        axis.text(x, y, "no data", ha="center", va="center", fontsize=8.0, backgroundcolor=PAPER)
        return
    ink = PAPER if share > DARK else INK
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
