"""What a robot is built from: rigid links, the joints that carry them, gears between joints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

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
