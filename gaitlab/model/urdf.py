"""A robot's tree as URDF text, the form in which the physics engine reads it.

References:
    URDF: Unified Robot Description Format, XML specification, ROS wiki.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gaitlab.kinematics.transforms import roll_pitch_yaw
from gaitlab.model import GANTRY_PITCH, Box, Joint, Link, Tree
from gaitlab.model.soles import SUPPORT_RADIUS, Sole

# A URDF must state both. The servo's law bounds torque and speed, so these bind no servo it knows.
EFFORT = 1000.0  # N m
VELOCITY = 100.0  # rad/s
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
SHELL = "_shell"  # behind the name of the link that it belongs to

_AXES = {
    **{"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"},
    **{"-x": "-1 0 0", "-y": "0 -1 0", "-z": "0 0 -1"},
}


def urdf(
    tree: Tree,
    sole: Sole,
    feet: tuple[str, str],
    *,
    effort: float = EFFORT,
    velocity: float = VELOCITY,
    on_gantry: bool = False,
    shells: Mapping[str, Box] | None = None,
) -> str:
    """URDF of a robot whose links are boxes and whose feet stand on small spheres, [URDF].

    The lowest point of each sphere is a support point of the sole, so that what touches the ground
    does not depend on the history of contact as it does for a box.

    Args:
        tree: Links, the trunk first.
        sole: Sole of the left foot; the right one mirrors it.
        feet: Names of the foot links.
        effort: Torque limit written to every joint, in [N m].
        velocity: Speed limit written to every joint, in [rad/s].
        on_gantry: Hang the trunk on a massless rig that slides along x and z and pitches.
        shells: Boxes for contact with other links, by the link that each is fixed to; a foot's own
            balls touch nothing but the ground.

    Raises:
        ValueError: If a foot is no link of the tree.
    """
    missing = set(feet) - {link.name for link in tree.links}
    if missing:
        raise ValueError(f"no links called {sorted(missing)} in the tree")
    robot = Element("robot", name="robot")
    if on_gantry:
        _add_gantry(robot, tree.links[0].name)
    for link in tree.links:
        supports = sole.supports(feet.index(link.name)) if link.name in feet else None
        _add_link(robot, link, supports)
        if link.joint is not None:
            _add_joint(robot, link, link.joint, effort, velocity)
    for name, box in (shells or {}).items():
        _add_shell(robot, name, box)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _add_shell(robot: Element, link: str, box: Box) -> None:
    """A massless link that is fixed to another and has a box around that one."""
    shell = SubElement(robot, "link", name=f"{link}{SHELL}")
    _add_no_inertia(shell)
    _add_box(shell, "collision", box)
    joint = SubElement(robot, "joint", name=f"{link}{SHELL}", type="fixed")
    SubElement(joint, "parent", link=link)
    SubElement(joint, "child", link=f"{link}{SHELL}")


def _add_no_inertia(link: Element) -> None:
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "mass", value="0.0")
    SubElement(inertial, "inertia", {moment: "0.0" for moment in MOMENTS})


def _add_gantry(robot: Element, trunk: str) -> None:
    """The rig as a chain of joints, so that what it holds is held exactly."""
    names = ["gantry", "gantry_x", "gantry_z", trunk]
    joints = [("gantry_x", "prismatic", "x"), ("gantry_z", "prismatic", "z")]
    joints.append((GANTRY_PITCH, "continuous", "y"))
    for name in names[:-1]:
        _add_no_inertia(SubElement(robot, "link", name=name))
    for (name, kind, axis), parent, child in zip(joints, names, names[1:], strict=False):
        element = SubElement(robot, "joint", name=name, type=kind)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)
        SubElement(element, "axis", xyz=_AXES[axis])
        if kind == "prismatic":
            SubElement(element, "limit", lower="-1000.0", upper="1000.0", effort="0", velocity="0")


def _add_link(robot: Element, link: Link, supports: np.ndarray | None) -> None:
    element = SubElement(robot, "link", name=link.name)
    _add_inertial(element, link)
    _add_box(element, "visual", link.box)
    if supports is None:
        _add_box(element, "collision", link.box)
        return
    for x, y, z in supports:
        _add_shape(
            element, "collision", (x, y, z + SUPPORT_RADIUS), "sphere", radius=_text(SUPPORT_RADIUS)
        )


def _add_inertial(element: Element, link: Link) -> None:
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=_texts(link.centre))
    SubElement(inertial, "mass", value=_text(link.mass))
    moments = dict(zip(MOMENTS, link.moments, strict=True))
    SubElement(inertial, "inertia", {name: _text(value) for name, value in moments.items()})


def _add_box(element: Element, role: str, box: Box) -> None:
    _add_shape(element, role, box.centre, "box", size=_texts(box.size))


def _add_shape(
    element: Element, role: str, centre: Iterable[float], shape: str, **attributes: str
) -> None:
    place = SubElement(element, role)
    SubElement(place, "origin", xyz=_texts(centre))
    SubElement(SubElement(place, "geometry"), shape, attributes)


def _add_joint(robot: Element, link: Link, joint: Joint, effort: float, velocity: float) -> None:
    element = SubElement(robot, "joint", name=joint.name, type="revolute")
    SubElement(element, "parent", link=str(link.parent))
    SubElement(element, "child", link=link.name)
    origin = SubElement(element, "origin", xyz=_texts(link.origin))
    if link.turn is not None:
        origin.set("rpy", _texts(roll_pitch_yaw(np.reshape(link.turn, (1, 3, 3)))[0]))
    axis = _AXES[joint.axis] if isinstance(joint.axis, str) else _texts(joint.axis)
    SubElement(element, "axis", xyz=axis)
    limits = {"lower": joint.lower, "upper": joint.upper, "effort": effort, "velocity": velocity}
    SubElement(element, "limit", {name: _text(value) for name, value in limits.items()})


def _text(value: float) -> str:
    return repr(float(value))


def _texts(values: Iterable[float]) -> str:
    return " ".join(map(_text, values))
