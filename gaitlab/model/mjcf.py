"""A robot's tree as MJCF, which MuJoCo reads: bodies, joints and inertias, but no shapes.

References:
    MJCF: MuJoCo documentation, XML reference, Google DeepMind.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gaitlab.kinematics.transforms import quaternion_of
from gaitlab.model.robot import GANTRY_PITCH, Robot, couplings_of, gantry_of
from gaitlab.model.tree import unit_axis

RIG = (("gantry_x", "slide", "1 0 0"), ("gantry_z", "slide", "0 0 1"))


def add_bodies(world: Element, robot: Robot) -> dict[str, Element]:
    """Add the links of a robot to a world, [MJCF].

    The trunk moves freely, or on its gantry: two slides and the joint that pitches it.

    Returns:
        The body of each link by its name.
    """
    bodies = {"": world}
    for link in robot.tree.links:
        body = SubElement(
            bodies[link.parent or ""], "body", name=link.name, pos=numbers(link.origin)
        )
        bodies[link.name] = body
        if link.turn is not None:
            x, y, z, w = quaternion_of(np.reshape(link.turn, (3, 3)))
            body.set("quat", numbers((w, x, y, z)))
        if link.joint is not None:
            limits = numbers((link.joint.lower, link.joint.upper))
            joint = SubElement(body, "joint", name=link.joint.name, type="hinge", range=limits)
            joint.set("axis", numbers(unit_axis(link.joint.axis)))
        elif gantry_of(robot) == "none":
            SubElement(body, "freejoint", name="free")
        else:
            for name, kind, axis in (*RIG, (GANTRY_PITCH, "hinge", "0 1 0")):
                SubElement(body, "joint", name=name, type=kind, axis=axis)
        inertial = SubElement(body, "inertial", pos=numbers(link.centre), mass=number(link.mass))
        diagonal, products = link.moments[:3], link.moments[3:]
        if any(products):
            inertial.set("fullinertia", numbers(link.moments))
        else:
            inertial.set("diaginertia", numbers(diagonal))
    del bodies[""]
    return bodies


def add_couplings(model: Element, robot: Robot) -> None:
    """Tie the joints together that gears and belts of a robot tie, [MJCF]."""
    if not couplings_of(robot):
        return
    equality = SubElement(model, "equality")
    for leader, follower, ratio in couplings_of(robot):
        law = f"0 {number(ratio)} 0 0 0"
        SubElement(equality, "joint", joint1=follower, joint2=leader, polycoef=law)


def number(value: float) -> str:
    """A number as it is, to the last bit."""
    return repr(float(value))


def numbers(values: Iterable[float]) -> str:
    """Numbers likewise, with spaces between."""
    return " ".join(map(number, values))
