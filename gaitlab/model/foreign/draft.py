"""Files that a team goes on from: a robot file with all that was found, and a first experiment.

Both are valid as they are. What may be overridden stands in the robot file as a comment with the
value that was found, so that a line says the same with its `#` and without.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gaitlab.documents import Node, inline, plain
from gaitlab.model.foreign.findings import RobotFindings
from gaitlab.model.foreign.reduced import plain as plain_name
from gaitlab.model.foreign.robot_file import DEFAULT, FORWARD, Loaded

SIDE = re.compile(r"(?<![a-z])(left|right|l|r)(?![a-z])", re.IGNORECASE)
GROUNDS = ("hard_floor", "carpet_4mm", "grass_10mm", "grass_30mm")
SERVO_FILE = re.compile(r"\.ya?ml$")
SHOWN = 3  # held joints of the posture's line


def robot_draft(file: Path, loaded: Loaded, found: RobotFindings, said: Node) -> str:
    """Text of a robot file.

    Args:
        file: Where it will be.
        loaded: The robot.
        found: What was found of it.
        said: What a user has said of it already; stands in the draft.
    """
    stated = {key: node for key, node in said.mapping.items() if key != "urdf"}
    found_here = {k: text for k, text in _found(loaded, found).items() if k not in stated}
    return "\n".join(
        [
            f"# {file.name}, drafted by gaitlab. A line without its # says what was found anyway;",
            "# change what is wrong. Once changed, the file is kept as it is.",
            f"urdf: {inline(way(file.parent, loaded.urdf))}",
            *(f"{key}: {inline(_placed(node, file.parent))}" for key, node in stated.items()),
            *([] if "servos" in stated else _servo_lines(loaded)),
            *(f"# {key}: {text}" for key, text in found_here.items()),
            "",
        ]
    )


def experiment_draft(file: Path, robot: Path, found: RobotFindings) -> str:
    """Text of a first experiment.

    Args:
        file: Where it will be.
        robot: The robot file.
        found: What was found of the robot.
    """
    search = shlex.join(["--set", f"robot={way(Path.cwd(), robot)}"])
    return "\n".join(
        [
            f"# {file.name}, drafted by gaitlab: the walk that comes of the robot's size, not of a",
            f"# search. A better one for this robot: gaitlab optimize first_walk {search}",
            f"name: {plain_name(found.name).strip('_') or 'my_robot'}_first_walk",
            f"title: {inline(f'The first walk of {found.name}')}",
            f"robot: {inline(way(file.parent, robot))}",
            "gait: walk  # or {type: walk, step_length: 0.02}: `gaitlab show walk` has all of it",
            f"surfaces: [{', '.join(GROUNDS)}]",
            "seeds: 10",
            "horizon: {cycles: 10, distance: 6.0, time: 30.0}",
            "",
        ]
    )


def way(folder: Path, file: Path) -> str:
    """A file as what lies in a folder names it."""
    found = Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
    return found if found.startswith("../") else f"./{found}"


def _placed(node: Node, folder: Path) -> object:
    """Plain values, files of servos as a file in a folder names them."""
    if isinstance(node.value, str) and SERVO_FILE.search(node.value):
        return way(folder, node.folder / node.value)
    if node.mapping:
        return {key: _placed(child, folder) for key, child in node.mapping.items()}
    return plain(node)


def _servo_lines(loaded: Loaded) -> list[str]:
    """The servos that the robot has now, and a word on those that nobody states."""
    head = ["# The URDF's servos; a file of `gaitlab list servos` knows latency and backlash too:"]
    if loaded.unstated:
        head = [
            f"# SERVOS ARE MISSING: nobody states them for {len(loaded.unstated)} joints, so these",
            "# numbers are assumed. Give stall torque [N m] and speed [rad/s], or a name from",
            "# `gaitlab list servos`, and take the # away:",
        ]
    robot, names = loaded.cls(), _names(loaded)
    joints = {names[joint.name]: joint.servo for joint in robot.tree.joints}
    types = list(dict.fromkeys(joints.values()))
    usual = max(types, key=list(joints.values()).count)
    lines = ["# servos:"]
    for servo in [usual, *(each for each in types if each != usual)]:
        key = DEFAULT
        if servo != usual:
            key = _pattern([name for name, own in joints.items() if own == servo])
        numbers = robot.own_servos[str(servo)]
        lines.append(
            f"#   {inline(key)}: {{stall_torque: {numbers.stall_torque:.6g}, "
            f"no_load_speed: {numbers.no_load_speed:.6g}}}"
        )
    return [*head, *lines]


def _pattern(joints: list[str]) -> str:
    """A regular expression for joints, one for both sides."""
    both = dict.fromkeys(_either_side(name, joints) for name in joints)
    return "|".join(both)


def _either_side(joint: str, joints: list[str]) -> str:
    """A joint's name with the side left open if the other side's joint is among them."""
    found = SIDE.search(joint)
    if found is None:
        return re.escape(joint)
    left = found[0].lower() in ("left", "l")
    words = ("left", "right") if len(found[0]) > 1 else ("l", "r")
    if found[0].isupper():
        words = (words[0].upper(), words[1].upper())
    other = joint[: found.start()] + words[1 if left else 0] + joint[found.end() :]
    if found[0] not in words or other not in joints:
        return re.escape(joint)
    start, end = re.escape(joint[: found.start()]), re.escape(joint[found.end() :])
    return f"{start}({words[0]}|{words[1]}){end}"


def _found(loaded: Loaded, found: RobotFindings) -> Mapping[str, str]:
    """What a robot file may say, as it was found."""
    sole, robot = found.sole, loaded.cls()
    left, right = (inline(foot) for foot in found.legs.feet)
    held = list(robot.posture_fields.items())[:SHOWN]
    posture = [
        f"{inline(re.escape(_names(loaded)[joint]))}: {getattr(robot.posture, field):.6g}"
        for joint, field in held
    ]
    lengths = ", ".join(
        f"{key}: {getattr(sole, key):.6g}" for key in ("length", "width", "heel", "height")
    )
    lines = {
        "description": inline(found.name),
        "mass": f"{found.mass:.6g}  # kg, if you have weighed it; the difference is the trunk's",
        "posture": f"{{{', '.join(posture)}}}  # rad, joints by regular expression",
        "legs": f"{{left: {left}, right: {right}}}",
        "sole": f"{{{lengths}}}  # m; kind: studs for four corners",
        "forward": f"{_forward(loaded.legs.base)}  # axis of the root link that points ahead",
    }
    return lines if posture else {key: text for key, text in lines.items() if key != "posture"}


def _names(loaded: Loaded) -> dict[str, str]:
    """What the URDF calls the joints, by their names here."""
    joints = [body.joint.name for body in loaded.bodies.bodies if body.joint is not None]
    return {plain_name(joint): joint for joint in joints}


def _forward(base: np.ndarray) -> str:
    """The axis of the root link that points ahead."""
    axes = {name: np.eye(3)["xyz".index(name[-1])] * (-1.0) ** len(name[:-1]) for name in FORWARD}
    return max(axes, key=lambda name: float(axes[name] @ base[0]))
