"""The figures of a report: shares as a heat map, falls over the gait phase."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gaitlab.report.figure_style import CYCLE, FAINT, HATCHES, INK, PAPER, SHARE, new_figure, style
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import Cell
from gaitlab.report.variants import Value, Variant, value_text
from gaitlab.report.words import column_text, is_length, letter, path_text

DARK = 0.55  # share above which white letters read better than black ones
PHASE_BINS = 20


def share_map(results: Results, paper: Mapping[tuple[str, Value, Value], bool]) -> Figure:
    """Share of stable seeds, one panel a variant, the shares and the paper's verdicts in the cells.

    Args:
        results: What was simulated.
        paper: The paper's verdict by variant label, row and column, where it has one.
    """
    rows, columns = len(results.row_values), len(results.column_values)
    across = min(len(results.variants), 2 if columns > 2 else 3)
    down = ceil(len(results.variants) / across)
    with style():
        figure = new_figure(height=down * (0.95 + 0.36 * rows))
        axes = figure.subplots(down, across, squeeze=False, sharey=True).ravel()
        for axis, variant in zip(axes, results.variants, strict=False):
            _share_panel(axis, results, variant, paper)
        for axis in axes[len(results.variants) :]:
            axis.set_visible(False)
        for axis in axes[::across]:
            axis.set_ylabel(row_axis(results))
    return figure


def row_axis(results: Results) -> str:
    """Label of the axis of the rows, lengths with their unit."""
    if results.rows == ONE_ROW:
        return ""
    return path_text(results.rows) + (" [m]" if is_length(results.rows) else "")


def _share_panel(
    axis: Axes,
    results: Results,
    variant: Variant,
    paper: Mapping[tuple[str, Value, Value], bool],
) -> None:
    for y, row in enumerate(results.row_values):
        for x, column in enumerate(results.column_values):
            cell = results.cell(variant, row, column)
            _share_cell(axis, x, y, cell, paper.get((variant.label, row, column)))
    _frame(axis, len(results.column_values), len(results.row_values))
    axis.set_title(variant.label)
    names = [column_text(results, value).replace(" ", "\n", 1) for value in results.column_values]
    axis.set_xticks(range(len(names)), names)
    axis.set_yticks(range(len(results.row_values)), [value_text(v) for v in results.row_values])


def _frame(axis: Axes, columns: int, rows: int) -> None:
    axis.set_xlim(-0.5, columns - 0.5)
    axis.set_ylim(rows - 0.5, -0.5)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _share_cell(axis: Axes, x: int, y: int, cell: Cell, printed: bool | None) -> None:
    share = cell.share()
    known = cell.n > 0 and cell.feasible
    axis.add_patch(
        Rectangle(
            (x - 0.5, y - 0.5),
            1.0,
            1.0,
            facecolor=SHARE(share) if known else PAPER,
            edgecolor=PAPER if known else FAINT,
            hatch=None if known else "////",
            linewidth=1.5,
        )
    )
    ink = PAPER if known and share > DARK else INK
    text = f"{cell.count()}/{cell.n}" if known else ("out of reach" if cell.n else "no data")
    shift = 0.0 if printed is None else -0.12
    box = None if known else {"facecolor": PAPER, "edgecolor": "none", "pad": 1.0}
    axis.text(x, y + shift, text, ha="center", va="center", color=ink, fontsize=8.5, bbox=box)
    if printed is not None:
        _paper_mark(axis, x, y, printed, cell, ink)


def _paper_mark(axis: Axes, x: int, y: int, printed: bool, cell: Cell, ink: str) -> None:
    differs = cell.n > 0 and cell.verdict() != printed
    text = f"paper {letter(printed)}" + (" ≠" if differs else "")
    weight = "bold" if differs else "normal"
    axis.text(x, y + 0.25, text, ha="center", va="center", color=ink, fontsize=6.5, weight=weight)


def fall_phases(phases: Sequence[tuple[str, np.ndarray]]) -> Figure:
    """Falls over the gait phase, one histogram a variant; labels carry n.

    Args:
        phases: Label and phases in [0, 1) of the falls of each variant.
    """
    with style():
        figure = new_figure(height=0.6 + 1.2 * len(phases))
        axes = figure.subplots(len(phases), 1, sharex=True, sharey=True, squeeze=False).ravel()
        bins = np.linspace(0.0, 1.0, PHASE_BINS + 1)
        for i, (axis, (label, values)) in enumerate(zip(axes, phases, strict=True)):
            axis.hist(values, bins=bins, color=CYCLE[i % 8], hatch=HATCHES[i % 8], edgecolor=PAPER)
            axis.set_title(f"{label} (n = {len(values)} falls while walking)")
            axis.set_ylabel("falls")
            axis.yaxis.get_major_locator().set_params(integer=True)
        axes[-1].set_xlabel("gait phase at the fall [-]")
        axes[-1].set_xlim(0.0, 1.0)
    return figure
