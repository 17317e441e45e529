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

from gaitlab.documents.outputs import MARK
from gaitlab.log import TrialLog
from gaitlab.model import Link, Robot, gantry_of
from gaitlab.model.mjcf import add_bodies, add_couplings, number, numbers
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.model.urdf import urdf
from gaitlab.render.export.recorded import ExportedTrial
from gaitlab.render.scene import channels, link_colour


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
    gravity = numbers(shown.trial.slope.gravity)
    SubElement(model, "option", timestep=number(header.dt), gravity=gravity)
    world = SubElement(model, "worldbody")
    SubElement(world, "light", pos="0 0 3", dir="0 0 -1")
    SubElement(
        world, "geom", name="floor", type="plane", size="0 0 0.1", contype="1", conaffinity="0"
    )
    for link, body in zip(robot.tree.links, add_bodies(world, robot).values(), strict=True):
        _add_shapes(body, robot, link)
    add_couplings(model, robot)
    actuators = SubElement(model, "actuator")
    for name, limit in zip(header.joints, header.torque_limits, strict=True):
        if limit > 0.0:
            control = numbers((-limit, limit))
            SubElement(actuators, "motor", name=name, joint=name, ctrlrange=control)
    start = numbers(_start(robot, shown.log))
    SubElement(SubElement(model, "keyframe"), "key", name="start", qpos=start)
    ElementTree.indent(model)
    return ElementTree.tostring(model, encoding="unicode") + "\n"


def _add_shapes(body: Element, robot: Robot, link: Link) -> None:
    """Boxes, and below a foot the spheres that it stands on."""
    colour = numbers((*channels(link_colour(link, robot.feet)), 1.0))
    foot = link.name in robot.feet
    half = [0.5 * edge for edge in link.box.size]
    box = SubElement(body, "geom", type="box", size=numbers(half), pos=numbers(link.box.centre))
    box.attrib |= {"rgba": colour, "contype": "0", "conaffinity": "0" if foot else "1"}
    if foot:
        for x, y, z in robot.sole.supports(robot.feet.index(link.name)):
            place = numbers((x, y, z + SUPPORT_RADIUS))
            sphere = SubElement(body, "geom", type="sphere", size=number(SUPPORT_RADIUS), pos=place)
            sphere.attrib |= {"rgba": colour, "contype": "0", "conaffinity": "1"}


def _start(robot: Robot, log: TrialLog) -> list[float]:
    """Pose of the trunk, and positions in the order in which MuJoCo meets the joints.

    That is each body before its children.
    """
    tree = robot.tree
    x, y, z = log.vector("trunk_")[0].tolist()
    hung = gantry_of(robot) != "none"
    trunk = [x, z, 0.0] if hung else [x, y, z, *log.vector("trunk_q", "wxyz")[0].tolist()]

    def below(name: str) -> Iterable[float]:
        for link in tree.links:
            if link.parent == name and link.joint is not None:
                yield float(log[f"{link.joint.name}_position"][0])
                yield from below(link.name)

    return [*trunk, *below(tree.links[0].name)]
