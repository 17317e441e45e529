"""How a robot stands, from ahead and from its right, to scale: what was found, for checking by eye.

Boxes of the links, the axes of the legs' joints, the soles on the ground and the centre of mass
above them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitlab.documents.outputs import MARK, refuse_other, replaced
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.model.robot import Robot, standing
from gaitlab.model.stance import PITCHES
from gaitlab.model.tree import LinkPoses, unit_axis
from gaitlab.render.camera import Camera
from gaitlab.render.figure_style import (
    BLUE,
    INK,
    PAPER,
    SCREEN_DPI,
    VERMILLION,
    new_figure,
    style,
)
from gaitlab.render.painter import QUAD
from gaitlab.render.raster import Layer, merge
from gaitlab.render.replay import STARTS
from gaitlab.render.scene import Faces, all_corners, robot_faces

WIDTH, TALLEST = 7.4, 4.6  # in, of the figure and of its views
NAMES = 1.0  # in, for the heights' names, between the views
SHARP = 2 * SCREEN_DPI  # 1/in, of the boxes; what is drawn over them is drawn to the figure's
MARGIN = 0.06  # of the robot's height, around it
BELOW = 0.14  # of the robot's height, under the ground
AXIS = 0.035  # of the robot's height, half the length of a drawn axis
ALONG_SIGHT = 0.3  # of an axis across the line of sight, below which it is drawn as a point
ROUND_LENGTHS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)  # m, of the scale bar
_POINT: Any = {
    **{"color": VERMILLION, "marker": "o", "markersize": 4.5, "markerfacecolor": PAPER},
    **{"linestyle": "none"},
}
_LINE: Any = {"color": VERMILLION, "linewidth": 1.6, "solid_capstyle": "round"}
_COM: Any = {
    **{"color": INK, "marker": "o", "markersize": 9, "fillstyle": "left"},
    **{"markerfacecoloralt": PAPER, "linestyle": "none"},
}
VIEWS = {"from ahead": 0.0, "from its right": -np.pi / 2.0}  # rad, azimuth of the camera


class _Stand(NamedTuple):
    """A robot that stands on the ground, which is at z = 0.

    Attributes:
        faces: Its boxes.
        soles: Corners of both soles, in [m]. Shape (2, 4, 3).
        com: Centre of mass, in [m]. Shape (3,).
        axes: Of each leg's joints from the foot up, a point beside the link that it carries in [m],
            and a unit vector. Shape (2, joints, 2, 3).
        height: Of the robot, in [m].
    """

    faces: list[Faces]
    soles: np.ndarray
    com: np.ndarray
    axes: np.ndarray
    height: float


def draw_standing(
    robot: Robot,
    joints: np.ndarray,
    path: Path,
    *,
    hip_height: float,
    title: str,
    force: bool = False,
) -> None:
    """Draw a robot as it stands into a PNG.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
        path: The file.
        hip_height: Of the hips over the soles, in [m].
        title: What stands over the picture.
        force: Also replace a file that gaitlab did not write.

    Raises:
        UsageError: If a file is there that gaitlab did not write.
        StoreError: If it cannot be written.
    """
    refuse_other(path, STARTS[".png"], force=force)
    with style():
        figure = standing_figure(robot, joints, hip_height, title)
        with replaced(path) as part:
            figure.savefig(part, dpi=SCREEN_DPI, metadata={"Software": MARK})


def standing_figure(robot: Robot, joints: np.ndarray, hip_height: float, title: str) -> Figure:
    """A robot from ahead and from its right, both at one scale.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
        hip_height: Of the hips over the soles, in [m].
        title: What stands over the picture.
    """
    stand = _stand(robot, joints)
    corners = all_corners(stand.faces)
    low, high = corners.min(axis=0), corners.max(axis=0)
    edge = MARGIN * stand.height
    bottom, top = -BELOW * stand.height, float(high[2]) + edge
    sides = [  # left and right edge of each view
        (float(low[k]) - edge, float(high[k]) + edge) for k in (1, 0)
    ]
    wide = [right - left for left, right in sides]
    inch = min((WIDTH - NAMES - 0.4) / sum(wide), TALLEST / (top - bottom))  # a metre on paper
    sides[0] = (sides[0][0], sides[0][1] + NAMES / inch)
    wide[0] += NAMES / inch
    figure = new_figure(WIDTH, inch * (top - bottom) + 0.75)
    panels = figure.subplots(1, 2, width_ratios=wide)
    for axes, (name, azimuth), (left, right) in zip(panels, VIEWS.items(), sides, strict=True):
        frame = (left, right, bottom, top)
        axes.imshow(_painted(stand.faces, azimuth, frame, inch), extent=frame)
        axes.set(xlim=frame[:2], ylim=frame[2:], aspect="equal")
        axes.set_axis_off()
        axes.set_title(name, loc="center", weight="normal", size=9)
        _draw_over(axes, stand, azimuth)
    _draw_heights(panels[0], stand, hip_height)
    _draw_scale(panels[1], stand)
    figure.suptitle(title, weight="bold", size=10)
    figure.legend(
        handles=_legend(), loc="outside lower center", ncols=3, fontsize=8, handletextpad=0.6
    )
    return figure


def _stand(robot: Robot, joints: np.ndarray) -> _Stand:
    tree, start = robot.tree, standing(robot, joints, gap=0.0)
    poses = tree.poses(start.position[None], rotation_of(start.quaternion[None]), joints[None])
    faces = [part for part in robot_faces(tree, robot.feet, poses) if part.corners.shape[1] == QUAD]
    soles = np.array(
        [
            poses.position[0, k] + robot.sole.corners(side) @ poses.rotation[0, k].T
            for side, k in enumerate(map(tree.index, robot.feet))
        ]
    )
    return _Stand(
        faces=faces,
        soles=soles,
        com=tree.centre_of_mass(poses)[0],
        axes=_leg_axes(robot, poses),
        height=float(all_corners(faces)[:, 2].max()),
    )


def _leg_axes(robot: Robot, poses: LinkPoses) -> np.ndarray:
    tree = robot.tree
    legs: list[list[tuple[np.ndarray, np.ndarray]]] = [[], []]
    for foot, leg in zip(robot.feet, legs, strict=True):
        link = tree.links[tree.index(foot)]
        while link.parent is not None and link.joint is not None:
            k = tree.index(link.name)
            at, turn = poses.position[0, k], poses.rotation[0, k]
            axis = turn @ unit_axis(link.joint.axis)
            beside = turn @ np.array(link.centre)
            leg.append((at + axis * (axis @ beside), axis))
            link = tree.links[tree.index(link.parent)]
    return np.array(legs)


def _painted(
    faces: list[Faces], azimuth: float, frame: tuple[float, float, float, float], inch: float
) -> np.ndarray:
    """The boxes in a frame of left, right, bottom and top, in [m]. Shape (height, width, 3)."""
    left, right, bottom, top = frame
    scale = inch * SHARP
    width, height = round(scale * (right - left)), round(scale * (top - bottom))
    camera = Camera(
        azimuth=azimuth,
        elevation=0.0,
        focus=np.zeros(3),
        place=(-scale * left, scale * top),
        scale=scale,
    )
    paper, robot = Layer(width, height, 255), Layer(width, height, 255)
    paper.clear(paper.whole)
    robot.clear(robot.whole)
    first = 0
    for part in faces:
        robot.paint(camera.triangles(part.corners, 255.0 * part.colours, first))
        first += len(part.corners)
    stains = np.zeros((height, width), np.uint8)
    merge(paper, robot, stains, np.zeros(3), robot.whole)
    return paper.colour


def _draw_over(axes: Axes, stand: _Stand, azimuth: float) -> None:
    """Ground, soles, axes and centre of mass."""
    across = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])

    def seen(points: np.ndarray) -> np.ndarray:
        return np.stack([points @ across, points[..., 2]], axis=-1)

    left, right = axes.get_xlim()
    axes.plot([left, right], [0.0, 0.0], color=INK, linewidth=0.8, zorder=1)
    for sole in stand.soles:
        places = seen(sole)
        ends = [places[:, 0].min(), places[:, 0].max()]
        axes.plot(ends, [0.0, 0.0], color=BLUE, linewidth=4.0, solid_capstyle="butt", zorder=4)
    for leg in stand.axes:
        pitching = leg[np.abs(leg[:, 1, 1]) > PITCHES, 0]
        axes.plot(*seen(pitching).T, color=INK, linewidth=0.8, zorder=4)
    for point, axis in stand.axes.reshape(-1, 2, 3):
        x, z = seen(point)
        along = seen(AXIS * stand.height * axis)
        if np.linalg.norm(along) < ALONG_SIGHT * AXIS * stand.height:
            axes.plot(x, z, **_POINT, zorder=5)
        else:
            axes.plot([x - along[0], x + along[0]], [z - along[1], z + along[1]], **_LINE, zorder=5)
    x, z = seen(stand.com)
    axes.plot([x, x], [0.0, z], color=VERMILLION, linewidth=1.0, linestyle=(0, (4, 3)), zorder=6)
    axes.plot(x, 0.0, color=VERMILLION, marker="^", markersize=5, clip_on=False, zorder=6)
    axes.plot(x, z, **_COM, zorder=7)


def _draw_heights(axes: Axes, stand: _Stand, hip_height: float) -> None:
    """Heights of the centre of mass and the hips, to the right of the robot."""
    right = axes.get_xlim()[1]
    heights = {"CoM": float(stand.com[2]), "hips": hip_height}
    upper = max(heights.values())
    for name, height in heights.items():
        axes.plot([0.0, right], [height, height], color=INK, linewidth=0.6, linestyle=":", zorder=3)
        above = height == upper
        axes.annotate(
            f"{name} {height:.3f} m",
            (right, height),
            xytext=(0, 2 if above else -2),
            textcoords="offset points",
            ha="right",
            va="bottom" if above else "top",
            fontsize=8,
        )


def _draw_scale(axes: Axes, stand: _Stand) -> None:
    """A bar of a round length under the ground."""
    length = min(ROUND_LENGTHS, key=lambda each: abs(each - 0.25 * stand.height))
    z = -0.5 * BELOW * stand.height
    middle = sum(axes.get_xlim()) / 2.0
    ends = [middle - length / 2.0, middle + length / 2.0]
    axes.plot(ends, [z, z], color=INK, linewidth=2.5, solid_capstyle="butt")
    axes.annotate(
        f"{100 * length:g} cm",
        (middle, z),
        xytext=(0, -3),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=8,
    )


def _legend() -> list[Line2D]:
    none: list[float] = []
    return [
        Line2D(none, none, **_COM, label="centre of mass (CoM) and the point below it"),
        Line2D(none, none, **_LINE, label="axes of the legs' joints, points if seen end on"),
        Line2D(none, none, color=BLUE, linewidth=4.0, label="soles"),
    ]
