"""A URDF of anybody's robot as rigid bodies: read, checked line by line, fixed joints merged.

Never handed to a physics engine as it is: there a link without `<inertial>` weighs 1 kg. Here it
weighs nothing, and what cannot move against its parent becomes part of it, [URDF].

References:
    URDF: Unified Robot Description Format, XML specification, ROS wiki.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Literal, NamedTuple, cast

import numpy as np

from gaitlab.documents.xml import Tag, parse
from gaitlab.kinematics.transforms import axis_rotation

Kind = Literal["box", "cylinder", "sphere", "mesh"]
MOVING = ("revolute", "continuous")
LEAST_MASS = 1e-3  # kg; what moves and states no mass gets it, for nothing can move without
LEAST_RADIUS = 2e-3  # m, of gyration, of what gets that mass
HEAVIEST = 200.0  # kg; a humanoid beyond it is in grams or in pounds
SHOWN = 3  # names of a list that a note gives


class Geometry(NamedTuple):
    """Geometry of a body.

    Attributes:
        kind: What it is.
        size: Edges of a box, radius and length of a cylinder, radius of a sphere, in [m]; scale of
            a mesh along its axes.
        mesh: What the file calls the mesh; empty for other kinds.
        position: Centre, or origin of the mesh, in the body's frame, in [m]. Shape (3,).
        rotation: Likewise. Shape (3, 3).
        collision: Whether it is there to be touched, and not only to be seen.
    """

    kind: Kind
    size: tuple[float, ...]
    mesh: str
    position: np.ndarray
    rotation: np.ndarray
    collision: bool


class BodyJoint(NamedTuple):
    """The joint between a body and its parent, which lies in the body's origin.

    Attributes:
        name: As in the file.
        axis: Unit vector in the body's frame. Shape (3,).
        lower: In [rad]; minus infinity where the file states no range.
        upper: Likewise; infinity.
        effort: As stated, in [N m]; 0 where it is not.
        velocity: As stated, in [rad/s].
        mimics: Name of the joint that it follows, with factor and offset; None on its own.
        tag: Where it stands.
    """

    name: str
    axis: np.ndarray
    lower: float
    upper: float
    effort: float
    velocity: float
    mimics: tuple[str, float, float] | None
    tag: Tag


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """What moves as one: a link, with all links that are fixed to it.

    Attributes:
        name: Of the link that its joint carries.
        links: Names of all its links.
        parent: Place of the parent among the bodies; -1 for the root.
        joint: Joint to the parent; None for the root.
        position: Its frame in the parent's frame at zero angle, in [m]. Shape (3,).
        rotation: Likewise. Shape (3, 3).
        mass: In [kg].
        centre: Centre of mass in the body's frame, in [m]. Shape (3,).
        inertia: About that centre, along the body's axes, in [kg m^2]. Shape (3, 3).
        shapes: In the body's frame.
    """

    name: str
    links: tuple[str, ...]
    parent: int
    joint: BodyJoint | None
    position: np.ndarray
    rotation: np.ndarray
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    shapes: tuple[Geometry, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Bodies:
    """A robot as bodies, every parent before its children.

    Attributes:
        name: As in the file.
        bodies: The root first.
        link_count: Links of the file.
        notes: What was found that a user should know, a sentence each.
    """

    name: str
    bodies: tuple[Body, ...]
    link_count: int
    notes: tuple[str, ...]

    @property
    def mass(self) -> float:
        """Of the whole robot, in [kg]."""
        return sum(body.mass for body in self.bodies)

    @cached_property
    def at_zero(self) -> tuple[np.ndarray, np.ndarray]:
        """Frames of the bodies in the root's at zero angles: (bodies, 3) [m], (bodies, 3, 3)."""
        position, rotation = (
            np.zeros((len(self.bodies), 3)),
            np.tile(np.eye(3), (len(self.bodies), 1, 1)),
        )
        for k, body in enumerate(self.bodies[1:], start=1):
            position[k] = position[body.parent] + rotation[body.parent] @ body.position
            rotation[k] = rotation[body.parent] @ body.rotation
        return position, rotation


def some(names: Sequence[str], one: str, many: str) -> str:
    """How many there are and the first of them: `12 bodies (a, b, c and 9 more)`."""
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"{len(names)} {one if len(names) == 1 else many} ({', '.join(names[:SHOWN])}{more})"


def read_urdf(text: str, file: Path) -> Bodies:
    """The bodies that a URDF describes.

    Args:
        text: The file.
        file: What it is called in messages.

    Raises:
        FileError: At the line and column of the first mistake.
    """
    root = parse(text, file)
    if root.name != "robot":
        raise root.wrong(f"found <{root.name}>; a URDF is one <robot>")
    links = _named(root, "link")
    joints = _named(root, "joint")
    if not joints:
        raise root.wrong("no <joint> is in the file, so nothing can walk")
    start, children = _tree(root, links, joints)
    return _merged(root, links, start, children)


def _named(root: Tag, kind: str) -> dict[str, Tag]:
    """Elements of a kind by name, each name once."""
    found: dict[str, Tag] = {}
    for tag in root.all(kind):
        name = tag.text("name")
        if name in found:
            raise tag.wrong(
                f"a second {kind} is called {name!r}; the first is on line {found[name].line}"
            )
        found[name] = tag
    return found


def _tree(
    root: Tag, links: Mapping[str, Tag], joints: Mapping[str, Tag]
) -> tuple[str, dict[str, list[Tag]]]:
    """The link that everything hangs on, and the joints below each link."""
    children: dict[str, list[Tag]] = {name: [] for name in links}
    above: dict[str, Tag] = {}
    for joint in joints.values():
        ends = []
        for role in ("parent", "child"):
            end = joint.first(role)
            if end is None:
                raise joint.wrong(f"joint {joint.text('name')!r} has no <{role}>")
            if end.text("link") not in links:
                raise end.wrong(
                    f"joint {joint.text('name')!r}: no link is called {end.text('link')!r}"
                )
            ends.append(end.text("link"))
        if ends[1] in above:
            other = above[ends[1]].text("name")
            raise joint.wrong(
                f"link {ends[1]!r} hangs on two joints, {other!r} and {joint.text('name')!r}"
            )
        above[ends[1]] = joint
        children[ends[0]].append(joint)
    roots = [name for name in links if name not in above]
    if not roots:
        raise root.wrong("the joints form a loop; one link has no joint above it")
    if len(roots) > 1:
        raise links[roots[1]].wrong(
            f"{len(roots)} links hang on nothing: {', '.join(roots[:5])}; join them, fixed"
        )
    reached = list(_below(roots[0], children))
    if len(reached) < len(links):
        lost = next(name for name in links if name not in set(reached))
        raise above[lost].wrong(f"link {lost!r} hangs on itself by a loop of joints")
    return roots[0], children


def _below(link: str, children: Mapping[str, list[Tag]]) -> Iterator[str]:
    todo = [link]
    while todo:
        name = todo.pop()
        yield name
        todo += [_child(joint) for joint in children[name]]


def _child(joint: Tag) -> str:
    end = joint.first("child")
    assert end is not None  # `_tree` has looked
    return end.text("link")


@dataclass(eq=False)
class _Growing:
    """A body to which links are still added."""

    name: str
    parent: int
    joint: BodyJoint | None
    position: np.ndarray
    rotation: np.ndarray
    links: list[str] = field(default_factory=list)
    parts: list[tuple[float, np.ndarray, np.ndarray]] = field(default_factory=list)
    shapes: list[Geometry] = field(default_factory=list)


def _merged(
    root: Tag, links: Mapping[str, Tag], start: str, children: Mapping[str, list[Tag]]
) -> Bodies:
    """The bodies of a tree of links."""
    start = _without_world(links, start, children)
    growing = [_Growing(start, -1, None, np.zeros(3), np.eye(3))]
    todo = [(start, 0, np.zeros(3), np.eye(3))]  # link, its body, its frame in the body's
    while todo:
        name, place, position, rotation = todo.pop(0)
        _add(growing[place], links[name], position, rotation)
        for joint in children[name]:
            at, turn = _pose(joint)
            at, turn = position + rotation @ at, rotation @ turn
            if joint.text("type") == "fixed":
                todo.append((_child(joint), place, at, turn))
                continue
            growing.append(_Growing(_child(joint), place, _moving(joint), at, turn))
            todo.append((_child(joint), len(growing) - 1, np.zeros(3), np.eye(3)))
    light = [body.name for body in growing if body.joint is not None and not body.parts]
    given = f"no mass stated, though it has a joint; given {1e3 * LEAST_MASS:g} g each"
    found = Bodies(
        name=root.attributes.get("name", "robot"),
        bodies=tuple(map(_finished, growing)),
        link_count=len(links),
        notes=(f"{some(light, 'body', 'bodies')}: {given}",) if light else (),
    )
    if not 0.0 < found.mass <= HEAVIEST:
        raise root.wrong(
            f"the robot weighs {found.mass:g} kg; more than 0 and at most {HEAVIEST:g} are expected"
        )
    return found


def _without_world(links: Mapping[str, Tag], start: str, children: Mapping[str, list[Tag]]) -> str:
    """The root without a world above it that it floats in."""
    while len(children[start]) == 1 and children[start][0].attributes.get("type") == "floating":
        if links[start].first("inertial") is not None:
            raise children[start][0].wrong(
                "a floating joint is understood below a world without mass alone"
            )
        start = _child(children[start][0])
    return start


def _moving(joint: Tag) -> BodyJoint:
    """A joint that turns.

    Raises:
        FileError: If it does something else.
    """
    name, kind = joint.text("name"), joint.text("type")
    if kind not in MOVING:
        raise joint.wrong(
            f"joint {name!r} is {kind}; a walking robot's are {', '.join(MOVING)} or fixed"
        )
    element = joint.first("axis")
    axis = np.array([1.0, 0.0, 0.0]) if element is None else element.numbers("xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise (element or joint).wrong(f"joint {name!r} turns about no axis: found 0 0 0")
    lower, upper, effort, velocity = -inf, inf, 0.0, 0.0
    limit = joint.first("limit")
    if limit is not None:
        effort, velocity = limit.number("effort", 0.0), limit.number("velocity", 0.0)
        stated = limit.number("lower", 0.0), limit.number("upper", 0.0)
        if kind == "revolute" and stated[0] < stated[1]:
            lower, upper = stated
    follows = joint.first("mimic")
    mimics = None
    if follows is not None:
        mimics = (
            follows.text("joint"), follows.number("multiplier", 1.0), follows.number("offset", 0.0)
        )  # fmt: skip
    return BodyJoint(name, axis / length, lower, upper, effort, velocity, mimics, joint)


def _pose(tag: Tag) -> tuple[np.ndarray, np.ndarray]:
    """Position and rotation of an element's <origin>; fixed axes roll, pitch, yaw [URDF]."""
    origin = tag.first("origin")
    if origin is None:
        return np.zeros(3), np.eye(3)
    roll, pitch, yaw = origin.numbers("rpy", (0.0, 0.0, 0.0))
    turn = axis_rotation("z", yaw) @ axis_rotation("y", pitch) @ axis_rotation("x", roll)
    return origin.numbers("xyz", (0.0, 0.0, 0.0)), turn


def _add(body: _Growing, link: Tag, position: np.ndarray, rotation: np.ndarray) -> None:
    """Mass and shapes of a link at a pose in a body."""
    body.links.append(link.text("name"))
    inertial = link.first("inertial")
    if inertial is not None:
        at, turn = _pose(inertial)
        mass = inertial.first("mass")
        kilograms = mass.number("value", 0.0) if mass is not None else 0.0
        if kilograms < 0.0:
            raise (mass or inertial).wrong(f"link {link.text('name')!r} weighs {kilograms:g} kg")
        if kilograms > 0.0:
            turned = rotation @ turn
            about = turned @ _tensor(inertial) @ turned.T
            body.parts.append((kilograms, position + rotation @ at, about))
    for role in ("collision", "visual"):
        for tag in link.all(role):
            shape = _shape(tag, role == "collision")
            if shape is not None:
                body.shapes.append(
                    shape._replace(
                        position=position + rotation @ shape.position,
                        rotation=rotation @ shape.rotation,
                    )
                )


def _tensor(inertial: Tag) -> np.ndarray:
    element = inertial.first("inertia")
    if element is None:
        return np.zeros((3, 3))
    xx, xy, xz, yy, yz, zz = (
        element.number(name, 0.0) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _shape(tag: Tag, collision: bool) -> Geometry | None:
    """The geometry of a <visual> or <collision>; None if it has none that is known."""
    geometry = tag.first("geometry")
    at, turn = _pose(tag)
    for element in geometry.children if geometry is not None else ():
        size: tuple[float, ...]
        if element.name == "box":
            size = tuple(element.numbers("size", (0.0, 0.0, 0.0)))
        elif element.name == "cylinder":
            size = (element.number("radius", 0.0), element.number("length", 0.0))
        elif element.name == "sphere":
            size = (element.number("radius", 0.0),)
        elif element.name == "mesh":
            scale = tuple(element.numbers("scale", (1.0, 1.0, 1.0)))
            return Geometry("mesh", scale, element.text("filename"), at, turn, collision)
        else:
            continue
        if min(size) <= 0.0:
            raise element.wrong(f"<{element.name}> has a size of {min(size):g}; it is above 0")
        return Geometry(cast(Kind, element.name), size, "", at, turn, collision)
    return None


def _finished(body: _Growing) -> Body:
    """A body with the sums of its links."""
    mass = sum(part[0] for part in body.parts)
    if mass > 0.0:
        centre = sum(part[0] * part[1] for part in body.parts) / mass
        inertia = sum(
            (about + _steiner(weight, at - centre) for weight, at, about in body.parts),
            start=np.zeros((3, 3)),
        )
    else:
        centre, inertia = np.zeros(3), np.zeros((3, 3))
        if body.joint is not None:
            mass, inertia = LEAST_MASS, LEAST_MASS * LEAST_RADIUS**2 * np.eye(3)
    return Body(
        name=body.name,
        links=tuple(body.links),
        parent=body.parent,
        joint=body.joint,
        position=body.position,
        rotation=body.rotation,
        mass=mass,
        centre=np.asarray(centre),
        inertia=np.asarray(inertia),
        shapes=tuple(body.shapes),
    )


def with_lump(robot: Bodies, place: int, mass: float, at: np.ndarray) -> Bodies:
    """The robot with a point mass more on a body, in [kg], at a point of its frame in [m]."""
    body = robot.bodies[place]
    total = body.mass + mass
    if total <= 0.0:
        return robot
    centre = (body.mass * body.centre + mass * at) / total
    inertia = body.inertia + _steiner(body.mass, body.centre - centre) + _steiner(mass, at - centre)
    heavier = replace(body, mass=total, centre=centre, inertia=inertia)
    bodies = (*robot.bodies[:place], heavier, *robot.bodies[place + 1 :])
    return replace(robot, bodies=bodies)


def _steiner(mass: float, offset: np.ndarray) -> np.ndarray:
    """What a point mass adds to the inertia about a point so far away. Shapes (3,) to (3, 3)."""
    return mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
