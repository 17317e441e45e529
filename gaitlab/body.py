"""A robot as a tree of rigid links: its URDF, its forward kinematics, its centre of mass.

All poses are batched over n instants. A link's frame is its joint's frame, as in URDF.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, Protocol

import numpy as np

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.motion import FeetPoses

SUPPORT_RADIUS = 0.004  # m, sphere at each support point; only its lowest point touches


@dataclass(frozen=True, kw_only=True)
class Box:
    """A box of a link: its shape for collision and display, and for the inertia.

    Attributes:
        size: Edge lengths, in [m].
        centre: Centre in the link frame, in [m].
    """

    size: tuple[float, float, float]
    centre: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A revolute joint driven by a servo.

    Attributes:
        name: Joint name, `left_knee` for instance.
        axis: Axis of rotation in the link frame.
        lower: Lower limit, in [rad].
        upper: Upper limit, in [rad].
        servo: Name of the servo type, a file in `gaitlab/servos`.
    """

    name: str
    axis: Literal["x", "y", "z"]
    lower: float
    upper: float
    servo: str


@dataclass(frozen=True, kw_only=True)
class Link:
    """A rigid link and the joint that carries it.

    Attributes:
        name: Link name.
        parent: Parent link; None for the trunk, whose frame is the robot's.
        origin: Joint frame in the parent's frame, in [m]; axes parallel at zero angle.
        joint: Joint to the parent; None for the trunk.
        mass: Mass, in [kg]; the box's inertia is uniform.
        box: Shape.
    """

    name: str
    parent: str | None
    origin: tuple[float, float, float]
    joint: Joint | None
    mass: float
    box: Box


@dataclass(frozen=True, kw_only=True)
class Sole:
    """A rectangular sole and how it stands.

    Attributes:
        length: Along x of the foot, in [m].
        width: Along y of the foot, in [m].
        heel: Ankle axis to the heel edge, in [m].
        height: Ankle axis over the sole, in [m].
        kind: `flat`, a 4 x 3 grid of equal supports out to the edges, or `studs`, four corners.
    """

    length: float
    width: float
    heel: float
    height: float
    kind: Literal["flat", "studs"]

    @property
    def centre(self) -> tuple[float, float, float]:
        """Centre of the sole in the foot link frame, in [m]."""
        return (self.length / 2.0 - self.heel, 0.0, -self.height)

    def supports(self) -> np.ndarray:
        """Support points in the foot link frame, in [m], rear to front, right to left. Shape (m, 3)."""
        along, across = (4, 3) if self.kind == "flat" else (2, 2)
        x = np.linspace(-self.heel, self.length - self.heel, along)
        y = np.linspace(-self.width / 2.0, self.width / 2.0, across)
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return np.column_stack([grid, np.full(len(grid), -self.height)])

    def corners(self) -> np.ndarray:
        """Corners in the foot link frame: rear right, rear left, front right, front left. Shape (4, 3)."""
        x, y = (-self.heel, self.length - self.heel), (-self.width / 2.0, self.width / 2.0)
        return np.array([(a, b, -self.height) for a in x for b in y])


class LinkPoses(NamedTuple):
    """World poses of all links: positions (n, links, 3) in [m], rotations (n, links, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray


class Robot(Protocol):
    """A robot: a frozen dataclass called `Robot` in a file of its own in `gaitlab/robots`.

    Attributes:
        name: Name of the file.
        feet: Names of the left and the right foot link.
    """

    name: str
    feet: tuple[str, str]

    @property
    def tree(self) -> Tree:
        """Links in file order, the trunk first."""

    @property
    def sole(self) -> Sole:
        """The sole, the same for both feet."""

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, in [rad], in the tree's order. Shape (n, joints).

        Raises:
            Infeasible: If a target is out of reach or beyond a joint limit; names the limb, the
                first such index, what was found and what is allowed.
        """

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""


@dataclass(frozen=True)
class Tree:
    """Links of a robot, every parent before its children."""

    links: tuple[Link, ...]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Joints in the order of their links."""
        return tuple(link.joint for link in self.links if link.joint is not None)

    @property
    def mass(self) -> float:
        """Mass of all links, in [kg]."""
        return sum(link.mass for link in self.links)

    def index(self, name: str) -> int:
        """Position of a link in `links`."""
        return [link.name for link in self.links].index(name)

    def poses(
        self, position: np.ndarray, rotation: np.ndarray, joint_position: np.ndarray
    ) -> LinkPoses:
        """Pose of every link.

        Args:
            position: Trunk link frame, world frame, in [m]. Shape (n, 3).
            rotation: Rotation matrix of the trunk link frame. Shape (n, 3, 3).
            joint_position: In the order of `joints`, in [rad]. Shape (n, joints).
        """
        index: Mapping[str, int] = {link.name: i for i, link in enumerate(self.links)}
        angles = iter(np.moveaxis(joint_position, -1, 0))
        positions, rotations = [position], [rotation]
        for link in self.links[1:]:
            parent = index[str(link.parent)]
            assert link.joint is not None  # only the trunk has none
            positions.append(positions[parent] + rotations[parent] @ np.array(link.origin))
            rotations.append(rotations[parent] @ axis_rotation(link.joint.axis, next(angles)))
        return LinkPoses(np.stack(positions, axis=1), np.stack(rotations, axis=1))

    def centre_of_mass(self, poses: LinkPoses) -> np.ndarray:
        """Centre of mass of the robot, world frame, in [m]. Shape (n, 3)."""
        masses = np.array([link.mass for link in self.links])
        local = np.array([link.box.centre for link in self.links])
        centres = poses.position + np.einsum("nlij,lj->nli", poses.rotation, local)
        return np.einsum("l,nli->ni", masses, centres) / masses.sum()
