"""Falls by direction and gait phase, counted in cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.picture.figure_style import DARK, INK, PAPER, SHARE, new_figure, style, wrapped

DIRECTIONS = ("forward", "backward", "left", "right")
PHASES = np.linspace(0.0, 1.0, 11)  # edges of the cells
GAP = 1.25  # bins; where the falls of the start-up stand, left of the phases


def fall_map(counts: Sequence[tuple[str, np.ndarray]]) -> Figure:
    """One panel a variant.

    Args:
        counts: Title and falls of each variant, a row a direction; the first column holds those of
            the start-up, the others those of each phase. Shape (4, 11).
    """
    most = max((int(table.max()) for _, table in counts), default=0)
    with style():
        figure = new_figure(height=0.5 + len(counts) * (0.55 + 0.3 * len(DIRECTIONS)))
        axes = figure.subplots(len(counts), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (title, table) in zip(axes, counts, strict=True):
            _draw(axis, table, max(most, 1))
            axis.set_title(wrapped(title, 90))
            axis.set_yticks(range(len(DIRECTIONS)), DIRECTIONS)
        ticks = np.arange(len(PHASES)) - 0.5
        axes[-1].set_xticks([-GAP, *ticks], ["start-up", *(f"{edge:.1f}" for edge in PHASES)])
        axes[-1].set_xlabel("gait phase at the fall [-]")
    return figure


def _draw(axis: Axes, table: np.ndarray, most: int) -> None:
    places = [-GAP, *range(table.shape[1] - 1)]
    for y, row in enumerate(table):
        for x, count in zip(places, row, strict=True):
            share = count / most
            axis.bar(x, 0.94, 0.96, y - 0.47, color=SHARE(share), linewidth=0.0)
            if count:
                ink = PAPER if share > DARK else INK
                axis.text(x, y, str(count), ha="center", va="center", color=ink, fontsize=8.0)
    axis.set_ylim(len(table) - 0.5, -0.5)
    axis.set_xlim(-GAP - 0.5, table.shape[1] - 1.5)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
