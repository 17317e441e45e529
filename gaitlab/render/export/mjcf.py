"""A robot's tree as MJCF, the form in which MuJoCo reads it.

The robot stands on spheres at the support points of its soles, as in URDF, and touches the floor
only. Motors have the torque limits of its servos; the servos' own law is not part of the model.

References:
    MJCF: MuJoCo documentation, XML reference, Google DeepMind.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model import GANTRY_PITCH, Joint, Link, Robot, couplings_of, gantry_of
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.model.urdf import box_inertia
from gaitlab.render.scene import channels, link_colour

_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1", "-x": "-1 0 0", "-y": "0 -1 0", "-z": "0 0 -1"}


def mjcf(
    robot: Robot,
    torque_limits: Mapping[str, float],
    *,
    position: np.ndarray,
    quaternion: np.ndarray,
    joints: np.ndarray,
    dt: float,
) -> str:
    """MJCF of a robot over a hard floor, with a keyframe `start`, [MJCF].

    Args:
        robot: The robot.
        torque_limits: Largest torque of each driven joint's servo, in [N m], by joint.
        position: Of the trunk link frame at the start, in [m]. Shape (3,).
        quaternion: Of the trunk link frame, xyzw. Shape (4,).
        joints: Positions in the order of the robot's tree, in [rad]. Shape (joints,).
        dt: Time step, in [s].
    """
    model = Element("mujoco", model=robot.name)
    SubElement(model, "compiler", angle="radian", autolimits="true")
    SubElement(model, "option", timestep=_text(dt), gravity=_texts((0.0, 0.0, -GRAVITY)))
    world = SubElement(model, "worldbody")
    SubElement(world, "light", pos="0 0 3", dir="0 0 -1")
    SubElement(
        world, "geom", name="floor", type="plane", size="0 0 0.1", contype="1", conaffinity="0"
    )
    hung = gantry_of(robot) != "none"
    bodies = {"": world}
    for link in robot.tree.links:
        above = bodies[link.parent or ""]
        body = SubElement(above, "body", name=link.name, pos=_texts(link.origin))
        _fill(body, robot, link)
        bodies[link.name] = body
    _add_couplings(model, robot)
    actuators = SubElement(model, "actuator")
    for name, limit in torque_limits.items():
        SubElement(actuators, "motor", name=name, joint=name, ctrlrange=_texts((-limit, limit)))
    start = (position[0], position[2], 0.0) if hung else (*position, *np.roll(quaternion, 1))
    ordered = _in_body_order(robot, joints)
    SubElement(SubElement(model, "keyframe"), "key", name="start", qpos=_texts((*start, *ordered)))
    ElementTree.indent(model)
    return ElementTree.tostring(model, encoding="unicode") + "\n"


def _let_move(trunk: Element, hung: bool) -> None:
    """The trunk moves freely, or on its rig."""
    if not hung:
        SubElement(trunk, "freejoint", name="free")
        return
    rig = (("gantry_x", "slide", "x"), ("gantry_z", "slide", "z"), (GANTRY_PITCH, "hinge", "y"))
    for name, kind, axis in rig:
        SubElement(trunk, "joint", name=name, type=kind, axis=_AXES[axis])


def _fill(body: Element, robot: Robot, link: Link) -> None:
    """Joint, mass and shape of a link."""
    if link.joint is not None:
        _add_joint(body, link.joint)
    else:
        _let_move(body, gantry_of(robot) != "none")
    moments = link.inertia or box_inertia(link.mass, link.box.size)
    SubElement(
        body,
        "inertial",
        pos=_texts(link.box.centre),
        mass=_text(link.mass),
        diaginertia=_texts(moments),
    )
    colour = _texts((*channels(link_colour(link, robot.feet)), 1.0))
    foot = link.name in robot.feet
    half = [0.5 * edge for edge in link.box.size]
    box = SubElement(body, "geom", type="box", size=_texts(half), pos=_texts(link.box.centre))
    box.attrib |= {"rgba": colour, "contype": "0", "conaffinity": "0" if foot else "1"}
    if foot:
        for x, y, z in robot.sole.supports(robot.feet.index(link.name)):
            place = _texts((x, y, z + SUPPORT_RADIUS))
            sphere = SubElement(body, "geom", type="sphere", size=_text(SUPPORT_RADIUS), pos=place)
            sphere.attrib |= {"rgba": colour, "contype": "0", "conaffinity": "1"}


def _add_joint(body: Element, joint: Joint) -> None:
    axis = _AXES[joint.axis] if isinstance(joint.axis, str) else _texts(joint.axis)
    limits = _texts((joint.lower, joint.upper))
    SubElement(body, "joint", name=joint.name, type="hinge", axis=axis, range=limits)


def _add_couplings(model: Element, robot: Robot) -> None:
    couplings = couplings_of(robot)
    if not couplings:
        return
    equality = SubElement(model, "equality")
    for leader, follower, ratio in couplings:
        law = f"0 {_text(ratio)} 0 0 0"
        SubElement(equality, "joint", joint1=follower, joint2=leader, polycoef=law)


def _in_body_order(robot: Robot, joints: np.ndarray) -> list[float]:
    """Positions in the order in which MuJoCo meets the joints: each body before its children."""
    tree = robot.tree
    found = {joint.name: float(q) for joint, q in zip(tree.joints, joints, strict=True)}

    def below(name: str) -> Iterable[float]:
        for link in tree.links:
            if link.parent == name and link.joint is not None:
                yield found[link.joint.name]
                yield from below(link.name)

    return list(below(tree.links[0].name))


def _text(value: float) -> str:
    return repr(float(value))


def _texts(values: Iterable[float]) -> str:
    return " ".join(map(_text, values))
