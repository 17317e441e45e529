"""Pictures of a robot on its ground, and strips of them along a walk."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import radians

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.log import TrialLog
from gaitlab.model import Tree
from gaitlab.model.soles import Sole
from gaitlab.render.figure_style import INK, TEXT_WIDTH, VERMILLION, new_figure, style
from gaitlab.render.lawn import Patch, ground_faces
from gaitlab.render.robot import Stance, robot_faces, stance_at
from gaitlab.render.scene import Camera, paint
from gaitlab.surfaces.surface import Surface

SIDE = Camera(azimuth=radians(-66.0), elevation=radians(13.0))
MARGIN = 0.07  # m, ground around what stands on it
NARROWEST = (0.36, 0.30)  # m, smallest piece of ground, along x and y
LONGEST = 1.0  # m, piece of ground that the frames of a strip share
PANEL = 2.2  # in, widest frame of a strip
SCALE_BAR = 0.1  # m
FORCE_SCALE = 0.004  # m/N, length of a drawn force


def draw_robot(
    axes: Axes,
    stance: Stance,
    surface: Surface,
    *,
    patch: Patch | None = None,
    camera: Camera = SIDE,
    forces: bool = False,
    scale_bar: bool = True,
) -> None:
    """A robot standing in its grass, with a bar of 10 cm along the front edge of the board.

    Args:
        axes: Where to paint; its limits are left alone.
        stance: The robot.
        surface: The ground, at z = 0 and up.
        patch: Piece of ground to show; by default what the robot covers and a margin.
        camera: Where to look from.
        forces: Draw the load on the soles.
        scale_bar: Draw the bar of 10 cm.
    """
    patch = patch or patch_below([stance])
    ground = ground_faces(surface, patch, stance.footprints(), camera)
    robot = robot_faces(stance.tree, stance.feet, stance.poses)
    paint(axes, camera, [*ground, *robot])
    if scale_bar:
        _scale_bar(axes, patch, camera)
    if forces and stance.forces is not None:
        _force_arrows(axes, stance, camera)
    axes.set_aspect("equal")
    axes.set_axis_off()


def patch_below(stances: Sequence[Stance]) -> Patch:
    """Piece of ground below robots, not smaller than `NARROWEST`."""
    corners = np.concatenate([stance.corners() for stance in stances])
    edges = []
    for axis, least in enumerate(NARROWEST):
        low, high = corners[:, axis].min() - MARGIN, corners[:, axis].max() + MARGIN
        short = 0.5 * max(0.0, least - (high - low))
        edges.append((float(low - short), float(high + short)))
    return Patch(x=edges[0], y=edges[1])


def _scale_bar(axes: Axes, patch: Patch, camera: Camera) -> None:
    end = patch.x[1] - 0.01
    ends = np.array([[end - SCALE_BAR, patch.y[0], -0.032], [end, patch.y[0], -0.032]])
    (a, b), (c, d) = camera.see(ends)[:, :2]
    axes.plot([a, c], [b, d], color=INK, linewidth=1.6, solid_capstyle="butt", zorder=3)
    label = f"{100.0 * SCALE_BAR:.0f} cm"
    middle, below = 0.5 * (a + c), min(b, d) - 0.008
    axes.text(middle, below, label, ha="center", va="top", fontsize=7.5, zorder=3)


def _force_arrows(axes: Axes, stance: Stance, camera: Camera) -> None:
    for print_, force in zip(stance.footprints(), np.asarray(stance.forces), strict=True):
        if force[2] > 0.5:  # N; a sole without load shows no arrow
            tail, head = camera.see(np.stack([print_.centre, print_.centre + FORCE_SCALE * force]))
            arrow = {"arrowstyle": "-|>", "color": VERMILLION, "linewidth": 1.6}
            axes.annotate("", head[:2], tail[:2], arrowprops=arrow, zorder=4)


def filmstrip(
    log: TrialLog,
    tree: Tree,
    sole: Sole,
    surface: Surface,
    ticks: Sequence[int],
    *,
    feet: tuple[str, str] = ("left_foot", "right_foot"),
    camera: Camera = SIDE,
    forces: bool = False,
) -> Figure:
    """Instants of one trial side by side at one scale.

    Above one piece of ground while that is no longer than `LONGEST`, else each above its own.
    """
    stances = [stance_at(log, tree, sole, tick, feet) for tick in ticks]
    patches = _patches(stances)
    bounds = [_bounds(s, p, camera) for s, p in zip(stances, patches, strict=True)]
    width, height = np.max([box[1] - box[0] for box in bounds], axis=0)
    across = min(PANEL, TEXT_WIDTH * 1.25 / len(ticks))
    with style():
        figure = new_figure(across * len(ticks), across * height / width + 0.3)
        panels = np.atleast_1d(figure.subplots(1, len(ticks)))
        for axes, stance, patch, tick in zip(panels, stances, patches, ticks, strict=True):
            first = axes is panels[0]
            draw_robot(
                axes,
                stance,
                surface,
                patch=patch,
                camera=camera,
                forces=forces,
                scale_bar=first,
            )
            time = log["time"][tick] - log.header.startup_time
            axes.set_title(f"{time:.2f} s", loc="center", fontsize=9.0, weight="normal")
        _same_scale(panels, bounds)
    return figure


def _patches(stances: Sequence[Stance]) -> list[Patch]:
    common = patch_below(stances)
    if common.size[0] <= LONGEST:
        return [common] * len(stances)
    return [patch_below([stance]) for stance in stances]


def _same_scale(panels: Iterable[Axes], bounds: Sequence[np.ndarray]) -> None:
    """Every panel as wide and high as the largest, its own ground in the middle."""
    half = 0.5 * np.max([box[1] - box[0] for box in bounds], axis=0)
    for axes, (low, high) in zip(panels, bounds, strict=True):
        middle = 0.5 * (low[0] + high[0])
        axes.set_xlim(middle - half[0], middle + half[0])
        axes.set_ylim(low[1], low[1] + 2.0 * half[1])


def _bounds(stance: Stance, patch: Patch, camera: Camera) -> np.ndarray:
    """Lower left and upper right of all that is drawn. Shape (2, 2)."""
    board = np.array([[x, y, -0.05] for x in patch.x for y in patch.y])
    seen = camera.see(np.concatenate([stance.corners(), board]))[:, :2]
    return np.stack([seen.min(axis=0) - 0.01, seen.max(axis=0) + 0.01])


def portrait(stance: Stance, surface: Surface, *, camera: Camera = SIDE) -> Figure:
    """One robot on its ground, as large as the page allows."""
    with style():
        figure = new_figure(width=5.0, height=5.2)
        axes = figure.subplots()
        draw_robot(axes, stance, surface, camera=camera)
        _same_scale([axes], [_bounds(stance, patch_below([stance]), camera)])
    return figure
