"""Motion files: every number checked, every mistake at its line and column."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

from gaitlab.documents import Node, build, check, checked, load
from gaitlab.errors import FileError, Problem
from gaitlab.motions.motion import Keyframe, Motion, Point
from gaitlab.parameters import Parameter, parameter
from gaitlab.plugins import locate, suggestion

T = TypeVar("T")
Feet = tuple[Point, Point]
LEVEL = 1e-9  # rad; a trunk that leans less is level


@dataclass(frozen=True, kw_only=True)
class FeetSection:
    """Where both soles are."""

    left: Node = parameter(unit="-", doc="[x, y, z] of the left sole in the hip frame, in m")
    right: Node = parameter(unit="-", doc="[x, y, z] of the right sole in the hip frame, in m")
    trunk_pitch: float = parameter(
        0.0, unit="rad", low=-0.8, high=0.8, doc="lean of the trunk over the soles"
    )


@dataclass(frozen=True, kw_only=True)
class FrameSection:
    """One entry of `frames`."""

    name: str = parameter(unit="-", doc="what the frame is called")
    move_time: float = parameter(unit="s", low=0.02, high=60.0, doc="on the way to it")
    pause_time: float = parameter(0.0, unit="s", low=0.0, high=60.0, doc="rest in it")
    feet: Node | None = parameter(None, unit="-", doc="both soles, and the lean of the trunk")
    joints: Node | None = parameter(None, unit="-", doc="angles by joint, in rad")
    mirror: str = parameter("", unit="-", doc="an earlier frame, left and right exchanged")


@dataclass(frozen=True, kw_only=True)
class MotionSection:
    """Keys of a motion file."""

    description: str = parameter("", unit="-", doc="what it is and who made it")
    tempo: float = parameter(1.0, unit="-", low=0.1, high=10.0, doc="speed of play")
    frames: Node = parameter(unit="-", doc="list of keyframes")


def load_motion(name: str, relative_to: Path | None = None) -> Motion:
    """Motion of a name or a file, every number checked.

    Args:
        name: Name of a file in `motions/`, or a .yaml file of the user's own.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If there is no such motion.
        FileError: Everything that is wrong in its file, with line and column.
    """
    path = locate("motion", name, relative_to)
    sections = build(MotionSection, load(path), skip=())
    return Motion(
        file=path,
        description=sections.description,
        tempo=sections.tempo,
        frames=_frames(sections.frames),
    )


def _frames(node: Node) -> tuple[Keyframe, ...]:
    if len(node.items) < 2:
        message = f"frames: found {node.found()}; expected a list of at least two keyframes"
        raise FileError([node.problem(message)])
    sections = _all(partial(build, FrameSection, item, skip=()) for item in node.items)
    frames = [_first(node.items[0], sections[0])]
    problems: list[Problem] = []
    for item, section in zip(node.items[1:], sections[1:], strict=True):
        try:
            frames.append(_next(item, section, frames))
        except FileError as error:
            problems += error.problems
    if problems:
        raise FileError(problems)
    return tuple(frames)


def _all(readers: Iterable[Callable[[], T]]) -> list[T]:
    """What all readers give.

    Raises:
        FileError: The mistakes of all of them.
    """
    found: list[T] = []
    problems: list[Problem] = []
    for read in readers:
        try:
            found.append(read())
        except FileError as error:
            problems += error.problems
    if problems:
        raise FileError(problems)
    return found


def _first(node: Node, section: FrameSection) -> Keyframe:
    """The first keyframe, in which the robot starts: both feet under a level trunk."""
    if section.feet is None or section.mirror:
        message = "the first frame is where the robot starts; give it `feet: {left:, right:}`"
        raise FileError([node.problem(message)])
    feet, lean = _feet(section.feet)
    if abs(lean) > LEVEL:
        place = section.feet.mapping["trunk_pitch"]
        message = f"the robot starts with a level trunk; found {place.found()} rad, allowed is 0"
        raise FileError([place.problem(message)])
    return _keyframe(node, section, feet, lean, _angles(section.joints))


def _next(node: Node, section: FrameSection, before: Sequence[Keyframe]) -> Keyframe:
    """A keyframe on top of those before it."""
    if any(frame.name == section.name for frame in before):
        place = node.mapping["name"]
        raise FileError([place.problem(f"a frame {section.name!r} is there already; rename it")])
    if section.mirror:
        return _mirror(node, section, before)
    joints, last = _angles(section.joints), before[-1]
    late = [_late(section, name, last) for name in joints if name not in last.joints]
    if late:
        raise FileError(late)
    held = last.feet, last.trunk_pitch
    feet, lean = held if section.feet is None else _feet(section.feet)
    return _keyframe(node, section, feet, lean, {**last.joints, **joints})


def _keyframe(
    node: Node, section: FrameSection, feet: Feet, lean: float, joints: Mapping[str, float]
) -> Keyframe:
    return Keyframe(
        name=section.name,
        move_time=section.move_time,
        pause_time=section.pause_time,
        feet=feet,
        trunk_pitch=lean,
        joints=joints,
        node=node,
        places={} if section.joints is None else section.joints.mapping,
    )


def _mirror(node: Node, section: FrameSection, before: Sequence[Keyframe]) -> Keyframe:
    place = node.mapping["mirror"]
    if section.feet is not None or section.joints is not None:
        message = "a mirrored frame has the pose of another; leave out `feet` and `joints`"
        raise FileError([place.problem(message)])
    found = {frame.name: frame for frame in before}
    if section.mirror not in found:
        message = f"mirror: no earlier frame is called {section.mirror!r}"
        raise FileError([place.problem(message + suggestion(section.mirror, found))])
    image = checked(place, found[section.mirror].mirrored)
    return _keyframe(node, section, image.feet, image.trunk_pitch, image.joints)


def _feet(node: Node) -> tuple[Feet, float]:
    """Both soles, in [m], and the lean, in [rad]."""
    section = build(FeetSection, node, skip=())
    left, right = _all(partial(_point, side) for side in (section.left, section.right))
    return (left, right), section.trunk_pitch


def _point(node: Node) -> Point:
    if len(node.items) != 3:
        message = f"found {node.found()} of {len(node.items)}; expected three numbers, [x, y, z]"
        raise FileError([node.problem(message)])
    x, y, z = _all(partial(check, _number("a coordinate", "m", 1.0), item) for item in node.items)
    return float(x), float(y), float(z)


def _late(section: FrameSection, name: str, first: Keyframe) -> Problem:
    """A joint that a frame moves and the first one does not set."""
    assert section.joints is not None  # it has named the joint
    return section.joints.keys[name].problem(
        f"joint {name!r} is moved here but not set in the first frame, so it has no start; set it "
        f"there or correct the name{suggestion(name, first.joints)}"
    )


def _angles(node: Node | None) -> dict[str, float]:
    """Angles by joint."""
    if node is None:
        return {}
    if not node.mapping:
        message = f"joints: found {node.found()}; expected lines of the form `head_pan: 0.3`"
        raise FileError([node.problem(message)])
    values = _all(
        partial(check, _number(name, "rad", 3.2), value) for name, value in node.mapping.items()
    )
    return dict(zip(node.mapping, values, strict=True))


def _number(name: str, unit: str, largest: float) -> Parameter:
    """What a number of a motion may be."""
    return Parameter(
        name=name,
        type=float,
        default=0.0,
        unit=unit,
        low=-largest,
        high=largest,
        doc="in the hip frame" if unit == "m" else "angle of the joint",
        source="",
    )
