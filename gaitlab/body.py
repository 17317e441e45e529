"""A robot as a tree of rigid links: its forward kinematics, its centre of mass, its soles.

All poses are batched over n instants. A link's frame is its joint's frame, as in URDF.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, Protocol, TypeAlias

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.transforms import vector_rotation
from gaitlab.motion import FeetPoses
from gaitlab.soles import Sole

SUPPORT_RADIUS = 0.004  # m, sphere at each support point; only its lowest point touches
ROUNDING = 1e-9  # rad, the only angle by which a joint limit is forgiven

Axis: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"] | tuple[float, float, float]


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
        origin: Joint frame in the parent's frame, in [m]; axes parallel at zero angle.
        joint: Joint to the parent; None for the trunk.
        mass: Mass, in [kg].
        box: Shape.
        inertia: Principal moments about the box's centre, in [kg m^2]; None for those of a uniform
            box.
    """

    name: str
    parent: str | None
    origin: tuple[float, float, float]
    joint: Joint | None
    mass: float
    box: Box
    inertia: tuple[float, float, float] | None = None


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


class Part(NamedTuple):
    """One link of a limb, named without its side.

    Attributes:
        name: Link name.
        joint: Name of the joint that carries it.
        axis: Axis of the joint.
        limits: Lower and upper joint limit, in [rad].
        origin: Joint frame in the frame of the part above, in [m].
        mass: In [kg].
        box: Shape.
    """

    name: str
    joint: str
    axis: Axis
    limits: tuple[float, float]
    origin: tuple[float, float, float]
    mass: float
    box: Box


def limb(parts: Sequence[Part], *, parent: str, servo: str, prefix: str = "") -> Iterator[Link]:
    """Links of a limb that hangs on a parent, every joint driven by the same type of servo."""
    for part in parts:
        (lower, upper), name = part.limits, f"{prefix}{part.joint}"
        joint = Joint(name=name, axis=part.axis, lower=lower, upper=upper, servo=servo)
        name = f"{prefix}{part.name}"
        yield Link(
            name=name, parent=parent, origin=part.origin, joint=joint, mass=part.mass, box=part.box
        )
        parent = name


def require_limits(limb: str, joints: Sequence[Joint], position: np.ndarray) -> None:
    """Refuse joint positions beyond their limits.

    Args:
        limb: Name for the message, `left_leg` for instance.
        joints: Joints of the limb.
        position: In [rad]. Shape (n, joints of the limb).

    Raises:
        Infeasible: Names the first such instant, its joint, the angle found and those allowed.
    """
    low = np.array([joint.lower for joint in joints]) - ROUNDING
    high = np.array([joint.upper for joint in joints]) + ROUNDING
    outside = np.argwhere(~((position >= low) & (position <= high)))
    if not len(outside):
        return
    tick, index = (int(i) for i in outside[0])
    joint = joints[index]
    reason = (
        f"{joint.name} would have to turn to {_angles(position[tick, index])}, its limits are "
        f"{_angles(joint.lower, joint.upper)}; shorten step_length or step_height, or change "
        "hip_height"
    )
    raise Infeasible(limb=limb, tick=tick, reason=reason)


def both_legs(targets: Callable[[int], np.ndarray]) -> list[np.ndarray]:
    """What `targets` gives for the left leg, 0, and the right one, 1.

    Raises:
        Infeasible: Of both legs the one that fails first.
    """
    found, problems = [], []
    for index in (0, 1):
        try:
            found.append(targets(index))
        except Infeasible as problem:
            problems.append(problem)
    if problems:
        raise min(problems, key=lambda problem: problem.tick)
    return found


def _angles(*angles: float) -> str:
    in_radians = " and ".join(f"{angle:.3f}" for angle in angles)
    in_degrees = " and ".join(f"{angle:.1f}" for angle in np.degrees(angles))
    return f"{in_radians} rad ({in_degrees} degrees)"


class LinkPoses(NamedTuple):
    """World poses of all links: positions (n, links, 3) in [m], rotations (n, links, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray


Gantry = Literal["none", "planar", "level"]
GANTRY_PITCH = "gantry_pitch"  # what the joint is called that lets the trunk pitch or holds it


class Robot(Protocol):
    """A robot: a frozen dataclass called `Robot` in a file of its own in `gaitlab/robots`.

    It may have two more members. `couplings`, a tuple of `Coupling`, ties joints together; a joint
    that only follows has no servo. `gantry` is a rig that helps the robot to stand: `planar` holds
    it against lateral motion, roll and yaw, `level` against pitch too, and the log then carries
    the rig's joint `gantry_pitch`, whose torque is the balancing moment that the rig supplied.
    """

    @property
    def name(self) -> str:
        """Name of the file."""

    @property
    def feet(self) -> tuple[str, str]:
        """Names of the left and the right foot link."""

    @property
    def tree(self) -> Tree:
        """Links in file order, the trunk first."""

    @property
    def sole(self) -> Sole:
        """The sole of the left foot; the right one mirrors it."""

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, in [rad]. Shape (n, joints in tree's order).

        Raises:
            Infeasible: If a target is out of reach or beyond a joint limit; names the limb, the
                first such index, what was found and what is allowed.
        """

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""


def couplings_of(robot: Robot) -> tuple[Coupling, ...]:
    """Gears and belts of a robot; most have none."""
    couplings: tuple[Coupling, ...] = getattr(robot, "couplings", ())
    return couplings


def gantry_of(robot: Robot) -> Gantry:
    """Rig that helps a robot to stand; `none` for a robot on its own."""
    gantry: Gantry = getattr(robot, "gantry", "none")
    return gantry


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
        self, position: np.ndarray, rotation: np.ndarray, joint_position: np.ndarray
    ) -> LinkPoses:
        """Pose of every link.

        Args:
            position: Trunk link frame, world frame, in [m]. Shape (n, 3).
            rotation: Rotation matrix of the trunk link frame. Shape (n, 3, 3).
            joint_position: In the order of `joints`, in [rad]. Shape (n, joints).
        """
        # Instants come last in memory, so that every operation runs over contiguous numbers.
        n = len(position)
        at, turned = np.empty((len(self.links), 3, n)), np.empty((len(self.links), 3, 3, n))
        at[0], turned[0] = position.T, np.moveaxis(rotation, 0, -1)
        angles = iter(joint_position.T)
        for k, link in enumerate(self.links[1:], start=1):
            parent = self._index[str(link.parent)]
            assert link.joint is not None  # only the trunk has none
            at[k] = at[parent] + _along(turned[parent], link.origin)
            _turn(turned[parent], link.joint.axis, next(angles), out=turned[k])
        return LinkPoses(np.moveaxis(at, -1, 0), np.moveaxis(turned, -1, 0))

    @cached_property
    def _index(self) -> Mapping[str, int]:
        return {link.name: k for k, link in enumerate(self.links)}

    def centre_of_mass(self, poses: LinkPoses) -> np.ndarray:
        """Centre of mass of the robot, world frame, in [m]. Shape (n, 3)."""
        at, turned = np.moveaxis(poses.position, 0, -1), np.moveaxis(poses.rotation, 0, -1)
        moment = sum(
            link.mass * (at[k] + _along(turned[k], link.box.centre))
            for k, link in enumerate(self.links)
        )
        return np.transpose(moment) / self.mass


def _along(rotation: np.ndarray, vector: tuple[float, float, float]) -> np.ndarray:
    """A constant vector turned by rotations (3, 3, n). Shape (3, n)."""
    moved = np.zeros((3, rotation.shape[-1]))
    for axis, length in enumerate(vector):
        if length != 0.0:
            moved += length * rotation[:, axis]
    return moved


def _turn(rotation: np.ndarray, axis: Axis, angle: np.ndarray, *, out: np.ndarray) -> None:
    """Rotations (3, 3, n) followed by turns about an axis; a coordinate axis mixes two columns."""
    if not isinstance(axis, str):
        out[:] = np.einsum("ijn,njk->ikn", rotation, vector_rotation(axis, angle))
        return
    c, s = np.cos(angle), np.sin(angle)
    if axis.startswith("-"):
        s = -s
    i = "xyz".index(axis[-1])
    j, k = (i + 1) % 3, (i + 2) % 3
    out[:, i] = rotation[:, i]
    out[:, j] = c * rotation[:, j] + s * rotation[:, k]
    out[:, k] = c * rotation[:, k] - s * rotation[:, j]
