"""A robot that is a URDF, or a file of a few lines that names one and says what it cannot.

`robot: ./my.urdf` is enough. `my_robot.yaml` adds what a URDF does not know: servos, a mass that
was weighed, a posture; and puts right what was found wrong: legs, sole, the way ahead.

    urdf: ./my.urdf
    servos: {default: mx_106, '.*hip_yaw': {stall_torque: 6.0, no_load_speed: 8.2}}
    mass: {value: 7.4, unit: kg, source: scales with battery}
    posture: {'.*_shoulder_pitch': 0.3}
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from gaitlab.documents import Node, Reader, build, check, load, read_mapping
from gaitlab.errors import FileError, GaitlabError, Problem, WrongValue
from gaitlab.log import GRAVITY
from gaitlab.model.foreign.anatomy import Legs, find_legs
from gaitlab.model.foreign.checks import leg_lengths, mend, without_servo
from gaitlab.model.foreign.meshes import MeshFault, find_mesh, sentences, vertices_of_all
from gaitlab.model.foreign.reading import Bodies, BodyJoint, read_urdf, with_lump
from gaitlab.model.foreign.reduced import SOLE_LENGTHS, Overrides, Reduced, plain, reduced
from gaitlab.model.foreign.robot import numbers_digest, robot_class
from gaitlab.model.servo import Servo
from gaitlab.parameters import Parameter, parameter_table
from gaitlab.plugins import is_file_name, suggestion

SERVO_TORQUE = 0.5  # m g L, of a servo that nobody states
PLAUSIBLE = 5.0  # m g L; public humanoids state 0.3 to 0.7, beyond it nobody has measured
SERVO_SPEED = 7.0  # rad/s, likewise
ASSUMED = {  # what neither a URDF nor two numbers say of a servo
    **{"voltage": 12.0, "supply": 12.0, "torque_limit": 1.0, "latency": 0.004},
    **{"resolution": 0.0, "backlash": 0.0, "mass": 0.0},
}
ASSUMPTION = "assumption"
UNSTATED = "assumption: nobody states the servo"
FULL_DUTY = 0.05  # rad of error; an MX-28 whose P gain is turned up has it
STIFFEST = 500.0  # 1/s
XACRO = ".xacro"
NEAR = 4  # folders above a file in which its package may be
MOST_PARTS = 500  # files of a xacro that are watched for changes
FROM_FILE = "the robot file"  # source of a parameter
DEFAULT = "default"  # in place of a pattern: every other joint
FORWARD = ("x", "-x", "y", "-y")
KINDS = ("flat", "studs")  # of a sole
MASS = Parameter(
    name="mass", type=float, unit="kg", low=0.05, high=200.0, doc="mass of the whole robot"
)
LUMP_MASS = Parameter(name="mass", type=float, unit="kg", low=0.0, high=100.0, doc="mass")
PLACE = Parameter(name="at", type=float, unit="m", low=-3.0, high=3.0, doc="place")
ANGLE = Parameter(name="posture", type=float, unit="rad", low=-6.3, high=6.3, doc="angle")
SOLE = {
    name: Parameter(name=f"sole: {name}", type=float, unit="m", low=low, high=high, doc=doc)
    for name, (doc, low, high) in SOLE_LENGTHS.items()
}
Statement = Literal["URDF", "robot file", "servo file", "assumed"]
EXPECTED = "expected a mapping with `urdf: ./my.urdf`"


class Loaded(NamedTuple):
    """A robot of a file.

    Attributes:
        cls: Its class.
        digest: SHA-256 of its numbers.
        bodies: What the URDF describes.
        legs: The legs that were found.
        found: What it was reduced to.
        notes: What a user should know, a sentence each.
        unstated: Joints for whose servos nobody states torque and speed.
        stated_by: Who states torque and speed, by the servo's name.
        urdf: The URDF.
        files: Every file that was read, with time and size.
    """

    cls: type
    digest: str
    bodies: Bodies
    legs: Legs
    found: Reduced
    notes: tuple[str, ...]
    unstated: tuple[str, ...]
    stated_by: Mapping[str, Statement]
    urdf: Path
    files: tuple[tuple[Path, int, int], ...]


_loaded: dict[Path, Loaded] = {}


def load_robot(path: Path) -> Loaded:
    """The robot of a robot file or a URDF; read again only when a file has changed.

    Raises:
        FileError: At the place of the first mistake.
    """
    known = _loaded.get(path)
    if known is None or known.files != _stamps(file for file, _, _ in known.files):
        known = _loaded[path] = robot_of(path, node_of(path))
    return known


def _stamps(files: Iterable[Path]) -> tuple[tuple[Path, int, int], ...]:
    """Files with their time of change and size; zero for one that is gone."""
    found = []
    for file in files:
        try:
            state = file.stat()
            found.append((file, state.st_mtime_ns, state.st_size))
        except OSError:
            found.append((file, 0, 0))
    return tuple(found)


def node_of(path: Path) -> Node:
    """What a robot file says; of a URDF that it is one, which is all that has to be said.

    Raises:
        FileError: If it is no YAML.
    """
    if is_urdf(path):
        return Node(file=path, value={"urdf": Node(file=path, value=str(path))})
    return load(path)


def is_urdf(path: Path) -> bool:
    """Whether a file is a URDF itself, or becomes one."""
    return path.suffix.lower() in (".urdf", XACRO)


def robot_of(path: Path, node: Node) -> Loaded:
    """The robot of what a robot file says.

    Args:
        path: The file, after which the robot is called.
        node: What it says.

    Raises:
        FileError: At the place of the first mistake.
    """
    said = _said(node)
    place = node.mapping["urdf"]
    urdf = place.folder / str(said["urdf"])
    if not urdf.is_file() or not is_urdf(urdf):
        raise FileError([place.problem(f"urdf: there is no URDF {urdf}; give its file")])
    return _made(path, said, node, urdf)


def _said(node: Node) -> dict[str, Any]:
    """Entries of a robot file, each checked."""
    sole: dict[str, Reader] = {**SOLE, "kind": partial(_choice, "sole: kind", KINDS)}
    keys: dict[str, Reader] = {
        "urdf": _text,
        "description": _text,
        "servos": lambda node: node,
        "mass": MASS,
        "add": _lumps,
        "posture": _posture,
        "legs": lambda node: read_mapping(
            "legs", node, {"left": _text, "right": _text}, required=("left", "right"),
            expected="expected {left: LINK, right: LINK}, the links of the feet",
        ),
        "sole": lambda node: read_mapping("sole", node, sole, expected="expected lengths in m"),
        "forward": partial(_choice, "forward", FORWARD),
    }  # fmt: skip
    if "mass" in node.mapping and "value" in node.mapping["mass"].mapping:
        node = node.replaced(mass=node.mapping["mass"].mapping["value"])
    return read_mapping("", node, keys, required=("urdf",), expected=EXPECTED)


def _text(node: Node) -> str:
    if not isinstance(node.value, str) or not node.value.strip():
        raise FileError([node.problem(f"found {node.found()}; expected a text")])
    return node.value


def _choice(name: str, allowed: tuple[str, ...], node: Node) -> str:
    if node.value not in allowed:
        listed = " or ".join(allowed)
        raise FileError([node.problem(f"{name}: found {node.found()}; allowed is {listed}")])
    return str(node.value)


def _lumps(node: Node) -> dict[str, Mapping[str, Any]]:
    """What the robot carries beside its links, by name."""
    keys: dict[str, Reader] = {
        "mass": LUMP_MASS,
        "at": _point,
        "link": _text,
    }
    return {
        name: read_mapping(
            f"add: {name}", lump, keys, required=("mass", "at"),
            expected="expected {mass: KG, at: [X, Y, Z], link: LINK}, m in the link's frame",
        )
        for name, lump in node.mapping.items()
    }  # fmt: skip


def _point(node: Node) -> tuple[float, ...]:
    if len(node.items) != 3:
        raise FileError([node.problem(f"found {node.found()}; expected [X, Y, Z] in m")])
    return tuple(check(PLACE, part) for part in node.items)


def _posture(node: Node) -> list[tuple[re.Pattern[str], float, Node]]:
    return [
        (_pattern(node.keys[key]), check(ANGLE, value), node.keys[key])
        for key, value in node.mapping.items()
    ]


def _pattern(key: Node) -> re.Pattern[str]:
    try:
        return re.compile(str(key.value))
    except re.error as error:
        message = f"{key.value!r} is no regular expression: {error}"
        raise FileError([key.problem(message)]) from error


def _made(path: Path, said: Mapping[str, Any], node: Node, urdf: Path) -> Loaded:
    """The robot of a URDF with what a file says beside it."""
    raw = read_urdf(_urdf_text(urdf), urdf)
    for name, lump in said.get("add", {}).items():
        raw = _with_lump(raw, name, lump, node.mapping["add"])
    named = said.get("legs")
    legs = find_legs(
        raw, urdf, feet=(named["left"], named["right"]) if named else None,
        forward=said.get("forward"),
    )  # fmt: skip
    bodies = mend(raw, legs, urdf)
    faults = list[MeshFault]()
    vertices = vertices_of_all(bodies, urdf, faults)
    servos = _Servos(bodies, legs, node.mapping.get("servos"), path)
    joints = [body.joint for body in bodies.bodies if body.joint is not None]
    posture = said.get("posture", [])
    _require_matches(posture, joints)
    overrides = Overrides(
        posture=partial(_wished, posture),
        servo=servos.name_of,
        sole={k: v for k, v in said.get("sole", {}).items() if k != "kind"},
    )
    try:
        found = reduced(bodies, legs, vertices, overrides)
    except WrongValue as error:
        place = node.mapping.get("urdf") or Node(file=urdf, value=None)
        raise FileError([place.problem(str(error))]) from error
    sources = {key: FROM_FILE for key in said.get("sole", {})}
    if "mass" in said:
        sources["mass"] = FROM_FILE
    cls = robot_class(
        path.stem, found, servos.own, sources, servos.sources,
        mass=said.get("mass"), kind=said.get("sole", {}).get("kind", "flat"),
    )  # fmt: skip
    meshes = {
        mesh
        for body in bodies.bodies
        for shape in body.shapes
        if shape.kind == "mesh" and (mesh := find_mesh(shape.mesh, urdf, []))
    }
    notes = (*bodies.notes, *sentences(faults), *found.notes, *servos.notes)
    return Loaded(
        cls=cls,
        digest=numbers_digest(found),
        bodies=bodies,
        legs=legs,
        found=found,
        notes=tuple(dict.fromkeys(notes)),
        unstated=tuple(servos.unstated),
        stated_by=servos.stated_by,
        urdf=urdf,
        files=_stamps([*dict.fromkeys((path, urdf, *_parts(urdf))), *sorted(meshes)]),
    )


def _urdf_text(path: Path) -> str:
    """Text of a URDF; a xacro is expanded by the package of that name."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        message = f"cannot be read: {error}"
        raise FileError([Problem(file=path, line=None, column=None, message=message)]) from error
    declared = _is_xacro(path) or "xmlns:xacro" in text
    if not declared or not ("<xacro:" in text or "${" in text or "$(" in text):
        return text  # many a URDF has only the namespace left
    try:
        import xacro
        from xacro import substitution_args
    except ImportError as error:
        message = (
            "this is xacro, no URDF yet; `pip install gaitlab[xacro]`, or write the URDF yourself: "
            f"xacro {path.name} > robot.urdf"
        )
        raise FileError([Problem(file=path, line=1, column=None, message=message)]) from error
    before = substitution_args._eval_find
    substitution_args._eval_find = partial(_package, path.parent.resolve())
    try:
        expanded: str = xacro.process_file(str(path)).toxml()
    except Exception as error:  # xacro raises many kinds of its own
        message = f"xacro cannot expand it: {error}"
        raise FileError([Problem(file=path, line=None, column=None, message=message)]) from error
    finally:
        substitution_args._eval_find = before
    return expanded


def _parts(urdf: Path) -> list[Path]:
    """Files that a xacro may include."""
    return sorted(islice(urdf.parent.rglob(f"*{XACRO}"), MOST_PARTS)) if _is_xacro(urdf) else []


def _is_xacro(path: Path) -> bool:
    return path.suffix.lower() == XACRO


def _package(folder: Path, name: str) -> str:
    """Folder of a ROS package, which is looked for around a file and not in an installed ROS."""
    near = (folder, *folder.parents[:NEAR])
    for place in near:
        if place.name == name or (place / name).is_dir():
            return str(place if place.name == name else place / name)
    return str(next((place for place in near if (place / "package.xml").is_file()), folder))


def _with_lump(robot: Bodies, name: str, lump: Mapping[str, Any], node: Node) -> Bodies:
    link = lump.get("link", robot.bodies[0].name)
    place = next((k for k, body in enumerate(robot.bodies) if link in body.links), None)
    if place is None:
        known = [each for body in robot.bodies for each in body.links]
        message = f"add: {name}: no link is called {link!r}{suggestion(link, known)}"
        raise FileError([node.problem(message)])
    return with_lump(robot, place, lump["mass"], np.array(lump["at"]))


def _require_matches(
    posture: list[tuple[re.Pattern[str], float, Node]], joints: list[BodyJoint]
) -> None:
    """Refuse an angle for a joint that there is not, or beyond its limits."""
    for pattern, angle, key in posture:
        matching = [joint for joint in joints if pattern.fullmatch(joint.name)]
        if not matching:
            known = suggestion(pattern.pattern, [joint.name for joint in joints])
            message = f"posture: no joint is called {pattern.pattern!r}{known}"
            raise FileError([key.problem(message)])
        for joint in matching:
            if not joint.lower <= angle <= joint.upper:
                message = (
                    f"posture: {joint.name} is to be held at {angle:g} rad, its limits are "
                    f"{joint.lower:g} to {joint.upper:g}"
                )
                raise FileError([key.problem(message)])


def _wished(posture: list[tuple[re.Pattern[str], float, Node]], name: str) -> float | None:
    return next((angle for pattern, angle, _ in posture if pattern.fullmatch(name)), None)


def _assumed(no_load_speed: float) -> dict[str, float]:
    """What neither a URDF nor two numbers say of a servo."""
    return {**ASSUMED, "position_gain": min(no_load_speed / FULL_DUTY, STIFFEST)}


class _Servos:
    """Which servo each joint has: the file's word, else the URDF's numbers, else an assumption.

    Attributes:
        own: Servos that are numbers, by name.
        unstated: Joints for which nobody states torque and speed.
        stated_by: Who states them, by the servo's name.
        sources: Where the numbers of servos that are no files come from, by name and parameter.
        notes: What a user should know of them.
    """

    def __init__(self, robot: Bodies, legs: Legs, node: Node | None, path: Path) -> None:
        self.own: dict[str, Servo] = {}
        self.unstated: list[str] = []
        self.stated_by: dict[str, Statement] = {}
        self.sources: dict[str, dict[str, str]] = {}
        self._joints = {b.joint.name: b.joint for b in robot.bodies if b.joint is not None}
        self._lifting = robot.mass * GRAVITY * sum(leg_lengths(robot, legs))
        self._torque = SERVO_TORQUE * self._lifting
        self._rules = [] if node is None else self._read(node, path)

    @property
    def notes(self) -> list[str]:
        """That torque and speed of some servos are assumed."""
        if not self.unstated:
            return []
        names = ", ".join(self.unstated[:3])
        more = f" and {len(self.unstated) - 3} more" if len(self.unstated) > 3 else ""
        stated = max(self._joints[name].effort for name in self.unstated)
        beyond = (
            f" (the file says {stated:g} N m, {stated / self._lifting:.0f} times what lifts the "
            "robot on a stretched leg)"
            if stated > PLAUSIBLE * self._lifting
            else ""
        )
        return [
            f"no servo is stated for {names}{more}{beyond}: {self._torque:.3g} N m and "
            f"{SERVO_SPEED:g} rad/s are assumed, half of what lifts the robot on a stretched leg; "
            "say which servos they are under `servos:` in the robot file"
        ]

    def name_of(self, joint: str) -> str:
        """Name of a joint's servo."""
        for pattern, name in self._rules:
            if pattern is None or pattern.fullmatch(joint):
                return name
        found = self._joints[joint]
        implausible = found.effort > PLAUSIBLE * self._lifting
        if implausible or without_servo(found, list(self._joints.values())):
            self.unstated.append(joint)
            return self._numbers("assumed", self._torque, SERVO_SPEED)
        return self._numbers("URDF", found.effort, found.velocity)

    def _numbers(self, who: Statement, torque: float, speed: float) -> str:
        name = f"{who.lower()}: {torque:.4g} N m, {speed:.4g} rad/s"
        self.stated_by[name] = who
        source = "read: the URDF" if who == "URDF" else UNSTATED
        self.sources[name] = {
            **dict.fromkeys(ASSUMED, ASSUMPTION),
            **{"position_gain": ASSUMPTION, "stall_torque": source, "no_load_speed": source},
        }
        limits = parameter_table(Servo)
        values = {"stall_torque": torque, "no_load_speed": speed, **_assumed(speed)}
        bounded = {
            key: min(max(value, limits[key].low or 0.0), limits[key].high or value)
            for key, value in values.items()
        }
        self.own[name] = Servo(**bounded)
        return name

    def _read(self, node: Node, path: Path) -> list[tuple[re.Pattern[str] | None, str]]:
        if isinstance(node.value, str):
            return [(None, self._named(node, "all", path))]
        if not node.mapping:
            message = (
                f"servos: found {node.found()}; expected a servo, or {{default: SERVO, "
                "'REGEX': SERVO}"
            )
            raise FileError([node.problem(message)])
        rules: list[tuple[re.Pattern[str] | None, str]] = []
        for key, value in node.mapping.items():
            pattern = None if key == DEFAULT else _pattern(node.keys[key])
            if pattern is not None and not any(map(pattern.fullmatch, self._joints)):
                message = f"servos: no joint is called {key!r}{suggestion(key, self._joints)}"
                raise FileError([node.keys[key].problem(message)])
            rules.append((pattern, self._named(value, key, path)))
        return sorted(rules, key=lambda rule: rule[0] is None)

    def _named(self, node: Node, key: str, path: Path) -> str:
        """A servo by its name or file, or by numbers of its own."""
        if isinstance(node.value, str):
            from gaitlab.plugins import locate

            try:
                found = locate("servo", node.value, node.folder)
            except GaitlabError as error:
                raise FileError([node.problem(f"servos: {error}")]) from error
            name = str(found) if is_file_name(node.value) else node.value
            self.stated_by[name] = "servo file"
            return name
        stated = node.mapping.get("no_load_speed", node)
        speed = stated.mapping.get("value", stated).value
        number = float(speed) if isinstance(speed, int | float) else 1.0  # else refused below
        assumed = {
            name: node.holding(Node(file=node.file, value=value))
            for name, value in _assumed(number).items()
            if name not in node.mapping
        }
        name = f"{plain(key)} of {path.stem}"
        self.stated_by[name] = "robot file"
        self.sources[name] = dict.fromkeys(assumed, ASSUMPTION) | {
            key: str(value.mapping["source"].value) if "source" in value.mapping else FROM_FILE
            for key, value in node.mapping.items()
        }
        self.own[name] = build(Servo, node.replaced(**assumed), skip=())
        return name
