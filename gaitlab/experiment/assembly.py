"""The sections of an experiment file put together to robot, gait, grounds and servos."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Container, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

from gaitlab.documents import (
    Node,
    Reader,
    build,
    check,
    checked,
    collected,
    read_each,
    read_mapping,
)
from gaitlab.errors import FileError, GaitlabError, Problem
from gaitlab.experiment.parts import (
    NO_BALANCE,
    SERVO_TYPE,
    Parts,
    Value,
    changed,
    placed,
    servo_type,
    try_out,
)
from gaitlab.experiment.schema import Sections
from gaitlab.metrics import take_in
from gaitlab.model import Robot
from gaitlab.model.clearance import require_own_space
from gaitlab.model.commands import Reactive, require_playable
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
from gaitlab.simulation.trial import Plugin, plugin
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface


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
    suited = None if robot is None else robot[0]
    gait = collected(problems, lambda: _plugged("gait", sections.gait, varied, suited))
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
        slope=sections.slope,
        push=sections.push,
        metric_codes=metrics,
    )
    servos = checked(sections.servo or sections.robot, lambda: parts.servos({}))
    checked(sections.robot, lambda: require_own_space(parts.robot))
    checked(sections.gait, lambda: require_playable(parts.gait, parts.robot, servos))
    checked(sections.balance or sections.robot, lambda: parts.try_out("balance", {}))
    if sections.balance is not None and parts.balance and isinstance(parts.gait, Reactive):
        message = (
            f"balance: the gait {label(parts.gait_code.name)} balances by itself; leave it out"
        )
        raise FileError([sections.balance.problem(message)])
    return parts


def _balance(
    node: Node | None, varied: Mapping[str, Node]
) -> tuple[Any, Plugin] | tuple[None, None]:
    """The balance controller and its code; switched off, its gains go unread."""
    if node is None or _type_of("balance", node).value == NO_BALANCE:
        return None, None
    return _plugged("balance", node, varied)


def _plugged(
    kind: CodeKind, node: Node, varied: Mapping[str, Node], robot: Robot | None = None
) -> tuple[Any, Plugin]:
    """What a section names, made with its settings, and its code.

    Args:
        kind: What it is.
        node: The section.
        varied: First value of every varied path.
        robot: What a gait is scaled to that says how; None to leave it as its file has it.
    """
    name = _type_of(kind, node)
    code = checked(name, lambda: plugin(kind, str(name.value), name.folder))
    cls = checked(name, lambda: load_class(kind, str(name.value), name.folder))
    if hasattr(cls, "declared"):
        cls, node = cls.declared(node)
    if kind == "gait" and "walk" in node.mapping and hasattr(cls, "of"):
        node = _standing(cls, node, robot)
    elif robot is not None and hasattr(cls, "suited_to"):
        node = _suited(cls, node, robot)
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


def _suited(cls: Any, node: Node, robot: Robot) -> Node:
    """A gait scaled to a robot, in numbers, where the file does not set it otherwise."""
    values: dict[str, float] = checked(node, lambda: cls.suited_to(robot))
    found = {
        name: Node(file=node.file, line=node.line, column=node.column, value=value)
        for name, value in values.items()
        if name not in node.mapping
    }
    return node.replaced(**found)


def _standing(cls: Any, node: Node, robot: Robot | None) -> Node:
    """A gait that stands as another starts to walk: what it takes from there, in numbers."""
    walk = node.mapping["walk"]
    if isinstance(walk.value, str):
        walk = walk.holding(Node(file=walk.file, value={"type": walk}))
    made, _ = _plugged("gait", walk, {}, robot)
    pose: dict[str, float] = checked(walk, lambda: cls.of(made))
    taken = {name: walk.holding(Node(file=walk.file, value=value)) for name, value in pose.items()}
    return node.without("walk", *taken).replaced(**{**taken, **_given(node, taken)})


def _given(node: Node, names: Container[str]) -> dict[str, Node]:
    return {name: given for name, given in node.mapping.items() if name in names}


def _with_own_files(cls: type, node: Node) -> Node:
    """Files that parameters name, found from the file that names them."""
    found = {
        name: placed(value)
        for name, value in node.mapping.items()
        if name in parameter_table(cls) and parameter_table(cls)[name].unit == "file"
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
    codes = read_each(node.items, _read_metric)
    twice = [name for name, n in Counter(label(code.name) for code in codes).items() if n > 1]
    if twice:
        raise FileError([node.problem(f"metrics: two files are called {name}") for name in twice])
    return tuple(codes)


def _read_metric(node: Node) -> Plugin:
    if not isinstance(node.value, str) or not is_file_name(node.value):
        message = (
            f"metrics: found {node.found()}; expected a file of your own, ./my_metric.py. Those of "
            "gaitlab are always measured; `metrics:` of `report:` draws them"
        )
        raise FileError([node.problem(message)])
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
        what = f"found {node.found()}; expected a list of files and folders, [./lift.csv]"
        raise FileError([node.problem(f"depends: {what}")])
    return [path for paths in read_each(node.items, _read_dependency) for path in paths]


def _read_dependency(node: Node) -> list[Path]:
    place = node.folder / str(node.value)
    if isinstance(node.value, str) and is_file_name(node.value):
        if place.is_file():
            return [place]
        if place.is_dir():
            inside = (path for path in sorted(place.rglob("*")) if "__pycache__" not in path.parts)
            return [path for path in inside if path.is_file()]
    what = f"{node.found()}: there is no such file; expected one relative to {node.folder}"
    message = f"depends: found {what}, a folder with a slash, ./tables"
    raise FileError([node.problem(message)])


def read_surfaces(sections: Sections) -> dict[str, Surface]:
    """Surfaces by label, each with the section `surface` applied.

    Raises:
        FileError: All mistakes.
    """
    listed = sections.surfaces
    if not listed.items:
        expected = f"expected a list of names or files. Known: {', '.join(names('surface'))}"
        raise FileError([listed.problem(f"surfaces: found {listed.found()}; {expected}")])
    problems: list[Problem] = []
    found: dict[str, Surface] = {}
    first: dict[str, str] = {}  # how each label was written
    for node in listed.items:
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
    settings = dict(read_each(node.mapping, partial(_read_setting, node, surfaces)))
    return {
        name: checked(node, partial(changed, surface, {k: v[name] for k, v in settings.items()}))
        for name, surface in surfaces.items()
    }


def _read_setting(
    node: Node, surfaces: Mapping[str, Surface], key: str
) -> tuple[str, dict[str, Value]]:
    """A setting and its value on each surface; the complaint of the first one stands for all."""
    values = {}
    for name, surface in surfaces.items():
        table = parameter_table(type(surface))
        if key not in table:
            message = (
                f"surface: {key!r} is no parameter of {name}, a surface of type {surface.type!r}"
                f"{suggestion(key, table)}"
            )
            raise FileError([node.keys[key].problem(message)])
        item = dataclasses.replace(table[key], name=f"surface.{key}")
        values[name] = check(item, node.mapping[key])
    return key, values


def read_servo(node: Node | None) -> dict[str, Value]:
    """Settings of the section `servo`, checked.

    Raises:
        FileError: All mistakes.
    """
    if node is None or node.value == {}:
        return {}
    keys: dict[str, Reader] = {
        "type": lambda node: servo_type(
            node, str(check(dataclasses.replace(SERVO_TYPE, name="servo: type"), node))
        ),
        **parameter_table(Servo),
    }
    expected = "expected a name, or a mapping of settings"
    return read_mapping("servo", node, keys, expected=expected)
