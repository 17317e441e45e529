"""What a policy is fed and what its output means: a YAML file beside the network, or a layout.

    layout: unitree_rl_gym            what the keys below are where they are left out
    rate: 50.0                        Hz
    observations:                     in the order of the input
      - {term: angular_velocity, scale: 0.25}
      - projected_gravity             a name alone has the scale 1
    history: 1                        observations in the input, the oldest first
    joints: [left_hip_pitch, ...]     in the order of the output; all with a servo, as the robot has
    default_pose: {"*_knee": 0.4}     rad; others as the robot stands
    action_scale: 0.25                target = default pose + scale action
    kp: {"*_hip_*": 100.0}            N m/rad; with kd, else the robot's servos are as they are
    kd: 2.0                           N m s/rad

A value per joint is one number, a list in the order of `joints`, or numbers by name, where * stands
for any letters. What an exporter wrote into the ONNX file, as that of mjlab does (`joint_names`,
`default_joint_pos`, `joint_stiffness`, `joint_damping`, `action_scale`), counts before the layout
and after the declaration.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gaitlab.documents import Node, build, check, load, merged, plain
from gaitlab.errors import FileError, Problem, WrongValue
from gaitlab.model import Robot
from gaitlab.model.forward import feet_of_joints, standing_joints
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import Parameter, canonical_json, parameter, remembered
from gaitlab.plugins import is_file_name, suggestion

LAYOUTS = Path(__file__).parent / "layouts"
SUFFIX = ".yaml"
TERMS = {  # numbers in each; None for one a joint
    "angular_velocity": 3,
    "projected_gravity": 3,
    "roll_pitch": 2,
    "command": 3,
    "joint_positions": None,
    "joint_velocities": None,
    "last_action": None,
    "phase": 2,
}
EXPORTED = {  # what exporters call it
    "joints": "joint_names",
    "default_pose": "default_joint_pos",
    "kp": "joint_stiffness",
    "kd": "joint_damping",
    "action_scale": "action_scale",
}
ANGLE = Parameter(name="default_pose", type=float, unit="rad", low=-6.3, high=6.3, doc="angle")
SCALE = Parameter(
    name="action_scale", type=float, unit="-", low=-1e4, high=1e4, doc="rad a unit of output"
)
FACTOR = Parameter(name="scale", type=float, unit="-", low=-1e4, high=1e4, doc="factor")
STIFFNESS = Parameter(name="kp", type=float, unit="N m/rad", low=0.1, high=1e4, doc="stiffness")
DAMPING = Parameter(name="kd", type=float, unit="N m s/rad", low=0.01, high=1e3, doc="damping")


@dataclass(frozen=True, kw_only=True)
class ObservationSection:
    """One entry of `observations`."""

    term: str = parameter(unit="-", doc="what is observed")
    scale: Node | None = parameter(None, unit="-", doc="factor, or one for each number")


@dataclass(frozen=True, kw_only=True)
class DeclarationSection:
    """Keys of a declaration."""

    layout: str = parameter("", unit="-", doc="name of a published layout")
    rate: float = parameter(unit="Hz", low=1.0, high=1000.0, doc="how often it acts")
    observations: Node = parameter(unit="-", doc="list of what it is fed")
    history: int = parameter(1, unit="-", low=1, high=100, doc="observations in the input")
    history_order: Literal["frames", "terms"] = parameter(
        "frames", unit="-", doc="whole observations after each other, or each term's own history"
    )
    observation_clip: float = parameter(
        100.0, unit="-", low=0.0, high=1e6, doc="largest number of the input"
    )
    action_clip: float = parameter(
        100.0, unit="-", low=0.0, high=1e6, doc="largest number of the output"
    )
    action_scale: Node = parameter(unit="-", doc="rad of target a unit of output")
    joints: Node | None = parameter(None, unit="-", doc="names in the order of the output")
    default_pose: Node | None = parameter(None, unit="-", doc="angles by joint, in rad")
    kp: Node | None = parameter(None, unit="-", doc="stiffness by joint, in N m/rad")
    kd: Node | None = parameter(None, unit="-", doc="damping by joint, in N m s/rad")
    delay: float = parameter(
        0.0, unit="s", low=0.0, high=0.5, doc="from an observation to what is sent for it"
    )
    period: float = parameter(
        0.8, unit="s", low=0.05, high=10.0, doc="of the phase, and what counts as a cycle"
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Declaration:
    """A declaration as it stands in its file, before a robot is known.

    Attributes:
        place: The file or the layout.
        node: All of it.
        keys: Its entries.
        digest: SHA-256 of its numbers. 64 hex digits.
    """

    place: Path
    node: Node
    keys: DeclarationSection
    digest: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Wiring:
    """A declaration on a robot: which numbers go in, and what those that come out are.

    Attributes:
        rate: How often it acts, in [Hz].
        terms: Names of what it is fed, in order.
        scale: Factor of each number of one observation. Shape (numbers,).
        history: Observations in the input.
        by_term: Whether each term's history stands together.
        observation_clip: Largest number of the input; 0 for none.
        action_clip: Largest number of the output, likewise.
        columns: Joints of the output in the robot's tree. Shape (m,).
        pose: All joints of the robot at output 0, in [rad]. Shape (joints,).
        standing: The feet in that pose, at one instant.
        action_scale: Target over output, in [rad]. Shape (m,).
        gains: kp [N m/rad] and kd [N m s/rad] of joints by name; empty for the robot's own servos.
        delay: From an observation to what is sent for it, in [s].
        period: Of the phase, in [s].
    """

    rate: float
    terms: Sequence[str]
    scale: np.ndarray
    history: int
    by_term: bool
    observation_clip: float
    action_clip: float
    columns: np.ndarray
    pose: np.ndarray
    standing: FeetPoses
    action_scale: np.ndarray
    gains: Mapping[str, tuple[float, float]]
    delay: float
    period: float

    @property
    def inputs(self) -> int:
        """Numbers in the input."""
        return self.history * len(self.scale)

    @property
    def told(self) -> str:
        """What the input is made of, for a message."""
        sizes = [f"{term} {TERMS[term] or len(self.columns)}" for term in self.terms]
        times = f", {self.history} times" if self.history > 1 else ""
        return f"{' + '.join(sizes)}{times}"


def layouts() -> list[str]:
    """Names of the published layouts."""
    return sorted(path.stem for path in LAYOUTS.glob(f"*{SUFFIX}"))


def load_declaration(name: str, network: Path) -> Declaration:
    """A declaration, every key checked.

    Args:
        name: A layout, or a .yaml file; empty for the one beside the network.
        network: The .onnx file.

    Raises:
        FileError: Everything that is wrong in it.
        WrongValue: If there is none.
    """
    if name and not is_file_name(name):
        path = _layout(name)
    else:
        path = Path(name) if name else network.with_suffix(SUFFIX)
        if not path.is_file():
            known = " or ".join(f"`declaration: {layout}`" for layout in layouts())
            raise WrongValue(
                f"{path} is not there, which would say what {network.name} is fed; write it, "
                f"`layout: isaac_lab` may be all of it, or say {known}"
            )
    status = path.stat()
    return _read(path, status.st_mtime_ns, status.st_size)


def _layout(name: str) -> Path:
    if name not in layouts():
        raise WrongValue(
            f"no layout of policies is called {name!r}{suggestion(name, layouts())}; a file of "
            f"your own is written with its suffix, ./{name[:40]}{SUFFIX}"
        )
    return LAYOUTS / f"{name}{SUFFIX}"


@lru_cache(maxsize=64)
def _read(path: Path, *_: int) -> Declaration:
    node = load(path)
    layout = node.mapping.get("layout")
    if layout is not None:
        if not isinstance(layout.value, str) or layout.value not in layouts():
            known = suggestion(str(layout.value), layouts())
            raise FileError([layout.problem(f"layout: found {layout.found()}{known}")])
        node = merged(load(_layout(layout.value)), node)
    keys = build(DeclarationSection, node, skip=())
    said = {name: plain(value) for name, value in node.mapping.items() if name != "layout"}
    digest = hashlib.sha256(canonical_json(said).encode()).hexdigest()
    return Declaration(place=path, node=node, keys=keys, digest=digest)


def wired(found: Declaration, robot: Robot, metadata: Mapping[str, str]) -> Wiring:
    """A declaration on a robot.

    Args:
        found: The declaration.
        robot: The robot.
        metadata: What the exporter wrote beside the network.

    Raises:
        FileError: Everything in it that the robot lacks or that is of another size.
    """
    return _wired(found, robot, tuple(sorted(metadata.items())))


@remembered
def _wired(found: Declaration, robot: Robot, exported: tuple[tuple[str, str], ...]) -> Wiring:
    keys = _with_exported(found, dict(exported))
    joints = robot.tree.joints
    names = _joint_names(found, keys, robot)
    columns = np.array([[j.name for j in joints].index(name) for name in names])
    problems: list[Problem] = []

    def values(node: Node | None, item: Parameter, start: Sequence[float | None]) -> np.ndarray:
        try:
            return _per_joint(node, item, names, start)
        except FileError as error:
            problems.extend(error.problems)
            return np.ones(len(names))

    pose = _standing(robot)
    lacking: list[float | None] = [None] * len(names)
    pose[columns] = values(keys.default_pose, ANGLE, pose[columns].tolist())
    action_scale = values(keys.action_scale, SCALE, lacking)
    gains = {}
    if keys.kp is not None and keys.kd is not None:
        kp, kd = values(keys.kp, STIFFNESS, lacking), values(keys.kd, DAMPING, lacking)
        gains = dict(zip(names, zip(kp.tolist(), kd.tolist(), strict=True), strict=True))
    elif keys.kp is not None or keys.kd is not None:
        node = keys.kp or keys.kd or found.node
        problems.append(node.problem("kp and kd come together; add the other one"))
    for column in columns:
        joint, angle = joints[column], pose[column]
        if not joint.lower - 1e-6 <= angle <= joint.upper + 1e-6:
            problems.append(
                (keys.default_pose or found.node).problem(
                    f"default_pose: {joint.name} is {angle:.4f} rad; its limits are "
                    f"{joint.lower:.4f} and {joint.upper:.4f}"
                )
            )
    try:
        terms, scale = _observations(keys.observations, len(names))
    except FileError as error:
        raise FileError([*problems, *error.problems]) from error
    if problems:
        raise FileError(problems)
    return Wiring(
        rate=keys.rate,
        terms=terms,
        scale=scale,
        history=keys.history,
        by_term=keys.history_order == "terms",
        observation_clip=keys.observation_clip,
        action_clip=keys.action_clip,
        columns=columns,
        pose=pose,
        standing=feet_of_joints(robot, pose[None]),
        action_scale=action_scale,
        gains=gains,
        delay=keys.delay,
        period=keys.period,
    )


def _with_exported(found: Declaration, metadata: Mapping[str, str]) -> DeclarationSection:
    """The keys, and where the file itself does not set them, what the exporter wrote."""
    own = load(found.place).mapping if found.place.parent != LAYOUTS else {}
    taken: dict[str, Any] = {}
    for key, title in EXPORTED.items():
        if key in own or title not in metadata:
            continue
        words = [word.strip() for word in metadata[title].split(",")]
        nodes = [
            Node(file=found.node.file, value=word if key == "joints" else _number(word))
            for word in words
        ]
        taken[key] = Node(
            file=found.node.file, value=nodes[0].value if len(nodes) == 1 else tuple(nodes)
        )
    return replace(found.keys, **taken)


def _number(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word


def _standing(robot: Robot) -> np.ndarray:
    try:
        return np.array(standing_joints(robot))
    except Exception:  # any robot of a team's own, whose legs may not bend as ours do
        return np.zeros(len(robot.tree.joints))


def _joint_names(found: Declaration, keys: DeclarationSection, robot: Robot) -> list[str]:
    """Joints of the output, in its order.

    Raises:
        FileError: If the robot lacks one, or one is named twice.
    """
    driven = [joint.name for joint in robot.tree.joints if joint.servo is not None]
    if keys.joints is None:
        return driven
    if not keys.joints.items:
        message = f"joints: found {keys.joints.found()}; expected a list of names"
        raise FileError([keys.joints.problem(message)])
    every = [joint.name for joint in robot.tree.joints]
    names = [str(node.value) for node in keys.joints.items]
    problems = []
    for place, (node, name) in enumerate(zip(keys.joints.items, names, strict=True)):
        if name not in every:
            message = f"the robot {robot.name!r} has no joint {name!r}{suggestion(name, every)}"
        elif name not in driven:
            message = f"{name} has no servo in the robot {robot.name!r}"
        elif name in names[:place]:
            message = f"{name} stands twice"
        else:
            continue
        problems.append(node.problem(f"joints: {message}"))
    if problems:
        raise FileError(problems)
    return names


def _per_joint(
    node: Node | None, item: Parameter, names: Sequence[str], start: Sequence[float | None]
) -> np.ndarray:
    """A number for each joint. Shape (joints,).

    Raises:
        FileError: If one is missing, wrong, or for no joint.
    """
    if node is None:
        return np.array(start, dtype=float)
    if node.items:
        if len(node.items) != len(names):
            message = f"{item.name}: {len(node.items)} numbers for {len(names)} joints"
            raise FileError([node.problem(message)])
        return np.array([check(item, one) for one in node.items], dtype=float)
    if not node.mapping:
        return np.full(len(names), check(item, node), dtype=float)
    values, problems = list(start), []
    for pattern, one in node.mapping.items():
        meant = [k for k, name in enumerate(names) if fnmatchcase(name, pattern)]
        if not meant:
            message = f"{item.name}: no joint is called {pattern!r}{suggestion(pattern, names)}"
            problems.append(node.keys[pattern].problem(message))
        try:
            value = float(check(item, one))
        except FileError as error:
            problems += error.problems
            continue
        for k in meant:
            values[k] = value
    lacking = [name for name, value in zip(names, values, strict=True) if value is None]
    if lacking and not problems:
        problems.append(node.problem(f"{item.name}: {', '.join(lacking)} is missing"))
    if problems:
        raise FileError(problems)
    return np.array(values, dtype=float)


def _observations(node: Node, joints: int) -> tuple[list[str], np.ndarray]:
    """Terms, and the factor of each number. Shape (numbers,).

    Raises:
        FileError: Everything that is wrong in them.
    """
    if not node.items:
        known = ", ".join(TERMS)
        raise FileError([node.problem(f"observations: found {node.found()}; a list of: {known}")])
    terms, scales, problems = [], [], []
    for entry in node.items:
        named = {"term": entry} if isinstance(entry.value, str) else entry.mapping
        try:
            section = build(ObservationSection, replace(entry, value=named), skip=())
        except FileError as error:
            problems += error.problems
            continue
        if section.term not in TERMS:
            message = f"observations: nothing is called {section.term!r}"
            problems.append(entry.problem(f"{message}{suggestion(section.term, TERMS)}"))
            continue
        size = TERMS[section.term] or joints
        parts = (section.scale.items or (section.scale,) * size) if section.scale else ()
        if parts and len(parts) != size:
            message = f"observations: {section.term} has {size} numbers and {len(parts)} scales"
            problems.append(entry.problem(message))
            continue
        try:
            scales += [check(FACTOR, part) for part in parts] or [1.0] * size
        except FileError as error:
            problems += error.problems
        terms.append(section.term)
    if problems:
        raise FileError(problems)
    return terms, np.array(scales, dtype=float)


def require_fitting(wiring: Wiring, network: Path, inputs: int | None, outputs: int | None) -> None:
    """Refuse a network whose input or output is of another size than declared.

    Raises:
        WrongValue: Says both sizes and what the declared one is made of.
    """
    if inputs is not None and inputs != wiring.inputs:
        raise WrongValue(
            f"{network.name} takes {inputs} numbers, declared are {wiring.inputs}: {wiring.told}"
        )
    if outputs is not None and outputs != len(wiring.columns):
        raise WrongValue(
            f"{network.name} gives {outputs} numbers, declared are {len(wiring.columns)} joints"
        )


def require_numbers(found: np.ndarray, joints: Sequence[str], when: str) -> None:
    """Refuse what is no number: nothing can be sent for it.

    Raises:
        WrongValue: Names the joint and the instant.
    """
    if not isfinite(float(found.sum())):
        wrong = np.flatnonzero(~np.isfinite(found))
        if len(wrong):
            place = int(wrong[0])
            raise WrongValue(f"the policy gave {found[place]} for {joints[place]} {when}")
