"""Shares of stable seeds as a heat map, with the counts in the cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gaitlab.render.figure_style import DARK, FAINT, INK, PAPER, SHARE, new_figure, style, wrapped

LOW, HIGH = 0.22, 0.36  # in, height of a row with one line of text and with two
ROOMY = 24  # rows; of more each is lower
NARROW = 9  # columns of a page; beyond them the text shrinks


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
    known = square.known
    share = square.count / square.n if known else 0.0
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
    shift = -0.12 if square.note else 0.0
    first = axis.text(x, y + shift, square.text, ha="center", va="center", fontsize=8.5 / crowd)
    first.set_color(ink)
    if not known:
        first.set_bbox({"facecolor": PAPER, "edgecolor": "none", "pad": 1.0})
    if square.note:
        second = axis.text(x, y + 0.25, square.note, ha="center", va="center", color=ink)
        second.set(fontsize=6.5 / crowd, weight="bold" if square.loud else "normal")
