"""Figures of a gait in joint space: legs as sticks, and what each joint does over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.render.figure_style import BLUE, CYCLE, FAINT, INK, ORANGE, new_figure, style


class Postures(NamedTuple):
    """Two legs at one instant after another, forward and up.

    Attributes:
        hips: In [m]. Shape (n, 2).
        knees: Of leg 1 and leg 2, in [m]. Shape (n, 2, 2).
        ankles: Likewise. Shape (n, 2, 2).
    """

    hips: np.ndarray
    knees: np.ndarray
    ankles: np.ndarray


def stick_figure(strides: Mapping[str, Postures]) -> Figure:
    """Both legs at one instant after another with the hips' path, one panel a stride."""
    with style():
        figure = new_figure(height=3.6)
        axes = figure.subplots(1, len(strides), sharex=True, sharey=True, squeeze=False)[0]
        for axis, (name, postures) in zip(axes, strides.items(), strict=True):
            _sticks(axis, postures)
            axis.set_title(name)
            axis.set_xlabel("forward [m]")
        axes[0].set_ylabel("height [m]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right center")
    return figure


def _sticks(axis: Axes, postures: Postures) -> None:
    for k, (hips, knees, ankles) in enumerate(zip(*postures, strict=True)):
        for leg, colour in ((0, BLUE), (1, ORANGE)):
            x, z = np.stack([hips, knees[leg], ankles[leg]], axis=-1)
            label = f"leg {leg + 1}" if k == 0 else None
            axis.plot(x, z, color=colour, linewidth=0.9, alpha=0.8, label=label)
    axis.plot(*postures.hips.T, color=INK, linewidth=1.4, label="hips")
    axis.axhline(0.0, color=FAINT, linewidth=1.0, zorder=0)
    axis.set_aspect("equal")


def joint_figure(t: np.ndarray, courses: Mapping[str, np.ndarray], what: str) -> Figure:
    """Courses over time, one panel above the other.

    Args:
        t: Instants, in [s]. Shape (n,).
        courses: Course by its name. Shape (n,) each.
        what: Label of the vertical axes, with its unit.
    """
    with style():
        figure = new_figure(height=1.15 * len(courses) + 0.6)
        axes = figure.subplots(len(courses), sharex=True, squeeze=False)[:, 0]
        for axis, (name, course), colour in zip(axes, courses.items(), CYCLE, strict=False):
            axis.plot(t, course, color=colour, linewidth=1.2)
            axis.axhline(0.0, color=FAINT, linewidth=0.8, zorder=0)
            axis.set_title(name)
        figure.supylabel(what, fontsize=9.0)
        axes[-1].set_xlabel("time [s]")
    return figure
