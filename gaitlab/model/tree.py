"""A robot as a tree of rigid links: what it is built from, its poses, its centre of mass.

All poses are batched over n instants. A link's frame is its joint's frame, as in URDF.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from gaitlab.kinematics.transforms import vector_rotation

Vector: TypeAlias = tuple[float, float, float]
Axis: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"] | tuple[float, float, float]


def unit_axis(axis: Axis) -> np.ndarray:
    """The unit vector that an axis stands for. Shape (3,)."""
    if not isinstance(axis, str):
        return np.array(axis)
    return np.eye(3)["xyz".index(axis[-1])] * (-1.0 if axis.startswith("-") else 1.0)


@dataclass(frozen=True, kw_only=True)
class Box:
    """A box of a link: its shape for collision and display, and for the inertia.

    Attributes:
        size: Edge lengths, in [m].
        centre: Centre in the link frame, in [m].
    """

    size: Vector
    centre: Vector


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A revolute joint, driven by a servo unless it only follows.

    Attributes:
        name: Joint name, `left_knee` for instance.
        axis: Axis of rotation in the link frame, a coordinate axis or a unit vector.
        lower: Lower limit, in [rad].
        upper: Upper limit, in [rad].
        servo: Name of the servo type, a file in `gaitlab/servos`; None for a joint without one.
    """

    name: str
    axis: Axis
    lower: float
    upper: float
    servo: str | None


@dataclass(frozen=True, kw_only=True)
class Link:
    """A rigid link and the joint that carries it.

    Attributes:
        name: Link name.
        parent: Parent link; None for the trunk, whose frame is the robot's.
        origin: Joint frame in the parent's frame, in [m].
        joint: Joint to the parent; None for the trunk.
        mass: Mass, in [kg].
        box: Shape.
        inertia: About the centre of mass along the link's axes, in [kg m^2]: xx, yy, zz, and xy,
            xz, yz if they are not 0; None for that of a uniform box.
        com: Centre of mass in the link frame, in [m]; None for the box's centre.
        turn: Rotation matrix of the frame in the parent's at zero angle, by rows; None for parallel
            axes.
    """

    name: str
    parent: str | None
    origin: Vector
    joint: Joint | None
    mass: float
    box: Box
    inertia: tuple[float, ...] | None = None
    com: Vector | None = None
    turn: tuple[float, ...] | None = None

    @property
    def centre(self) -> Vector:
        """Centre of mass in the link frame, in [m]."""
        return self.box.centre if self.com is None else self.com

    @property
    def moments(self) -> tuple[float, ...]:
        """Inertia about the centre of mass along the link's axes: xx, yy, zz, xy, xz, yz."""
        if self.inertia is None:
            return (*box_inertia(self.mass, self.box.size), 0.0, 0.0, 0.0)
        return self.inertia if len(self.inertia) == 6 else (*self.inertia, 0.0, 0.0, 0.0)


def box_inertia(mass: float, size: Vector) -> Vector:
    """Principal moments of a uniform box about its centre, in [kg m^2]."""
    x, y, z = (edge**2 for edge in size)
    return mass * (y + z) / 12.0, mass * (x + z) / 12.0, mass * (x + y) / 12.0


def box_of_inertia(mass: float, moments: Vector) -> Vector:
    """Edges of the uniform box with these moments in [kg m^2], in [m]: undoes `box_inertia`."""
    x, y, z = (moment / mass for moment in moments)
    return sqrt(6.0 * (y + z - x)), sqrt(6.0 * (x + z - y)), sqrt(6.0 * (x + y - z))


class Coupling(NamedTuple):
    """A gear or belt between two joints: follower = ratio x leader.

    Attributes:
        leader: Name of a joint.
        follower: Name of the joint that it turns.
        ratio: Turns of the follower for one of the leader.
    """

    leader: str
    follower: str
    ratio: float


class LinkPoses(NamedTuple):
    """World poses of all links: positions (n, links, 3) in [m], rotations (n, links, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray

    def point(self, link: int, place: Sequence[float]) -> np.ndarray:
        """World position over time of a point that is fixed to a link, in [m]. Shape (3, n).

        Args:
            link: Index of the link.
            place: Of the point in the link's frame, in [m]. Shape (3,).
        """
        position, rotation = self.position[:, link].T, np.moveaxis(self.rotation[:, link], 0, -1)
        return position + _along(rotation, place)


@dataclass(frozen=True)
class Tree:
    """Links of a robot, every parent before its children."""

    links: tuple[Link, ...]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Joints in the order of their links."""
        return tuple(link.joint for link in self.links if link.joint is not None)

    @cached_property
    def driven(self) -> tuple[bool, ...]:
        """Whether each joint has a servo, in the order of `joints`."""
        return tuple(joint.servo is not None for joint in self.joints)

    @property
    def mass(self) -> float:
        """Mass of all links, in [kg]."""
        return sum(link.mass for link in self.links)

    def index(self, name: str) -> int:
        """Position of a link in `links`."""
        return self._index[name]

    def poses(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        joint_position: np.ndarray,
        wanted: Iterable[int] | None = None,
    ) -> LinkPoses:
        """Pose of every link.

        Args:
            position: Trunk link frame, world frame, in [m]. Shape (n, 3).
            rotation: Rotation matrix of the trunk link frame. Shape (n, 3, 3).
            joint_position: In the order of `joints`, in [rad]. Shape (n, joints).
            wanted: The only links whose poses are looked at, as indices; those of links that carry
                none of them may hold anything.
        """
        needed = set(range(len(self.links))) if wanted is None else self._carrying(wanted)
        # Instants come last in memory, so that every operation runs over contiguous numbers.
        n = len(position)
        at, turned = np.empty((len(self.links), 3, n)), np.empty((len(self.links), 3, 3, n))
        at[0], turned[0] = position.T, np.moveaxis(rotation, 0, -1)
        angles = np.ascontiguousarray(joint_position.T)
        for k, link in enumerate(self.links[1:], start=1):
            if k not in needed:
                continue
            parent = self._index[str(link.parent)]
            assert link.joint is not None  # only the trunk has none
            at[k] = at[parent] + _along(turned[parent], link.origin)
            above = turned[parent]
            if link.turn is not None:
                above = np.einsum("ijn,jk->ikn", above, np.reshape(link.turn, (3, 3)))
            _turn(above, link.joint.axis, angles[k - 1], out=turned[k])
        return LinkPoses(np.moveaxis(at, -1, 0), np.moveaxis(turned, -1, 0))

    @cached_property
    def _index(self) -> Mapping[str, int]:
        return {link.name: k for k, link in enumerate(self.links)}

    def _carrying(self, links: Iterable[int]) -> set[int]:
        """These links and all between them and the trunk."""
        found = set(links)
        for k in range(len(self.links) - 1, 0, -1):
            if k in found:
                found.add(self._index[str(self.links[k].parent)])
        return found

    def centre_of_mass(self, poses: LinkPoses) -> np.ndarray:
        """Centre of mass of the robot, world frame, in [m]. Shape (n, 3)."""
        moment = sum(link.mass * poses.point(k, link.centre) for k, link in enumerate(self.links))
        return np.transpose(moment) / self.mass


def _along(rotation: np.ndarray, vector: Sequence[float]) -> np.ndarray:
    """A constant vector turned by rotations (3, 3, n). Shape (3, n)."""
    moved = np.zeros((3, rotation.shape[-1]))
    for axis, length in enumerate(vector):
        if length != 0.0:
            moved += length * rotation[:, axis]
    return moved


def _turn(rotation: np.ndarray, axis: Axis, angle: np.ndarray, *, out: np.ndarray) -> None:
    """Rotations (3, 3, n) followed by turns about an axis; a coordinate axis mixes two columns."""
    if not isinstance(axis, str):
        turn = np.ascontiguousarray(np.moveaxis(vector_rotation(axis, angle), 0, -1))
        columns = (rotation[:, j, None] * turn[j] for j in range(3))
        out[:] = next(columns) + next(columns) + next(columns)
        return
    c, s = np.cos(angle), np.sin(angle)
    if axis.startswith("-"):
        s = -s
    i = "xyz".index(axis[-1])
    j, k = (i + 1) % 3, (i + 2) % 3
    out[:, i] = rotation[:, i]
    out[:, j] = c * rotation[:, j] + s * rotation[:, k]
    out[:, k] = c * rotation[:, k] - s * rotation[:, j]
