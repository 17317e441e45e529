"""A robot over the ground as MuJoCo's model, and where in it everything is.

What may meet what is a list of pairs, so that nothing else is looked at: feet and their own planes,
links and the ground, one lower leg and the other. A foot stands on as many spheres as carry the
same as all its supports: sums, moments and stiffness of equal springs are those of four, at their
mean and a standard deviation to both sides along their principal axes. The spheres are put there
in every step, once for the plane of the pile and once for the hard base.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Literal, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.log import GRAVITY
from gaitlab.model import GANTRY_PITCH, Gantry, Robot, Vector, gantry_of, self_collision_of
from gaitlab.model.clearance import links_apart, lower_legs, shape_of
from gaitlab.model.mjcf import add_bodies, add_couplings, number, numbers
from gaitlab.model.soles import SUPPORT_RADIUS

MASS_TOLERANCE = 1e-6  # kg; MuJoCo has to carry exactly the mass that the robot states
# m, from which on what comes near is a contact that may close the gap and no more: to hard ground
# as far as a fall goes in a step, to soft ground as little as can be, as that gives way.
MARGIN, SOFT_MARGIN, LINK_MARGIN = 0.01, 5e-4, 2e-3
LIMIT_MARGIN = 0.05  # rad, likewise to a joint's limit
SPHERES = 4  # of a foot on one ground
TOLERANCE = 1e-6  # of the solver
PARKED = 1e3  # m below the ground or over it, where nothing meets anything
ROOM = "8M"  # of memory for contacts and rows

# What a geom is.
HARD, SOFT, LEFT, RIGHT, LINK = range(5)


class Built(NamedTuple):
    """A model, and where in it things are; `of` gives the same for equal robots.

    Attributes:
        model: MuJoCo's own.
        position: Index into the positions of each joint of the log. Shape (joints,).
        velocity: Likewise of the velocities. Shape (joints,).
        pitch: Whether a gantry leaves the trunk `free` to pitch or has it `held`; None without one.
        trunk: Index of the body of the trunk.
        feet: Of the feet. Shape (2,).
        kind: HARD and so on of each geom. Shape (geoms,).
        planes: Geoms of the soft planes: left, right, and of a layer under all links. Shape (3,).
        spheres: Geoms that a foot stands on, on soft and on hard ground. Shape (2, 2, 4).
    """

    model: mujoco.MjModel
    position: np.ndarray
    velocity: np.ndarray
    pitch: Literal["free", "held"] | None
    trunk: int
    feet: np.ndarray
    kind: np.ndarray
    planes: np.ndarray
    spheres: np.ndarray


def built(
    robot: Robot, joints: np.ndarray, dt: float, gravity: Vector = (0.0, 0.0, -GRAVITY)
) -> Built:
    """The model of a robot; asked for again it is the same, and nobody changes it.

    Args:
        robot: The robot.
        joints: Where its joints start, in [rad]. Shape (joints,).
        dt: Duration of a step, in [s].
        gravity: In [m/s^2].

    Raises:
        WrongValue: If MuJoCo cannot carry a part of it; says which.
    """
    rig = () if gantry_of(robot) == "none" else (GANTRY_PITCH,)
    return _compiled(
        _mjcf(robot, joints, dt, gravity),
        robot.name,
        robot.tree.mass,
        robot.tree.links[0].name,
        robot.feet,
        (*(joint.name for joint in robot.tree.joints), *rig),
        gantry_of(robot),
    )


@lru_cache(maxsize=16)
def _compiled(
    text: str,
    name: str,
    mass: float,
    trunk: str,
    feet: tuple[str, str],
    joints: tuple[str, ...],
    gantry: Gantry,
) -> Built:
    try:
        model = mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        said = " ".join(str(error).split())
        raise WrongValue(f"engine mujoco cannot carry the robot {name!r}: {said}") from error
    weighs = float(np.sum(model.body_mass))
    if abs(weighs - mass) > MASS_TOLERANCE:
        raise WrongValue(f"MuJoCo loaded {weighs} kg of {name!r}, which has {mass} kg")
    found = [model.joint(joint) for joint in joints]
    return Built(
        model=model,
        position=np.array([int(joint.qposadr[0]) for joint in found]),
        velocity=np.array([int(joint.dofadr[0]) for joint in found]),
        pitch=_PITCH[gantry],
        trunk=int(model.body(trunk).id),
        feet=np.array([int(model.body(foot).id) for foot in feet]),
        kind=np.array([_KINDS[model.geom(k).name.split(" ")[0]] for k in range(model.ngeom)]),
        planes=np.array([int(model.geom(f"soft {on}").id) for on in _PLANES]),
        spheres=np.array(
            [
                [[int(model.geom(_sphere(s, g, k)).id) for k in range(SPHERES)] for g in range(2)]
                for s in range(2)
            ]
        ),
    )


_PITCH: dict[Gantry, Literal["free", "held"] | None] = {
    "none": None,
    "planar": "free",
    "level": "held",
}
_KINDS = {"hard": HARD, "soft": SOFT, "left": LEFT, "right": RIGHT, "link": LINK}
_PLANES = ("left", "right", "layer")
_SIDES = ("left", "right")
_GROUNDS = ("soft", "hard")


def _sphere(side: int, ground: int, k: int) -> str:
    return f"{_SIDES[side]} {_GROUNDS[ground]} {k}"


def _mjcf(robot: Robot, joints: np.ndarray, dt: float, gravity: Vector) -> str:
    """The robot over a hard base and three planes that are put in place step by step, [MJCF]."""
    model = Element("mujoco")
    SubElement(model, "compiler", angle="radian", autolimits="true")
    option = SubElement(model, "option", timestep=number(dt), gravity=numbers(gravity))
    option.attrib |= {"cone": "elliptic", "solver": "Newton", "jacobian": "sparse"}
    option.set("tolerance", number(TOLERANCE))
    # Islands keep copies of the rows, which would not be changed with them.
    off = {"island": "disable", "sensor": "disable", "midphase": "disable"}
    SubElement(option, "flag", off | {"autoreset": "disable"})
    SubElement(model, "size", memory=ROOM)
    world = SubElement(model, "worldbody")
    _add_geom(world, "hard base", type="plane", size="0 0 1")
    for on in _PLANES:
        _add_geom(world, f"soft {on}", type="plane", size="0 0 1", pos=f"0 0 {-PARKED}")
    bodies = add_bodies(world, robot)
    for k, link in enumerate(robot.tree.links):
        shape = shape_of(robot, k)
        half = numbers(0.5 * edge for edge in shape.size)
        _add_geom(bodies[link.name], f"link {k}", type="box", size=half, pos=numbers(shape.centre))
    for side, foot in enumerate(robot.feet):
        for name in (_sphere(side, ground, k) for ground in range(2) for k in range(SPHERES)):
            _add_geom(bodies[foot], name, type="sphere", size=number(SUPPORT_RADIUS))
    _make_rows(bodies, robot)
    contact = SubElement(model, "contact")
    for first, second, margin in _pairs(robot, joints):
        pair = SubElement(contact, "pair", geom1=first, geom2=second, condim="3")
        pair.set("margin", number(margin))
    add_couplings(model, robot)
    return ElementTree.tostring(model, encoding="unicode")


def _add_geom(body: Element, name: str, **attributes: str) -> None:
    """A shape that meets only what it is paired with."""
    SubElement(body, "geom", attributes, name=name, contype="0", conaffinity="0", mass="0")


def _make_rows(bodies: dict[str, Element], robot: Robot) -> None:
    """Give every joint with a motor a row, which there is where there is dry friction.

    And one with limits another when it comes near them.
    """
    held = {joint.name for joint in robot.tree.joints if joint.servo is not None}
    if gantry_of(robot) == "level":
        held.add(GANTRY_PITCH)
    for joint in (joint for body in bodies.values() for joint in body.findall("joint")):
        joint.set("margin", number(LIMIT_MARGIN))
        if joint.get("name") in held:
            joint.set("frictionloss", "1")


def _pairs(robot: Robot, joints: np.ndarray) -> Iterator[tuple[str, str, float]]:
    """What meets what, and from which distance in [m] on."""
    for side in range(2):
        for k in range(SPHERES):
            yield f"soft {_SIDES[side]}", _sphere(side, 0, k), SOFT_MARGIN
            yield "hard base", _sphere(side, 1, k), MARGIN
    tree = robot.tree
    for k, link in enumerate(tree.links):
        if link.name not in robot.feet:
            yield "hard base", f"link {k}", MARGIN
            yield "soft layer", f"link {k}", SOFT_MARGIN
    left, right = lower_legs(robot)
    meeting = {(min(a, b), max(a, b)) for a in left for b in right if a != b}
    if self_collision_of(robot):
        meeting |= set(links_apart(robot, joints))
    for a, b in sorted(meeting):
        yield f"link {a}", f"link {b}", LINK_MARGIN
