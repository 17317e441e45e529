"""Effects of many quantities on several responses, a panel a response: a dot with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitlab.render.figure_style import BAND, INK, PAPER, new_figure, style, wrapped
from gaitlab.statistics import LinearEffect

LINE = 0.34  # in, height of a quantity with its range below it
HEAD = 1.25  # in, of titles, axis and legend
LEVEL = 0.05  # of the corrected p-value below which a dot is filled
MARGIN = 1.08  # of the widest interval, the same in every panel


def effect_dots(
    panels: Mapping[str, Sequence[LinearEffect]], quantities: Sequence[str], unit: str
) -> Figure:
    """One line a quantity, in the order given; filled where chance is no explanation.

    Args:
        panels: Effects of all quantities by title of the panel.
        quantities: Name and range of each.
        unit: Label of the axes, along which the changes stand in hundredths.
    """
    ends = [abs(end) for found in panels.values() for e in found for end in e.interval]
    reach = 100.0 * MARGIN * (max(ends) or 1.0)
    with style():
        figure = new_figure(height=HEAD + LINE * len(quantities))
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axis, (title, effects) in zip(axes, panels.items(), strict=True):
            _draw(axis, effects, reach)
            axis.set_title(wrapped(title, 24), fontsize=9.0)
        axes[0].set_yticks(range(len(quantities)), quantities, fontsize=8.0)
        axes[0].set_ylim(len(quantities) - 0.5, -0.5)
        figure.supxlabel(unit, fontsize=9.0)
        figure.legend(handles=_keys(), loc="outside upper right", ncols=2, fontsize=8.0)
    return figure


def _draw(axis: Axes, effects: Sequence[LinearEffect], reach: float) -> None:
    axis.axvline(0.0, color=INK, linewidth=0.8)
    for place, effect in enumerate(effects):
        if place % 2:
            axis.axhspan(place - 0.5, place + 0.5, color=BAND, linewidth=0)
        low, high = (100.0 * end for end in effect.interval)
        axis.plot([low, high], [place, place], color=INK, linewidth=1.4, solid_capstyle="butt")
        axis.add_line(_dot(100.0 * effect.change, place, effect.p_value < LEVEL))
    axis.set_xlim(-reach, reach)
    axis.tick_params(axis="y", length=0)


def _dot(across: float, down: float, told: bool, label: str = "") -> Line2D:
    return Line2D(
        [across], [down], linestyle="none", label=label, zorder=3, marker="o", markersize=6.0,
        color=INK, markerfacecolor=INK if told else PAPER,
    )  # fmt: skip


def _keys() -> list[Line2D]:
    texts = ((True, "told from chance (p < 0.05, corrected)"), (False, "not told from chance"))
    return [_dot(0.0, 0.0, told, text) for told, text in texts]
