"""A robot at one instant: its boxes, servo horns and eyes, and where its soles are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.model import Link, LinkPoses, Tree
from gaitlab.model.soles import Sole
from gaitlab.render.lawn import PressingSole
from gaitlab.render.scene import Faces, box_faces, disc

ALUMINIUM, DARK, ORANGE = "#C9D1D8", "#3A4148", "#E08A1E"
STEEL = "#5A646D"  # links that roll, yaw or follow
HORN = 0.011  # m, radius of the drawn servo horn


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

    def footprints(self) -> list[PressingSole]:
        """Where the soles are."""
        return [self._footprint(foot) for foot in range(len(self.feet))]

    def _footprint(self, foot: int) -> PressingSole:
        link = self.tree.index(self.feet[foot])
        rotation = self.poses.rotation[0, link]
        centre = self.poses.position[0, link] + rotation @ np.array(self.sole.centre_of(foot))
        return PressingSole(
            centre=centre, rotation=rotation, size=(self.sole.length, self.sole.width)
        )

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
        for face in _link(link, origin, rotation, link_colour(link, feet))
    ]


def _link(link: Link, origin: np.ndarray, rotation: np.ndarray, colour: str) -> Iterator[Faces]:
    centre = origin + rotation @ np.array(link.box.centre)
    yield box_faces(link.box.size, centre, rotation, colour)
    if link.joint is not None and link.joint.axis == "y" and link.name != "head":
        yield from _horns(link, origin, rotation)
    if link.name == "head":
        yield from _eyes(link, centre, rotation)


def link_colour(link: Link, feet: tuple[str, str]) -> str:
    """Colour of a link in full light."""
    if link.name in feet:
        return DARK
    moves = link.joint is not None and link.joint.axis == "y"
    return ALUMINIUM if moves or link.parent is None else STEEL


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
