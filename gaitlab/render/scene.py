"""What a picture of a trial shows: robot, soles and loads at the instants of its frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from PIL import ImageColor
from scipy.ndimage import gaussian_filter1d

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET
from gaitlab.metrics.stability import fall_cause
from gaitlab.model import Link, LinkPoses, Tree
from gaitlab.model.stance import PITCHES
from gaitlab.model.tree import unit_axis
from gaitlab.render.figure_style import surface_text
from gaitlab.simulation.trial import Trial
from gaitlab.surfaces.surface import Surface

ALUMINIUM, DARK, ORANGE = "#C9D1D8", "#3A4148", "#E08A1E"
STEEL = "#5A646D"  # links that roll, yaw or follow
HORN = 0.011  # m, radius of the drawn servo horn
LIGHT = np.array([0.35, -0.55, 0.76])  # direction to the lamp, world frame, unit length
AMBIENT = 0.62  # brightness of a face that the lamp does not reach
DISC_CORNERS = 24
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))  # of a cube of edge 1
_CUBE = _CORNERS[  # its faces, a pair for each axis; shape (6, 4, 3)
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
]
_OUTWARD = 2.0 * _CUBE.mean(axis=1)  # their normals
CALM = 0.35  # s, over which the camera follows; about half a gait cycle hides the sway


class Faces(NamedTuple):
    """Polygons with equally many corners.

    Attributes:
        corners: In the world frame, in [m]. Shape (n, corners, 3).
        colours: Red, green, blue in [0, 1]. Shape (n, 3).
    """

    corners: np.ndarray
    colours: np.ndarray


class LinkShape(NamedTuple):
    """A part of a link: polygons with equally many corners, in the frame of the link.

    Attributes:
        corners: In [m]; counter-clockwise as seen from outside. Shape (n, corners, 3).
        normals: Outward, of unit length. Shape (n, 3).
        colour: In full light.
    """

    corners: np.ndarray
    normals: np.ndarray
    colour: str

    def at(self, origin: np.ndarray, rotation: np.ndarray) -> Faces:
        """The part in the world, lit by the lamp.

        Args:
            origin: Of the link's frame, in [m]. Shape (3,).
            rotation: Of the link in the world frame. Shape (3, 3).
        """
        corners = origin + self.corners @ rotation.T
        return Faces(corners, lit(self.colour, self.normals @ rotation.T))


class SolePose(NamedTuple):
    """A sole at one instant.

    Attributes:
        centre: In the world frame, in [m]. Shape (3,).
        rotation: Of the foot in the world frame. Shape (3, 3).
        size: Length and width, in [m].
    """

    centre: np.ndarray
    rotation: np.ndarray
    size: tuple[float, float]


class Recorded(NamedTuple):
    """A trial and what was recorded of it.

    Attributes:
        trial_id: What the store calls it.
        trial: The trial.
        log: Its log.
        cell: Where it stands in its experiment; empty where it stands in none.
    """

    trial_id: str
    trial: Trial
    log: TrialLog
    cell: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A trial at the instants of n frames.

    Attributes:
        title: Robot and ground.
        caption: Gait, seed and trial.
        tree: Links of the robot.
        feet: Names of the left and the right foot link.
        surface: The ground.
        size: Height of the standing robot, in [m].
        weight: Of the robot, in [N].
        sole: Length and width of a sole, in [m].
        fall: When the fall was established, on the clock of the walk, in [s]; None without one.
        fall_cause: What established it; empty without one.
        lane: Where the CoM and the feet have been, lowest and highest corner, in [m]. Shape (2, 2).
        time: Clock of the walk at each frame; stands still past the ends of the log. Shape (n,).
        poses: Of the links. Shapes (n, links, ...).
        soles: Corners of both soles, in [m]. Shape (n, 2, 4, 3).
        centres: Of both soles, in [m]. Shape (n, 2, 3).
        forces: On both soles, in [N]. Shape (n, 2, 3).
        contact: Whether each sole carries load. Shape (n, 2).
        zmp: On the height of the loaded soles, in [m]; NaN in flight. Shape (n, 3).
        phase: Of the gait; NaN in the start-up. Shape (n,).
        focus: What the camera looks at: the CoM, calmed, in [m]. Shape (n, 2).
    """

    title: str
    caption: str
    tree: Tree
    feet: tuple[str, str]
    surface: Surface
    size: float
    weight: float
    sole: tuple[float, float]
    fall: float | None
    fall_cause: str
    lane: np.ndarray
    time: np.ndarray
    poses: LinkPoses
    soles: np.ndarray
    centres: np.ndarray
    forces: np.ndarray
    contact: np.ndarray
    zmp: np.ndarray
    phase: np.ndarray
    focus: np.ndarray

    def faces(self, frame: int) -> list[Faces]:
        """Boxes, servo horns and eyes of the robot at a frame."""
        return robot_faces(self.tree, self.feet, self.poses, frame)

    def sole_poses(self, frame: int) -> list[SolePose]:
        """The soles at a frame."""
        rotations = self.poses.rotation[frame, [self.tree.index(foot) for foot in self.feet]]
        return [
            SolePose(centre, rotation, self.sole)
            for centre, rotation in zip(self.centres[frame], rotations, strict=True)
        ]

    def fallen(self, frame: int) -> bool:
        """Whether the fall is established at a frame."""
        return self.fall is not None and bool(self.time[frame] >= self.fall - 1e-6)


def _set_apart(trial: Trial) -> str:
    """The slope and the push of a trial, which no picture shows: its ground is drawn level."""
    slope, push = trial.slope, trial.push
    ways = (("uphill", "downhill", slope.pitch), ("rising left", "rising right", slope.roll))
    told = [f"{abs(angle):g}° {up if angle > 0.0 else down}" for up, down, angle in ways if angle]
    if push.impulse:
        begin = push.begin(0.0, trial.gait.gait_period)
        told.append(f"push of {push.impulse:g} N s to {push.direction:g}° at {begin:.2f} s")
    return "".join(f"{part}, " for part in told)


def scene_of(shown: Recorded, instants: Sequence[float] | np.ndarray) -> Scene:
    """A trial at instants, in [s] since walking at full amplitude began.

    Before the log its first row shows, after it the last one.
    """
    trial, log = shown.trial, shown.log
    tree, feet, sole = trial.robot.tree, trial.robot.feet, trial.robot.sole
    clock, ticks = log["time"] - log.header.startup_time, ticks_at(log, instants)
    poses = link_poses(tree, log, ticks)
    soles = _soles(trial, poses)
    contact = log.per_foot("contact")[ticks].astype(bool)
    com = log.vector("com_", "xy")
    paths = np.concatenate([com, *(log.vector(f"{side}_foot_", "xy") for side in FEET)])
    standing = robot_faces(tree, feet, link_poses(tree, log, np.array([0])))
    return Scene(
        title=f"{trial.names.robot.upper()} on {surface_text(trial.names.surface)}",
        caption=(
            f"step length {log.header.step_length:.3g} m, period {log.header.gait_period:.3g} s, "
            f"{_set_apart(trial)}seed {trial.seed}, trial {shown.trial_id[:8]}"
        ),
        tree=tree,
        feet=feet,
        surface=trial.surface,
        size=float(np.ptp(all_corners(standing)[:, 2])),
        weight=log.header.weight,
        sole=(sole.length, sole.width),
        fall=None if log.fall_index is None else float(clock[log.fall_index]),
        fall_cause=(fall_cause(log) or "").replace("_", " "),
        lane=np.stack([paths.min(axis=0), paths.max(axis=0)]),
        time=clock[ticks],
        poses=poses,
        soles=soles,
        centres=np.stack([log.vector(f"{side}_foot_")[ticks] for side in FEET], axis=1),
        forces=loads(log)[ticks],
        contact=contact,
        zmp=_zmp(log, ticks, soles, contact),
        phase=log["gait_phase"][ticks],
        focus=gaussian_filter1d(com, CALM / log.header.dt, axis=0, mode="nearest")[ticks],
    )


def span_of(log: TrialLog) -> tuple[float, float]:
    """First and last instant of a log, in [s] since walking at full amplitude began."""
    start = log.header.startup_time
    return float(log["time"][0]) - start, float(log["time"][-1]) - start


def ticks_at(log: TrialLog, instants: Sequence[float] | np.ndarray) -> np.ndarray:
    """First rows at or after instants of the clock of the walk; past the end the last one."""
    clock = log["time"] - log.header.startup_time
    return np.minimum(np.searchsorted(clock, np.asarray(instants) - 1e-6), len(log) - 1)


def joints_of(tree: Tree, log: TrialLog) -> np.ndarray:
    """Positions of the tree's own joints; a log may have the pitch of a gantry after them."""
    return log.joint_table("position")[:, : len(tree.joints)]


def link_poses(tree: Tree, log: TrialLog, ticks: np.ndarray | slice = slice(None)) -> LinkPoses:
    """World poses of a robot's links as its log has them, by default at every row."""
    rotation = rotation_of(log.vector("trunk_q", "xyzw")[ticks])
    return tree.poses(log.vector("trunk_")[ticks], rotation, joints_of(tree, log)[ticks])


def loads(log: TrialLog) -> np.ndarray:
    """Force on the left and the right sole, world frame, in [N]. Shape (n, 2, 3)."""
    names = ("force_x", "force_y", "normal_force")
    return np.stack([log.per_foot(name) for name in names], axis=-1)


def robot_faces(tree: Tree, feet: tuple[str, str], poses: LinkPoses, frame: int = 0) -> list[Faces]:
    """Boxes, servo horns and eyes of a robot.

    Args:
        tree: Links.
        feet: Names of the left and the right foot link.
        poses: World poses of the links.
        frame: Which of the instants of the poses.
    """
    placed = zip(tree.links, poses.position[frame], poses.rotation[frame], strict=True)
    return [
        shape.at(origin, rotation)
        for link, origin, rotation in placed
        for shape in link_shapes(link, feet)
    ]


def all_corners(faces: Sequence[Faces]) -> np.ndarray:
    """Every corner of polygons, in [m]. Shape (points, 3)."""
    return np.concatenate([part.corners.reshape(-1, 3) for part in faces])


def link_colour(link: Link, feet: tuple[str, str]) -> str:
    """Colour of a link in full light."""
    if link.name in feet:
        return DARK
    return ALUMINIUM if _pitches(link) or link.parent is None else STEEL


def _pitches(link: Link) -> bool:
    return link.joint is not None and abs(unit_axis(link.joint.axis)[1]) > PITCHES


def link_shapes(link: Link, feet: tuple[str, str]) -> Iterator[LinkShape]:
    """The box of a link; with two eyes on the head, with a servo horn on each side of a pitch."""
    length, width, height = link.box.size
    centre = np.array(link.box.centre)
    yield LinkShape(centre + _CUBE * np.array(link.box.size), _OUTWARD, link_colour(link, feet))
    for side in (-1.0, 1.0):
        if link.name == "head":
            eye = centre + np.array([0.5 * length + 0.001, side * 0.22 * width, 0.12 * height])
            yield _disc(eye, np.array([1.0, 0.0, 0.0]), 0.1 * width, DARK)
        elif _pitches(link):
            reach = side * (0.5 * width + 0.001) + link.box.centre[1]
            horn = np.array([0.0, reach, 0.0])
            yield _disc(horn, np.array([0.0, side, 0.0]), HORN, ORANGE)


def _disc(centre: np.ndarray, normal: np.ndarray, radius: float, colour: str) -> LinkShape:
    """A disc about a point, both in the frame of the link, in [m]."""
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    angle = np.linspace(0.0, 2.0 * np.pi, DISC_CORNERS, endpoint=False)[:, None]
    ring = centre + radius * (np.cos(angle) * u + np.sin(angle) * np.cross(normal, u))
    return LinkShape(ring[None], normal[None], colour)


def lit(colour: str, normals: np.ndarray) -> np.ndarray:
    """Colour of faces under the lamp, in [0, 1]. Shape (n, 3)."""
    shade = AMBIENT + (1.0 - AMBIENT) * np.clip(normals @ LIGHT, 0.0, 1.0)
    return np.clip(np.array(channels(colour)) * shade[:, None], 0.0, 1.0)


def channels(colour: str) -> tuple[float, float, float]:
    """Red, green and blue of a colour, in [0, 1]."""
    red, green, blue = ImageColor.getrgb(colour)[:3]
    return red / 255.0, green / 255.0, blue / 255.0


def _soles(trial: Trial, poses: LinkPoses) -> np.ndarray:
    corners = []
    for side, name in enumerate(trial.robot.feet):
        link = trial.robot.tree.index(name)
        local = trial.robot.sole.corners(side)[[0, 1, 3, 2]]  # around the sole
        turned = local @ np.swapaxes(poses.rotation[:, link], 1, 2)
        corners.append(poses.position[:, link, None] + turned)
    return np.stack(corners, axis=1)


def _zmp(log: TrialLog, ticks: np.ndarray, soles: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """The ZMP with the mean height of the soles that carry load."""
    height = soles[..., 2].mean(axis=2)
    loaded = np.where(contact, height, 0.0).sum(axis=1) / np.maximum(contact.sum(axis=1), 1)
    return np.column_stack([log.vector("zmp_", "xy")[ticks], loaded])
