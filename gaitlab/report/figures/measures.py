"""How the metrics of single runs spread on each ground: a box with every run beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from gaitlab.picture.figure_style import (
    CYCLE,
    HATCHES,
    INK,
    PAPER,
    VERMILLION,
    new_figure,
    style,
    wrapped,
)

ACROSS = 2  # panels side by side
MOST_POINTS = 120  # of the largest box; of more the boxes stand alone
BEYOND = 0.3  # of the whiskers' reach, shown on either side of them
WHISKERS = (5.0, 95.0)  # percentiles
WIDTH = 0.8  # of a ground's place that its boxes take
PHI = 0.6180339887498949  # golden ratio less 1: its multiples spread evenly over [0, 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """One metric of the runs of a variant on a ground.

    Attributes:
        values: One a run, NaN left out. Shape (n,).
        fell: Whether that run fell. Shape (n,).
    """

    values: np.ndarray
    fell: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class Panel:
    """One metric.

    Attributes:
        label: Name with unit.
        samples: By variant, then by ground.
    """

    label: str
    samples: Mapping[str, Mapping[str, Sample]]


def measures_figure(panels: Sequence[Panel]) -> Figure:
    """One panel a metric: grounds along the axis, variants side by side."""
    across, down = min(ACROSS, len(panels)), ceil(len(panels) / ACROSS)
    variants = list(panels[0].samples)
    points = most_runs(panels) <= MOST_POINTS
    with style():
        figure = new_figure(height=2.15 * down + 0.6)
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for axis, panel in zip(axes, panels, strict=False):
            _draw(axis, panel, points)
        for axis in axes[len(panels) :]:
            axis.set_visible(False)
        columns = min(4, len(variants) + 2)
        keys = [*_keys(variants), *([_up(), _down()] if points else [])]
        if keys:
            figure.legend(handles=keys, loc="outside lower center", ncols=columns, fontsize=7.5)
    return figure


def most_runs(panels: Sequence[Panel]) -> int:
    """Runs of the largest box."""
    return max(
        len(sample.values)
        for panel in panels
        for grounds in panel.samples.values()
        for sample in grounds.values()
    )


def _draw(axis: Axes, panel: Panel, points: bool) -> None:
    grounds = list(next(iter(panel.samples.values())))
    width = WIDTH / len(panel.samples)
    low, high = _reach(panel)
    for i, by_ground in enumerate(panel.samples.values()):
        for k, sample in enumerate(by_ground.values()):
            place = k - 0.5 * WIDTH + (i + 0.5) * width
            kept = Sample(values=np.clip(sample.values, low, high), fell=sample.fell)
            _box(axis, kept, place, width, i, points)
    size, letters = (8.0, 12) if len(grounds) <= 4 else (7.0, 46 // len(grounds))
    names = [wrapped(name, max(letters, 7)) for name in grounds]
    axis.set_xticks(range(len(grounds)), names, fontsize=size)
    axis.set_xlim(-0.5, len(grounds) - 0.5)
    axis.tick_params(axis="x", length=0)
    axis.set_title(panel.label)
    axis.grid(axis="y", color="#E4E4E4", linewidth=0.6)


def _reach(panel: Panel) -> tuple[float, float]:
    """Lowest and highest value drawn, so that one far off does not flatten the boxes."""
    samples = [s.values for grounds in panel.samples.values() for s in grounds.values()]
    ends = np.concatenate([np.percentile(values, WHISKERS) for values in samples if len(values)])
    low, high = float(ends.min()), float(ends.max())
    return low - BEYOND * (high - low), high + BEYOND * (high - low)


def _box(
    axis: Axes, sample: Sample, place: float, width: float, variant: int, points: bool
) -> None:
    n = len(sample.values)
    if n == 0:
        high = axis.get_xaxis_transform()
        axis.text(place, 0.02, "none", ha="center", fontsize=7.0, transform=high)
        return
    box = axis.boxplot(
        [sample.values],
        positions=[place],
        widths=0.72 * width,
        whis=WHISKERS,
        showfliers=False,
        patch_artist=True,
        manage_ticks=False,
        medianprops={"color": INK, "linewidth": 1.6},
        zorder=2,
    )
    hatch = HATCHES[variant % len(HATCHES)]
    box["boxes"][0].set(facecolor=PAPER, edgecolor=CYCLE[variant % len(CYCLE)], hatch=hatch)
    if points:
        _points(axis, sample, place, width)


def _points(axis: Axes, sample: Sample, place: float, width: float) -> None:
    """Every run, moved aside by its rank so that equal ones do not hide each other."""
    order = np.argsort(sample.values, kind="stable")
    aside = np.empty(len(order))
    aside[order] = ((np.arange(len(order)) * PHI) % 1.0 - 0.5) * 0.6 * width
    for chosen, look in ((~sample.fell, _up()), (sample.fell, _down())):
        look.set_data(place + aside[chosen], sample.values[chosen])
        axis.add_line(look)


def _up() -> Line2D:
    return Line2D(
        [],
        [],
        linewidth=0,
        marker="o",
        color=INK,
        markersize=2.2,
        alpha=0.75,
        zorder=3,
        markeredgewidth=0,
        label="run that stayed up",
    )


def _down() -> Line2D:
    return Line2D(
        [],
        [],
        linewidth=0,
        marker="x",
        color=VERMILLION,
        markersize=3.0,
        zorder=3,
        markeredgewidth=0.8,
        label="run that fell",
    )


def _keys(variants: Sequence[str]) -> list[Patch]:
    keys: list[Patch] = []
    if len(variants) > 1:
        keys = [
            Patch(
                facecolor=PAPER,
                edgecolor=CYCLE[i % len(CYCLE)],
                hatch=HATCHES[i % len(HATCHES)],
                label=label,
            )
            for i, label in enumerate(variants)
        ]
    return keys
