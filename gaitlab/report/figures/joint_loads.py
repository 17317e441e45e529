"""Position, velocity and torque of the most loaded joints against what they can do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gaitlab.metrics.joints import NEAR_LIMIT
from gaitlab.render.figure_style import BLUE, INK, ORANGE, VERMILLION, new_figure, style
from gaitlab.report.figures.foot_paths import shown_rows
from gaitlab.report.figures.gait_phases import runs, walking_time
from gaitlab.report.representative import RepresentativeTrial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

JOINTS = 3
SATURATED = "#F7D9C7"
QUANTITIES = (("position", "rad"), ("velocity", "rad/s"), ("torque", "N m"))
REACH = 1.6  # of the curve's size; limits farther off are written, not drawn


@dataclass(frozen=True, kw_only=True, eq=False)
class Load:
    """One joint over the shown time.

    Attributes:
        joint: Its name.
        limits: Lowest and highest position in [rad], velocity in [rad/s] and torque in [N m].
        peak: Largest torque over its limit.
        saturated: Where the torque is at its limit. Shape (n,).
    """

    joint: str
    limits: tuple[tuple[float, float], ...]
    peak: float
    saturated: np.ndarray


def most_loaded(walk: RepresentativeTrial, rows: slice) -> list[Load]:
    """The joints at their torque limit for longest, then those that come nearest to it."""
    header = walk.log.header
    driven = [
        (joint, limit)
        for joint, limit in zip(header.joints, header.torque_limits, strict=True)
        if limit > 0.0
    ]
    loads = []
    for joint, limit in driven:
        torque = np.abs(walk.log[f"{joint}_torque"][rows])
        loads.append(
            Load(
                joint=joint,
                limits=(_range_of(walk, joint), _speeds_of(walk, joint), (-limit, limit)),
                peak=float(torque.max() / limit),
                saturated=torque >= NEAR_LIMIT * limit,
            )
        )
    return sorted(loads, key=lambda load: (-load.saturated.sum(), -load.peak))[:JOINTS]


def _range_of(walk: RepresentativeTrial, name: str) -> tuple[float, float]:
    found = [joint for joint in walk.trial.robot.tree.joints if joint.name == name]
    return (found[0].lower, found[0].upper) if found else (-np.inf, np.inf)


def _speeds_of(walk: RepresentativeTrial, name: str) -> tuple[float, float]:
    driven = [joint.name for joint in walk.trial.robot.tree.joints if joint.servo is not None]
    servos = dict(zip(driven, walk.trial.servos, strict=False))
    if name not in servos:
        return (-np.inf, np.inf)
    speed = servos[name].no_load_speed * servos[name].supply / servos[name].voltage
    return (-speed, speed)


def joint_figure(walk: RepresentativeTrial) -> Figure:
    """Three joints of one walk over two cycles, one column a joint; at least one has a servo."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    rows = shown_rows(walk.log)
    loads = most_loaded(walk, rows)
    time = walking_time(walk.log)[rows]
    with style():
        figure = new_figure(height=5.6)
        axes = figure.subplots(3, len(loads), sharex=True, squeeze=False)
        for column, load in zip(axes.T, loads, strict=True):
            _draw_joint(column, walk, load, rows, time)
        for axis, (name, unit) in zip(axes[:, 0], QUANTITIES, strict=True):
            axis.set_ylabel(f"{name} [{unit}]")
        figure.align_ylabels(axes[:, 0])
        axes[0, 0].set_xlim(time[0], time[-1] + 1e-9 + 0.01 * (time[-1] - time[0]))
        axes[2, len(loads) // 2].set_xlabel("time since walking at full amplitude [s]")
        keys = [
            Line2D([], [], color=BLUE, label="joint"),
            Line2D([], [], color=ORANGE, linestyle=(0, (3, 1.5)), label="target of the servo"),
            Line2D([], [], color=VERMILLION, linestyle=(0, (6, 2)), label="limit"),
            Patch(facecolor=SATURATED, edgecolor=INK, linewidth=0.3, label="torque at its limit"),
        ]
        figure.legend(handles=keys, loc="outside lower center", ncols=4, fontsize=7.5)
    return figure


def _draw_joint(
    axes: Sequence[Axes], walk: RepresentativeTrial, load: Load, rows: slice, time: np.ndarray
) -> None:
    for axis, (name, _), limits in zip(axes, QUANTITIES, load.limits, strict=True):
        for start, end in runs(load.saturated):
            axis.axvspan(time[start], time[end - 1], color=SATURATED, zorder=-2)
        values = walk.log[f"{load.joint}_{name}"][rows]
        if name == "position":
            target = walk.log[f"{load.joint}_target"][rows]
            axis.plot(time, target, color=ORANGE, linestyle=(0, (3, 1.5)), linewidth=1.1)
        axis.plot(time, values, color=BLUE, linewidth=1.1)
        _limits(axis, values, limits)
    axes[0].set_title(load.joint.replace("_", " "))
    axes[2].set_title(_load_text(load), fontsize=8.0, weight="normal")


def _load_text(load: Load) -> str:
    """How near the torque came to its limit."""
    share = 100.0 * float(np.mean(load.saturated))
    if share == 0.0:
        return f"peak {100.0 * load.peak:.0f} % of the limit"
    return f"at its limit for {share:.2g} % of the time"


def _limits(axis: Axes, values: np.ndarray, limits: tuple[float, float]) -> None:
    """A line at each limit that the curve comes near; the others are written at the edge."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    size = max(high - low, 1e-3)
    shown = [limit for limit in limits if low - REACH * size <= limit <= high + REACH * size]
    for limit in shown:
        axis.axhline(limit, color=VERMILLION, linewidth=1.2, linestyle=(0, (6, 2)), zorder=1)
    bottom, top = min([low, *shown]), max([high, *shown])
    axis.set_ylim(bottom - 0.12 * (top - bottom) - 1e-3, top + 0.22 * (top - bottom) + 1e-3)
    far = [limit for limit in limits if np.isfinite(limit) and limit not in shown]
    if far:
        text = "limit " + " and ".join(f"{limit:.3g}" for limit in far) + ", off the scale"
        axis.annotate(
            text, (0.98, 0.97), xycoords="axes fraction", ha="right", va="top", fontsize=7.0
        )
