"""Pictures of a robot on its ground, and strips of them along a walk."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import radians

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.body import Link, LinkPoses, Sole, Tree
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.report.figure_style import INK, TEXT_WIDTH, VERMILLION, new_figure, style
from gaitlab.report.lawn import Footprint, Patch, ground_faces
from gaitlab.report.scene import Camera, Faces, box_faces, disc, paint
from gaitlab.surfaces.surface import Surface

SIDE = Camera(azimuth=radians(-66.0), elevation=radians(13.0))
ALUMINIUM, DARK, ORANGE = "#C9D1D8", "#3A4148", "#E08A1E"
MARGIN = 0.07  # m, ground around what stands on it
NARROWEST = (0.36, 0.30)  # m, smallest piece of ground, along x and y
LONGEST = 1.0  # m, piece of ground that the frames of a strip share
PANEL = 2.2  # in, widest frame of a strip
SCALE_BAR = 0.1  # m
HORN = 0.011  # m, radius of the drawn servo horn
FORCE_SCALE = 0.004  # m/N, length of a drawn force


@dataclass(frozen=True, kw_only=True, eq=False)
class Stance:
    """A robot at one instant.

    Attributes:
        tree: Links.
        sole: Sole of both feet.
        feet: Names of the left and the right foot link.
        poses: World poses of the links at this one instant; n = 1.
        forces: Load on the left and the right sole, world frame, in [N]. Shape (2, 3); None hides.
    """

    tree: Tree
    sole: Sole
    feet: tuple[str, str]
    poses: LinkPoses
    forces: np.ndarray | None = None

    def footprints(self) -> list[Footprint]:
        """Where the soles are."""
        return [self._footprint(foot) for foot in range(len(self.feet))]

    def _footprint(self, foot: int) -> Footprint:
        link = self.tree.index(self.feet[foot])
        rotation = self.poses.rotation[0, link]
        centre = self.poses.position[0, link] + rotation @ np.array(self.sole.centre_of(foot))
        return Footprint(centre=centre, rotation=rotation, size=(self.sole.length, self.sole.width))

    def corners(self) -> np.ndarray:
        """Corners of all boxes, world frame, in [m]. Shape (points, 3)."""
        faces = robot_faces(self.tree, self.feet, self.poses)
        return np.concatenate([part.corners.reshape(-1, 3) for part in faces])


def stance_at(
    log: TrialLog,
    tree: Tree,
    sole: Sole,
    tick: int,
    feet: tuple[str, str] = ("left_foot", "right_foot"),
) -> Stance:
    """The robot as a log has it at one tick, with the load on its soles."""
    at = slice(tick, tick + 1)
    rotation = rotation_of(log.vector("trunk_q", "xyzw")[at])
    poses = tree.poses(log.vector("trunk_")[at], rotation, log.joint_table("position")[at])
    load = [log.per_foot(name)[tick] for name in ("force_x", "force_y", "normal_force")]
    return Stance(tree=tree, sole=sole, feet=feet, poses=poses, forces=np.stack(load, axis=-1))


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


def robot_faces(tree: Tree, feet: tuple[str, str], poses: LinkPoses) -> list[Faces]:
    """Boxes, servo horns and eyes of a robot.

    Args:
        tree: Links.
        feet: Names of the left and the right foot link.
        poses: World poses of the links; the first instant counts.
    """
    return [
        face
        for link, origin, rotation in zip(
            tree.links, poses.position[0], poses.rotation[0], strict=True
        )
        for face in _link(link, origin, rotation, _colour(link, feet))
    ]


def _link(link: Link, origin: np.ndarray, rotation: np.ndarray, colour: str) -> Iterator[Faces]:
    centre = origin + rotation @ np.array(link.box.centre)
    yield box_faces(link.box.size, centre, rotation, colour)
    if link.joint is not None and link.joint.axis == "y" and link.name != "head":
        yield from _horns(link, origin, rotation)
    if link.name == "head":
        yield from _eyes(link, centre, rotation)


def _colour(link: Link, feet: tuple[str, str]) -> str:
    if link.name in feet:
        return DARK
    moves = link.joint is not None and link.joint.axis == "y"
    return ALUMINIUM if moves or link.parent is None else "#5A646D"


def _horns(link: Link, origin: np.ndarray, rotation: np.ndarray) -> Iterator[Faces]:
    """The servo horns of a pitch joint, one on each side of the link."""
    for side in (-1.0, 1.0):
        reach = side * (0.5 * link.box.size[1] + 0.001) + link.box.centre[1]
        yield disc(
            origin + rotation @ np.array([0.0, reach, 0.0]),
            side * rotation[:, 1],
            HORN,
            ORANGE,
            nearer=0.02,
        )


def _eyes(link: Link, centre: np.ndarray, rotation: np.ndarray) -> Iterator[Faces]:
    """Two eyes on the front of the head."""
    length, width, height = link.box.size
    for side in (-1.0, 1.0):
        place = np.array([0.5 * length + 0.001, side * 0.22 * width, 0.12 * height])
        yield disc(centre + rotation @ place, rotation[:, 0], 0.1 * width, DARK, nearer=0.02)


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
