"""The sections of an experiment file put together to robot, gait, grounds and servos."""

from __future__ import annotations

import dataclasses
from collections.abc import Container, Mapping
from pathlib import Path
from typing import Any, Literal

from gaitlab.documents import Node, build, check, checked, collected
from gaitlab.errors import FileError, GaitlabError, Problem, UnknownName
from gaitlab.experiment.parts import (
    NO_BALANCE,
    SERVO_TYPE,
    Parts,
    Value,
    changed,
    servo_type,
    try_out,
)
from gaitlab.experiment.schema import Sections
from gaitlab.metrics import take_in
from gaitlab.model.clearance import require_own_space
from gaitlab.model.commands import require_playable
from gaitlab.model.servo import Servo
from gaitlab.parameters import parameter_table
from gaitlab.plugins import (
    CodeKind,
    blamed,
    is_file_name,
    label,
    load_class,
    names,
    suggestion,
)
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import Plugin, plugin


def read_parts(sections: Sections, varied: Mapping[str, Node]) -> Parts:
    """Parts of an experiment; everything wrong in any of them is reported together.

    Args:
        sections: The file's sections.
        varied: First value of every varied path, for parameters that only the grid gives.

    Raises:
        FileError: All mistakes.
    """
    problems: list[Problem] = []
    robot = collected(problems, lambda: _plugged("robot", sections.robot, varied))
    gait = collected(problems, lambda: _plugged("gait", sections.gait, varied))
    surfaces = collected(problems, lambda: read_surfaces(sections))
    servo = collected(problems, lambda: read_servo(sections.servo))
    balance = collected(problems, lambda: _balance(sections.balance, varied))
    metrics = collected(problems, lambda: read_metrics(sections.metrics))
    if robot is None or gait is None or surfaces is None or servo is None or balance is None:
        raise FileError(problems)
    if metrics is None:
        raise FileError(problems)
    parts = Parts(
        robot=robot[0],
        robot_code=robot[1],
        gait=gait[0],
        gait_code=gait[1],
        balance=balance[0],
        balance_code=balance[1],
        surfaces=surfaces,
        servo=servo,
        engine=sections.engine,
        horizon=sections.horizon,
        spread=sections.spread,
        metric_codes=metrics,
    )
    servos = checked(sections.servo or sections.robot, lambda: parts.servos({}))
    checked(sections.robot, lambda: require_own_space(parts.robot))
    checked(sections.gait, lambda: require_playable(parts.gait, parts.robot, servos))
    checked(sections.balance or sections.robot, lambda: parts.try_out("balance", {}))
    return parts


def _balance(
    node: Node | None, varied: Mapping[str, Node]
) -> tuple[Any, Plugin] | tuple[None, None]:
    """The balance controller and its code; switched off, its gains go unread."""
    if node is None or _type_of("balance", node).value == NO_BALANCE:
        return None, None
    return _plugged("balance", node, varied)


def _plugged(kind: CodeKind, node: Node, varied: Mapping[str, Node]) -> tuple[Any, Plugin]:
    name = _type_of(kind, node)
    code = checked(name, lambda: plugin(kind, str(name.value), name.folder))
    cls = checked(name, lambda: load_class(kind, str(name.value), name.folder))
    if kind == "gait" and "walk" in node.mapping and hasattr(cls, "of"):
        node = _standing(cls, node)
    try:
        made: Any = build(cls, _with_own_files(cls, _completed(cls, kind, node, varied)))
        checked(node, lambda: try_out(kind, made))
    except GaitlabError:
        raise
    except Exception as error:  # the team's own code may raise anything
        if code.digest is None:
            raise
        raise blamed(Path(code.name), f"no {kind} can be made of it", error) from error
    return made, code


def _type_of(kind: Literal["gait", "robot", "balance"], node: Node) -> Node:
    name = node.mapping.get("type")
    if name is None:
        known = ", ".join([NO_BALANCE] * (kind == "balance") + names(kind))
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


def _standing(cls: Any, node: Node) -> Node:
    """A gait that stands as another starts to walk: what it takes from there, in numbers."""
    walk = node.mapping["walk"]
    if isinstance(walk.value, str):
        walk = walk.holding(Node(file=walk.file, value={"type": walk}))
    made, _ = _plugged("gait", walk, {})
    pose: dict[str, float] = checked(walk, lambda: cls.of(made))
    taken = {name: walk.holding(Node(file=walk.file, value=value)) for name, value in pose.items()}
    return node.without("walk", *taken).replaced(**{**taken, **_given(node, taken)})


def _given(node: Node, names: Container[str]) -> dict[str, Node]:
    return {name: given for name, given in node.mapping.items() if name in names}


def _with_own_files(cls: type, node: Node) -> Node:
    """Files that parameters name, found from the file that names them."""
    found = {
        name: value.holding(Node(file=value.file, value=str(value.folder / str(value.value))))
        for name, value in node.mapping.items()
        if name in parameter_table(cls)
        and parameter_table(cls)[name].unit == "file"
        and isinstance(value.value, str)
        and is_file_name(value.value)
    }
    return node.replaced(**found)


def read_metrics(node: Node | None) -> tuple[Plugin, ...]:
    """Code of the user's own metrics, each ready to be asked for by its stem.

    Raises:
        FileError: All mistakes.
    """
    if node is None:
        return ()
    if not isinstance(node.value, tuple):
        message = f"metrics: found {node.found()}; expected a list of files, [./my_metric.py]"
        raise FileError([node.problem(message)])
    problems: list[Problem] = []
    found = [collected(problems, lambda item=item: _metric(item)) for item in node.items]  # type: ignore[misc]
    codes = [code for code in found if code is not None]
    for code in codes:
        if sum(label(other.name) == label(code.name) for other in codes) > 1:
            problems.append(node.problem(f"metrics: two files are called {label(code.name)}"))
    if problems:
        raise FileError(list(dict.fromkeys(problems)))
    return tuple(codes)


def _metric(node: Node) -> Plugin:
    if not isinstance(node.value, str) or not is_file_name(node.value):
        raise FileError(
            [
                node.problem(
                    f"metrics: found {node.found()}; expected a file of your own, ./my_metric.py. "
                    "Those of gaitlab are always measured; `metrics:` of `report:` draws them"
                )
            ]
        )
    code = checked(node, lambda: plugin("metric", str(node.value), node.folder))
    take_in(Path(code.name))
    return code


def read_depends(node: Node | None) -> list[Path] | None:
    """Files that code of the user's own is made of, as declared; a folder stands for all in it.

    Returns:
        None if nothing is declared.

    Raises:
        FileError: All mistakes.
    """
    if node is None:
        return None
    if not isinstance(node.value, tuple):
        message = (
            f"depends: found {node.found()}; expected a list of files and folders, [./lift.csv]"
        )
        raise FileError([node.problem(message)])
    problems: list[Problem] = []
    found: list[Path] = []
    for item in node.items:
        place = item.folder / str(item.value)
        if isinstance(item.value, str) and is_file_name(item.value) and place.is_file():
            found.append(place)
        elif isinstance(item.value, str) and is_file_name(item.value) and place.is_dir():
            inside = (path for path in sorted(place.rglob("*")) if "__pycache__" not in path.parts)
            found += [path for path in inside if path.is_file()]
        else:
            what = f"{item.found()}: there is no such file; expected one relative to {item.folder}"
            problems.append(item.problem(f"depends: found {what}, a folder with a slash, ./tables"))
    if problems:
        raise FileError(problems)
    return found


def read_surfaces(sections: Sections) -> dict[str, Surface]:
    """Surfaces by label, each with the section `surface` applied.

    Raises:
        FileError: All mistakes.
    """
    problems: list[Problem] = []
    found: dict[str, Surface] = {}
    first: dict[str, str] = {}  # how each label was written
    for node in _listed(sections.surfaces):
        surface = collected(problems, lambda node=node: _surface(node))  # type: ignore[misc]
        written = str(node.value)
        called = label(written)
        before = first.setdefault(called, written)
        if called in found and before == written:
            problems.append(node.problem(f"surfaces: {called!r} is listed twice; keep one of them"))
        elif called in found:
            message = (
                f"surfaces: found {written!r} beside {before!r}: results would call both {called}; "
                "rename the file, as tables tell grounds apart by the names of their files"
            )
            problems.append(node.problem(message))
        if surface is not None:
            found[called] = surface
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
    problems: dict[int, list[Problem]] = {}  # by key; one ground's complaint stands for all
    for name, surface in surfaces.items():
        settings: dict[str, Value] = {}
        for place, (key, value) in enumerate(node.mapping.items()):
            try:
                settings[key] = _setting(name, surface, key, node, value)
            except FileError as error:
                problems.setdefault(place, error.problems)
        if not problems:
            surfaces[name] = checked(node, lambda s=surface, v=settings: changed(s, v))  # type: ignore[misc]
    if problems:
        raise FileError([problem for found in problems.values() for problem in found])
    return surfaces


def _setting(name: str, surface: Surface, key: str, node: Node, value: Node) -> Value:
    table = parameter_table(type(surface))
    if key not in table:
        message = (
            f"surface: {key!r} is no parameter of {name}, a surface of type {surface.type!r}"
            f"{suggestion(key, table)}"
        )
        raise FileError([node.keys[key].problem(message)])
    found: Value = check(dataclasses.replace(table[key], name=f"surface.{key}"), value)
    return found


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
