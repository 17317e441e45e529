"""Robot, gait, grounds and servos that an experiment starts from, and how a path changes them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar, cast

from gaitlab.body import Robot
from gaitlab.documents import Node, build, check, checked, parameter_table
from gaitlab.errors import FileError, Problem, UnknownName, WrongValue
from gaitlab.experiment.schema import Sections
from gaitlab.motion import Gait
from gaitlab.parameters import Parameter, get_path
from gaitlab.plugins import is_file_name, label, load_class, locate, names, suggestion
from gaitlab.servos import Servo
from gaitlab.servos.files import load_servo
from gaitlab.settings import EngineSettings, Horizon, Spread
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import Plugin, plugin

T = TypeVar("T")
Value = bool | int | float | str
GROUPS = ("gait", "surface", "servo", "robot", "engine", "horizon", "spread")
SERVO_TYPE = Parameter(
    name="type",
    type=str,
    default="",
    unit="-",
    low=None,
    high=None,
    doc="name of a servo for every joint; the robot's own by default",
    source="",
)


@dataclass(frozen=True, kw_only=True)
class Parts:
    """What a trial is made of, before anything is varied.

    Attributes:
        robot: The robot.
        robot_code: Its code.
        gait: The gait.
        gait_code: Its code.
        surfaces: Grounds by what the experiment calls them, in the order of the file.
        servo: Settings for every servo, by parameter; `type` replaces the robot's own choice.
        engine: How the engine integrates.
        horizon: When a trial ends.
        spread: How much replicates differ.
    """

    robot: Robot
    robot_code: Plugin
    gait: Gait
    gait_code: Plugin
    surfaces: Mapping[str, Surface]
    servo: Mapping[str, Value]
    engine: EngineSettings
    horizon: Horizon
    spread: Spread

    def parameter(self, path: str) -> Parameter:
        """What is known of a dotted path.

        Raises:
            WrongValue: If there is no such path; names the nearest, and a surface that lacks it.
        """
        group, _, rest = path.partition(".")
        if group not in GROUPS or not rest:
            starts = ", ".join(f"{name}." for name in GROUPS)
            raise WrongValue(f"{path!r} is no dotted path; it starts with one of: {starts}")
        if group == "surface":
            return self._of_every_surface(path, rest)
        table = self._table(group)
        if rest not in table:
            known = [f"{group}.{name}" for name in table]
            raise WrongValue(f"{path!r} is no parameter{suggestion(path, known)}")
        return table[rest]

    def _table(self, group: str) -> Mapping[str, Parameter]:
        if group == "servo":
            return {"type": SERVO_TYPE, **parameter_table(Servo)}
        return parameter_table(type(getattr(self, group)))

    def _of_every_surface(self, path: str, rest: str) -> Parameter:
        for name, surface in self.surfaces.items():
            table = parameter_table(type(surface))
            if rest not in table:
                known = [f"surface.{key}" for key in table]
                raise WrongValue(
                    f"{path!r} is no parameter of {name}, a surface of type {surface.type!r}"
                    f"{suggestion(path, known)}"
                )
        return parameter_table(type(next(iter(self.surfaces.values()))))[rest]

    def check(self, path: str, node: Node) -> Value:
        """Value of a dotted path from a node.

        Raises:
            FileError: If it has the wrong type or lies outside the range.
        """
        value: Value = check(dataclasses.replace(self.parameter(path), name=path), node)
        return servo_type(node, str(value)) if path == "servo.type" else value

    def try_out(self, group: str, changes: Mapping[str, Value]) -> None:
        """Make the part that changes of full dotted paths ask for, and forget it.

        Raises:
            WrongValue, ValueError: If the part itself refuses the combination.
        """
        inner = {path.partition(".")[2]: value for path, value in changes.items()}
        if group == "servo":
            self.servos(inner)
        elif group == "surface":
            for surface in self.surfaces.values():
                changed(surface, inner)
        else:
            changed(getattr(self, group), inner)

    def base_values(self, path: str) -> list[Value]:
        """Values of a dotted path before it is varied; several if surfaces or servos differ."""
        group, _, rest = path.partition(".")
        if path == "servo.type":
            found = [self.servo.get("type", joint.servo) for joint in self.robot.tree.joints]
        elif group == "servo":
            found = [get_path(servo, rest) for servo in self.servos({})]
        elif group == "surface":
            found = [get_path(surface, rest) for surface in self.surfaces.values()]
        else:
            found = [get_path(getattr(self, group), rest)]
        return list(dict.fromkeys(found))

    def servos(self, changes: Mapping[str, Value], robot: Robot | None = None) -> tuple[Servo, ...]:
        """One servo a joint in the order of the tree, with the experiment's and other settings."""
        settings = {**self.servo, **changes}
        chosen = settings.pop("type", None)
        joints = (robot or self.robot).tree.joints
        wanted = [str(chosen or joint.servo) for joint in joints]
        ready = {name: self._servo(name, settings) for name in dict.fromkeys(wanted)}
        return tuple(ready[name] for name in wanted)

    def _servo(self, name: str, settings: Mapping[str, Value]) -> Servo:
        return changed(load_servo(name, Path(self.robot_code.name).parent), settings)


def changed(owner: T, changes: Mapping[str, Value]) -> T:
    """Copy of a nested frozen dataclass with several dotted paths set at once."""
    groups: dict[str, Any] = {}
    for path, value in changes.items():
        head, _, rest = path.partition(".")
        if rest:
            groups.setdefault(head, {})[rest] = value
        else:
            groups[head] = value
    fresh = {
        head: changed(getattr(owner, head), value) if isinstance(value, dict) else value
        for head, value in groups.items()
    }
    return cast(T, dataclasses.replace(cast(Any, owner), **fresh))


def read_parts(sections: Sections, varied: Mapping[str, Node]) -> Parts:
    """Parts of an experiment; everything wrong in any of them is reported together.

    Args:
        sections: The file's sections.
        varied: First value of every varied path, for parameters that only the grid gives.

    Raises:
        FileError: All mistakes.
    """
    problems: list[Problem] = []
    robot = _collected(problems, lambda: _plugged("robot", sections.robot, varied))
    gait = _collected(problems, lambda: _plugged("gait", sections.gait, varied))
    surfaces = _collected(problems, lambda: read_surfaces(sections))
    servo = _collected(problems, lambda: read_servo(sections.servo))
    if robot is None or gait is None or surfaces is None or servo is None:
        raise FileError(problems)
    parts = Parts(
        robot=robot[0],
        robot_code=robot[1],
        gait=gait[0],
        gait_code=gait[1],
        surfaces=surfaces,
        servo=servo,
        engine=sections.engine,
        horizon=sections.horizon,
        spread=sections.spread,
    )
    checked(sections.servo or sections.robot, lambda: parts.servos({}))
    return parts


def _collected(problems: list[Problem], read: Callable[[], T]) -> T | None:
    try:
        return read()
    except FileError as error:
        problems += error.problems
        return None


def _plugged(
    kind: Literal["gait", "robot"], node: Node, varied: Mapping[str, Node]
) -> tuple[Any, Plugin]:
    name = _type_of(kind, node)
    code = checked(name, lambda: plugin(kind, str(name.value), name.folder))
    cls = checked(name, lambda: load_class(kind, str(name.value), name.folder))
    return build(cls, _completed(cls, kind, node, varied)), code


def _type_of(kind: Literal["gait", "robot", "servo"], node: Node) -> Node:
    name = node.mapping.get("type")
    if name is None:
        known = ", ".join(names(kind))
        message = f"{kind}: found {node.found()}; expected a name or `type:` with one of: {known}"
        raise FileError([node.problem(message)])
    if not isinstance(name.value, str):
        message = f"{kind}: found {name.found()}{suggestion('', names(kind))}"
        raise FileError([name.problem(message)])
    return name


def _completed(cls: type, kind: str, node: Node, varied: Mapping[str, Node]) -> Node:
    """Required parameters that only the grid gives start at the first of its values."""
    lacking = {
        path: varied[f"{kind}.{path}"]
        for path, item in parameter_table(cls).items()
        if item.default is dataclasses.MISSING and f"{kind}.{path}" in varied
    }
    return node.replaced(**{p: n for p, n in lacking.items() if p not in node.mapping})


def read_surfaces(sections: Sections) -> dict[str, Surface]:
    """Surfaces by label, each with the section `surface` applied.

    Raises:
        FileError: All mistakes.
    """
    problems: list[Problem] = []
    found: dict[str, Surface] = {}
    for node in _listed(sections.surfaces):
        surface = _collected(problems, lambda node=node: _surface(node))  # type: ignore[misc]
        if label(str(node.value)) in found:
            message = f"surfaces: {label(str(node.value))!r} is listed twice; keep one of them"
            problems.append(node.problem(message))
        if surface is not None:
            found[label(str(node.value))] = surface
    if problems:
        raise FileError(problems)
    return _with_settings(found, sections.surface)


def _listed(node: Node) -> tuple[Node, ...]:
    if not node.items:
        what = "an empty list" if node.value == () else node.found()
        known = ", ".join(names("surface"))
        message = f"surfaces: found {what}; expected a list of names or files. Known: {known}"
        raise FileError([node.problem(message)])
    return node.items


def _surface(node: Node) -> Surface:
    if not isinstance(node.value, str):
        known = ", ".join(names("surface"))
        message = f"surfaces: found {node.found()}; expected a name or a file. Known: {known}"
        raise FileError([node.problem(message)])
    name = node.value
    return checked(node, lambda: load_surface(name, node.folder))


def _with_settings(surfaces: dict[str, Surface], node: Node | None) -> dict[str, Surface]:
    if node is None:
        return surfaces
    if not node.mapping:
        message = f"surface: found {node.found()}; expected a mapping of settings for every surface"
        raise FileError([node.problem(message)])
    problems: list[Problem] = []
    for key, value in node.mapping.items():
        for name, surface in surfaces.items():
            try:
                surfaces[name] = _with_setting(name, surface, key, value)
            except FileError as error:
                problems += error.problems
            except WrongValue as error:
                problems.append(node.keys[key].problem(str(error)))
    if problems:
        raise FileError(list(dict.fromkeys(problems)))
    return surfaces


def _with_setting(name: str, surface: Surface, key: str, node: Node) -> Surface:
    table = parameter_table(type(surface))
    if key not in table:
        raise WrongValue(
            f"surface: {key!r} is no parameter of {name}, a surface of type {surface.type!r}"
            f"{suggestion(key, table)}"
        )
    value = check(table[key], node)
    return checked(node, lambda: changed(surface, {key: value}))


def read_servo(node: Node | None) -> dict[str, Value]:
    """Settings of the section `servo`, checked.

    Raises:
        FileError: All mistakes.
    """
    if node is None:
        return {}
    if not isinstance(node.value, Mapping):
        message = f"servo: found {node.found()}; expected a name, or a mapping of settings"
        raise FileError([node.problem(message)])
    problems: list[Problem] = []
    found: dict[str, Value] = {}
    for key, value in node.mapping.items():
        try:
            found[key] = _servo_setting(key, value)
        except FileError as error:
            problems += error.problems
        except UnknownName as error:
            problems.append(node.keys[key].problem(str(error)))
    if problems:
        raise FileError(problems)
    return found


def _servo_setting(key: str, node: Node) -> Value:
    table = {"type": SERVO_TYPE, **parameter_table(Servo)}
    if key not in table:
        raise UnknownName(f"servo: unknown key {key!r}{suggestion(key, table)}")
    value: Value = check(dataclasses.replace(table[key], name=f"servo.{key}"), node)
    return servo_type(node, str(value)) if key == "type" else value


def servo_type(node: Node, name: str) -> str:
    """A servo's name, or the absolute file of a user's own, once it has been read.

    Raises:
        FileError: If there is none or it is wrong.
    """
    checked(node, lambda: load_servo(name, node.folder))
    return str(locate("servo", name, node.folder)) if is_file_name(name) else name
