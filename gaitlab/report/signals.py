"""Signals of several walks over time, one above the other on the same axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gaitlab.picture.figure_style import BLUE, FAINT, VERMILLION, new_figure, style


@dataclass(frozen=True, kw_only=True, eq=False)
class Signal:
    """One panel.

    Attributes:
        label: What is special about this walk.
        time: In [s]. Shape (n,).
        value: NaN where it is not defined. Shape (n,).
    """

    label: str
    time: np.ndarray
    value: np.ndarray


def write_signals(
    signals: Sequence[Signal],
    folder: Path,
    name: str,
    *,
    title: str,
    quantity: str,
    bounds: tuple[float, float],
    shown: tuple[float, float],
) -> Path:
    """Draw signals and save them as SVG; the same signals give the same bytes.

    Args:
        signals: One a panel, from the top.
        folder: Where it goes.
        name: Name of the file, without ending.
        title: Title of the figure.
        quantity: What is drawn, with its unit.
        bounds: Two levels that are marked in every panel.
        shown: Lowest and highest value shown; what lies beyond is drawn on the edge in red.
    """
    with style():
        figure = new_figure(height=0.8 + 0.85 * len(signals))
        axes = figure.subplots(len(signals), 1, sharex=True, sharey=True, squeeze=False).ravel()
        for axis, signal in zip(axes, signals, strict=True):
            for level in bounds:
                axis.axhline(level, color=FAINT, linewidth=0.8)
            axis.plot(signal.time, np.clip(signal.value, *shown), color=BLUE, linewidth=0.9)
            beyond = (signal.value < shown[0]) | (signal.value > shown[1])
            edge = np.clip(signal.value[beyond], *shown)
            axis.plot(signal.time[beyond], edge, ".", color=VERMILLION, markersize=3.0)
            axis.set_ylabel(signal.label, rotation=0, ha="right", va="center")
            axis.set_ylim(1.05 * shown[0], 1.05 * shown[1])
        axes[-1].set_xlabel("time since walking at full amplitude [s]")
        figure.suptitle(f"{title}: {quantity}", x=0.01, ha="left", fontsize=10.0, weight="bold")
        file = folder / f"{name}.svg"
        figure.savefig(file, metadata={"Date": None, "Creator": None})
    return file
