"""Shares of stable seeds over two varied parameters: the cells of the tables, and other pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from gaitlab.documents.steps import expect
from gaitlab.render.figure_style import (
    FAINT,
    INK,
    PAPER,
    letters_on,
    new_figure,
    share_colours,
    style,
    wrapped,
)
from gaitlab.render.kept_figures import draw
from gaitlab.report.cells import reference_verdicts
from gaitlab.report.markdown import escape, image, section
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import ScoredCell, truth
from gaitlab.report.variants import Value, Variant, value_text
from gaitlab.report.words import axis_text, column_text, letter, path_text, plural, surface_text

SHARES = "stable_share"  # name of the picture of the cells
if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOW, HIGH = 0.22, 0.36  # in, height of a row with one line of text and with two
ROOMY = 24  # rows; of more each is lower
NARROW = 9  # columns of a page; beyond them the text shrinks
MOST_PANELS = 6  # variants in one picture
MOST_MAPS = 3  # chosen without being asked for
FIXED = ("trial_id", "experiment", "seed", "variant", ONE_ROW)


@dataclass(frozen=True, kw_only=True)
class Square:
    """One cell.

    Attributes:
        count: Seeds that stayed up.
        n: Scored seeds; 0 when nothing is known.
        feasible: Whether any seed could take the steps.
        note: A second line, what a paper says for instance.
        loud: Whether the second line stands out.
        stands: False if most seeds fell before their first step, which leaves no verdict.
        doubtful: Whether the share may lie on either side of one half.
    """

    count: int
    n: int
    feasible: bool
    note: str = ""
    loud: bool = False
    stands: bool = True
    doubtful: bool = False

    @property
    def known(self) -> bool:
        """Whether its share says something of the gait."""
        return self.n > 0 and self.feasible and self.stands

    @property
    def text(self) -> str:
        """Count and n, or why there is none."""
        mark = "?" if self.doubtful else ""
        if self.known:
            return f"{self.count}/{self.n}{mark}"
        if not self.n:
            return "no data"
        return f"does not\nstand{mark}" if self.feasible else "out of reach"


@dataclass(frozen=True, kw_only=True)
class Grid:
    """One panel.

    Attributes:
        title: Empty for none.
        rows: Titles of the rows.
        columns: Titles of the columns.
        squares: Row by row.
    """

    title: str
    rows: Sequence[str]
    columns: Sequence[str]
    squares: Sequence[Sequence[Square]]


def share_map(grids: Sequence[Grid], row_label: str, column_label: str = "") -> Figure:
    """One panel a grid on the same axes.

    Args:
        grids: At least one, all with the same rows and columns.
        row_label: What the rows are, with its unit; empty when their titles say it.
        column_label: Likewise.
    """
    rows, columns = len(grids[0].rows), len(grids[0].columns)
    across = min(len(grids), 2 if columns > 2 else 3) if columns <= NARROW else 1
    down = ceil(len(grids) / across)
    noted = any(square.note for grid in grids for line in grid.squares for square in line)
    height = HIGH if rows <= ROOMY and (noted or rows <= ROOMY // 2) else LOW
    with style():
        figure = new_figure(height=down * (0.95 + height * rows))
        axes = figure.subplots(down, across, squeeze=False, sharey=True).ravel()
        for axis, grid in zip(axes, grids, strict=False):
            _draw(axis, grid, across)
            axis.set_xlabel(column_label)
        for axis in axes[len(grids) :]:
            axis.set_visible(False)
        for axis in axes[::across]:
            axis.set_ylabel(row_label)
    return figure


def _draw(axis: Axes, grid: Grid, across: int) -> None:
    crowd = max(1.0, across * len(grid.columns) / NARROW)
    for y, line in enumerate(grid.squares):
        for x, square in enumerate(line):
            _draw_square(axis, x, y, square, crowd)
    axis.set_xlim(-0.5, len(grid.columns) - 0.5)
    axis.set_ylim(len(grid.rows) - 0.5, -0.5)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
    axis.set_title(wrapped(grid.title, 84 // across))
    narrow = max(6, int(66 / (across * len(grid.columns))))
    names = [wrapped(name, max(narrow, 9)) for name in grid.columns]
    axis.set_xticks(range(len(names)), names, fontsize=8.5 / min(crowd, 1.4))
    axis.set_yticks(range(len(grid.rows)), [wrapped(name, 26) for name in grid.rows])


def _draw_square(axis: Axes, x: int, y: int, square: Square, crowd: float) -> None:
    from matplotlib.patches import Rectangle

    known = square.known
    share = square.count / square.n if known else 0.0
    axis.add_patch(
        Rectangle(
            (x - 0.5, y - 0.5),
            1.0,
            1.0,
            facecolor=share_colours()(share) if known else PAPER,
            edgecolor=PAPER if known else FAINT,
            hatch=None if known else "////",
            linewidth=1.5,
        )
    )
    ink = letters_on(share) if known else INK
    shift = -0.12 if square.note else 0.0
    first = axis.text(x, y + shift, square.text, ha="center", va="center", fontsize=8.5 / crowd)
    first.set_color(ink)
    if not known:
        first.set_bbox({"facecolor": PAPER, "edgecolor": "none", "pad": 1.0})
    if square.note:
        second = axis.text(x, y + 0.25, square.note, ha="center", va="center", color=ink)
        second.set(fontsize=6.5 / crowd, weight="bold" if square.loud else "normal")


def cells_map(results: Results, folder: Path) -> str:
    """The tables' cells as a picture, one panel a variant; empty for a single cell."""
    if len(results.row_values) * len(results.column_values) < 2:
        return ""
    printed = reference_verdicts(results)
    grids = [_grid_of(results, v, printed) for v in results.variants[:MOST_PANELS]]
    rows = "" if results.rows == ONE_ROW else axis_text(results, results.rows)
    columns = "" if results.columns == "surface" else axis_text(results, results.columns)
    draw(folder, SHARES, (grids, rows, columns), lambda: share_map(grids, rows, columns))
    alt = f"Stable seeds of each cell, one panel a variant, for {results.title}"
    rest = len(results.variants) - MOST_PANELS
    note = f"{plural(rest, 'further variant')} not drawn; the tables have them." if rest > 0 else ""
    return "\n\n".join(part for part in (image(alt, f"{SHARES}.png"), note) if part)


def _grid_of(
    results: Results, variant: Variant, printed: Mapping[tuple[str, Value, Value], bool]
) -> Grid:
    squares = [
        [
            _square(results.cell(variant, row, column), printed.get((variant.label, row, column)))
            for column in results.column_values
        ]
        for row in results.row_values
    ]
    return Grid(
        title=variant.label if len(results.variants) > 1 else "",
        rows=_titles(results.rows, results.row_values),
        columns=[
            column_text(results, value) if results.columns == "surface" else value_text(value)
            for value in results.column_values
        ],
        squares=squares,
    )


def _titles(path: str, values: Sequence[Value]) -> list[str]:
    """Values of a path; the label of the axis carries the unit."""
    if path == ONE_ROW:
        return [""]
    if path == "surface":
        return [surface_text(str(value)) for value in values]
    return [value_text(value).replace("_", " ") for value in values]


def _square(cell: ScoredCell, printed: bool | None) -> Square:
    known = Square(
        count=cell.count(),
        n=cell.n,
        feasible=cell.feasible,
        stands=cell.stands,
        doubtful=cell.doubtful(),
    )
    if printed is None:
        return known
    differs = cell.n > 0 and cell.verdict() != printed
    note = f"printed {letter(printed)}" + (" ≠" if differs else "")
    return replace(known, note=note, loud=differs)


def pair_maps(results: Results, folder: Path) -> str:
    """The section with maps over pairs of parameters; empty when the tables show all there is."""
    asked = [pair for pair in results.maps if set(pair) <= set(results.trials.columns)]
    blocks, pairs = [], asked or list(_chosen(results))
    expect(len(pairs))
    for k, (rows, columns) in enumerate(pairs, start=1):
        name = f"map_{k}"
        grid = _pooled(results, rows, columns)
        label = "" if columns == "surface" else axis_text(results, columns)
        shown = ([grid], axis_text(results, rows), label)
        draw(folder, name, shown, partial(share_map, *shown))
        alt = f"Stable runs over {path_text(rows)} and {path_text(columns)}"
        others = [path for path in varied_paths(results) if path not in (rows, columns)]
        pooled = ", ".join(escape(path_text(path)) for path in others)
        text = "Runs that stayed up, of those scored"
        caption = f"{text}, whatever their {pooled}." if pooled else f"{text}."
        blocks += [image(alt, f"{name}.png"), caption]
    return section("Two parameters at a time", *blocks) if blocks else ""


def varied_paths(results: Results) -> list[str]:
    """Paths that take several values, each standing for those that move together with it."""
    candidates = [
        path
        for path in dict.fromkeys((results.rows, results.columns, "surface", *results.units))
        if path not in FIXED and path in results.trials and results.trials[path].nunique() > 1
    ]
    first: dict[bytes, str] = {}
    for path in candidates:
        first.setdefault(pd.factorize(results.trials[path])[0].tobytes(), path)
    return list(first.values())


def _chosen(results: Results) -> list[tuple[str, str]]:
    """Pairs beside that of the tables, when more than two numbers or grounds are varied."""
    table = {results.rows, results.columns}
    paths = [path for path in varied_paths(results) if path in table or _numeric(results, path)]
    ordered = sorted(paths, key=lambda path: path in ("surface", "robot"))
    pairs = [pair for pair in combinations(ordered, 2) if set(pair) != table]
    return pairs[:MOST_MAPS] if len(paths) > 2 else []


def _numeric(results: Results, path: str) -> bool:
    values = results.trials[path]
    return pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)


def _pooled(results: Results, rows: str, columns: str) -> Grid:
    """All runs by two paths, whatever else they differ in."""
    trials = results.trials
    counts = {
        (row, column): _counted(group)
        for (row, column), group in trials.groupby([rows, columns], sort=False, dropna=False)
    }
    row_values, column_values = _values(trials, rows), _values(trials, columns)
    empty = Square(count=0, n=0, feasible=True)
    return Grid(
        title="",
        rows=_titles(rows, row_values),
        columns=_titles(columns, column_values),
        squares=[[counts.get((r, c), empty) for c in column_values] for r in row_values],
    )


def _values(trials: pd.DataFrame, path: str) -> list[Value]:
    """Values of a path: numbers rising, names as planned."""
    values = list(dict.fromkeys(trials[path]))
    return values if any(isinstance(value, str) for value in values) else sorted(values)


def _counted(trials: pd.DataFrame) -> Square:
    scored = trials[trials["state"].isin(("DONE", "INFEASIBLE"))]
    feasible = not len(scored) or bool((scored["state"] == "DONE").any())
    return Square(count=int(truth(scored["stable"]).sum()), n=len(scored), feasible=feasible)
