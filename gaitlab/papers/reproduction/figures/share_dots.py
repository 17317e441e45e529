"""Stable shares of many variants, a panel a ground: a dot with its interval for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.render.figure_style import BAND, INK, PAPER, new_figure, style, wrapped
from gaitlab.report.words import surface_text
from gaitlab.statistics import Count, wilson

ACROSS = 4  # panels side by side; more go below
LINE = 0.21  # in, height of a variant
HEAD = 0.75  # in, of titles and labels of a row of panels
LETTERS = 30  # of a label, on each of at most three lines


def share_dots(counts: Mapping[str, Mapping[str, Count]], bases: Sequence[str]) -> Figure:
    """Dots over [0, 100] percent, in the order given; bases are hollow, with a line down.

    Args:
        counts: By label of the variant, then by ground; a ground that is not there leaves a gap.
        bases: Labels of those that others are compared with.
    """
    grounds = list(dict.fromkeys(ground for found in counts.values() for ground in found))
    across, down = min(ACROSS, len(grounds)), ceil(len(grounds) / ACROSS)
    with style():
        figure = new_figure(height=down * (HEAD + LINE * len(counts)))
        axes = figure.subplots(down, across, squeeze=False, sharey=True)
        for index, axis in enumerate(axes.ravel()):
            axis.set_visible(index < len(grounds))
            if index < len(grounds):
                _draw(axis, {k: v.get(grounds[index]) for k, v in counts.items()}, bases)
                axis.set_title(wrapped(surface_text(grounds[index]), 16))
        for row in axes:
            row[0].set_yticks(range(len(counts)), [wrapped(name, LETTERS) for name in counts])
            row[0].set_ylim(len(counts) - 0.4, -0.6)
    return figure


def _draw(axis: Axes, counts: Mapping[str, Count | None], bases: Sequence[str]) -> None:
    for place, (label, count) in enumerate(counts.items()):
        if place % 2:
            axis.axhspan(place - 0.5, place + 0.5, color=BAND, linewidth=0)
        if count is None or not count.n:
            continue
        share, (low, high) = 100.0 * count.successes / count.n, wilson(*count)
        axis.plot([100.0 * low, 100.0 * high], [place, place], color=INK, linewidth=1.2)
        hollow = label in bases
        axis.plot(
            [share], [place], marker="D" if hollow else "o", markersize=5.0, color=INK,
            markerfacecolor=PAPER if hollow else INK,
        )  # fmt: skip
    first = counts.get(bases[0]) if bases else None
    if first is not None and first.n:
        axis.axvline(100.0 * first.successes / first.n, color=INK, linewidth=0.6, linestyle=":")
    axis.set_xlim(-4, 104)
    axis.set_xticks([0, 50, 100])
    axis.set_xlabel("stable runs [%]")
    axis.tick_params(axis="y", length=0, labelsize=7.5)
