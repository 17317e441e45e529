"""The robot of a trial as URDF and as MJCF, which MuJoCo reads, as it stood at the first tick.

The robot stands on spheres at the support points of its soles, as in URDF, and touches the floor
only. Motors have the torque limits of its servos; the servos' own law is not part of the model.

References:
    MJCF: MuJoCo documentation, XML reference, Google DeepMind.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from gaitlab.documents.outputs import MARK
from gaitlab.kinematics.transforms import quaternion_of
from gaitlab.log import GRAVITY, TrialLog
from gaitlab.model import GANTRY_PITCH, Joint, Link, Robot, couplings_of, gantry_of
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.model.urdf import urdf
from gaitlab.render.export.recorded import ExportedTrial
from gaitlab.render.scene import channels, link_colour

_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1", "-x": "-1 0 0", "-y": "0 -1 0", "-z": "0 0 -1"}


def write_model(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Write the URDF and the MJCF."""
    robot = shown.trial.robot
    # Without a gantry's massless rig, which only Bullet takes; the MJCF has it as joints.
    texts = (urdf(robot.tree, robot.sole, robot.feet), _mjcf(shown))
    for file, text in zip(files, texts, strict=True):
        file.write_text(f"{text}<!-- written by {MARK} -->\n", encoding="utf-8")


def _mjcf(shown: ExportedTrial) -> str:
    """The robot over a hard floor, with a keyframe `start`, [MJCF]."""
    robot, header = shown.trial.robot, shown.log.header
    model = Element("mujoco", model=robot.name)
    SubElement(model, "compiler", angle="radian", autolimits="true")
    SubElement(model, "option", timestep=_text(header.dt), gravity=_texts((0.0, 0.0, -GRAVITY)))
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
        if link.turn is not None:
            x, y, z, w = quaternion_of(np.reshape(link.turn, (3, 3)))
            body.set("quat", _texts((w, x, y, z)))
        _fill(body, robot, link)
        bodies[link.name] = body
    _add_couplings(model, robot)
    actuators = SubElement(model, "actuator")
    for name, limit in zip(header.joints, header.torque_limits, strict=True):
        if limit > 0.0:
            control = _texts((-limit, limit))
            SubElement(actuators, "motor", name=name, joint=name, ctrlrange=control)
    start = _texts(_start(robot, shown.log, hung))
    SubElement(SubElement(model, "keyframe"), "key", name="start", qpos=start)
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
    inertial = SubElement(body, "inertial", pos=_texts(link.centre), mass=_text(link.mass))
    diagonal, products = link.moments[:3], link.moments[3:]
    if any(products):
        inertial.set("fullinertia", _texts(link.moments))
    else:
        inertial.set("diaginertia", _texts(diagonal))
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


def _start(robot: Robot, log: TrialLog, hung: bool) -> list[float]:
    """Pose of the trunk, and positions in the order in which MuJoCo meets the joints.

    That is each body before its children.
    """
    tree = robot.tree
    x, y, z = log.vector("trunk_")[0].tolist()
    trunk = [x, z, 0.0] if hung else [x, y, z, *log.vector("trunk_q", "wxyz")[0].tolist()]

    def below(name: str) -> Iterable[float]:
        for link in tree.links:
            if link.parent == name and link.joint is not None:
                yield float(log[f"{link.joint.name}_position"][0])
                yield from below(link.name)

    return [*trunk, *below(tree.links[0].name)]


def _text(value: float) -> str:
    return repr(float(value))


def _texts(values: Iterable[float]) -> str:
    return " ".join(map(_text, values))
