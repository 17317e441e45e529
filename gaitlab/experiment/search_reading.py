"""The section `search:` of a study: dotted paths with the range or the choices of each.

gait.step_height: {low: 0.01, high: 0.06}
gait.tick_increment: {low: 0.03, high: 0.12, log: true}
gait.heel_strike: [none, add]
gait.heel_gain: {low: 0.1, high: 0.6, when: {gait.heel_strike: [add]}}
gait.x_law: {choices: [printed, quarter], when: {gait.heel_strike: add}}
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import get_args, get_origin

from gaitlab.documents import Node
from gaitlab.errors import FileError, Problem, WrongValue
from gaitlab.experiment.axes import nearly_listed
from gaitlab.experiment.parts import Parts, Value
from gaitlab.experiment.ranges import read_ends, unknown_keys
from gaitlab.experiment.study import Choices, Condition, Numbers
from gaitlab.parameters import Parameter
from gaitlab.plugins import suggestion

RANGE = ("low", "high", "step", "log", "when")  # keys of a number
LISTED = ("choices", "when")  # keys of a choice that has a condition


def read_search(
    node: Node | None, section: Node, parts: Parts | None
) -> tuple[Numbers | Choices, ...]:
    """The space; what is searched only under a condition comes last.

    Args:
        node: The section; None if there is none.
        section: What it belongs to.
        parts: What the paths change; None if that is wrong, and then the space is left empty.

    Raises:
        FileError: All mistakes.
    """
    if node is None or not node.mapping:
        place = node or section
        found = "nothing" if node is None or node.value in ({}, ()) else node.found()
        message = (
            f"search: found {found}; expected lines of the form "
            "`gait.step_height: {low: 0.01, high: 0.06}` or `gait.heel_strike: [none, add]`"
        )
        raise FileError([place.problem(message)])
    if parts is None:
        return ()
    problems: list[Problem] = []
    found_items = {path: _item(path, node, parts, problems) for path in node.mapping}
    space = {path: item for path, item in found_items.items() if item is not None}
    problems += [p for item in space.values() for p in _wrong_condition(item, space, node)]
    if problems:
        raise FileError(problems)
    return tuple(sorted(space.values(), key=lambda item: item.when is not None))


def first_values(node: Node | None) -> dict[str, Node]:
    """A value of every searched path, for parameters that only the search gives."""
    found = {}
    for path, item in (node.mapping if node else {}).items():
        listed = item.mapping.get("choices", item).items
        value = item.mapping.get("low", listed[0] if listed else None)
        if value is not None:
            found[path] = value
    return found


def _item(
    path: str, search: Node, parts: Parts, problems: list[Problem]
) -> Numbers | Choices | None:
    """One searched parameter; its mistakes go to `problems`."""
    node = search.mapping[path]
    try:
        item = replace(parts.parameter(path, everywhere=True), name=path)
    except WrongValue as error:
        problems.append(search.keys[path].problem(f"search: {error}"))
        return None
    try:
        if node.items or "choices" in node.mapping or node.value == ():
            return _choices(item, node, parts)
        return _numbers(item, node)
    except FileError as error:
        problems += error.problems
        return None


def _choices(item: Parameter, node: Node, parts: Parts) -> Choices:
    listed = node.mapping.get("choices", node)
    problems = unknown_keys(item, node, LISTED)
    options: list[Value] = []
    for option in listed.items:
        try:
            value = parts.check(item.name, option)
        except FileError as error:
            problems += error.problems
            continue
        if not isinstance(value, bool | int | float | str):
            problems.append(option.problem(f"{item.name}: a list cannot be one of the choices"))
        elif _key(value) in map(_key, options):
            problems.append(option.problem(f"{item.name}: {value} is listed twice; keep one"))
        problems += nearly_listed(option, item.name, value, options)
        options.append(value)
    if len(listed.items) < 2:
        found = f"only {listed.items[0].value!r}" if listed.items else "no value"
        message = (
            f"{item.name}: found {found}; a choice has at least two values. To hold it at one, "
            f"write it under {item.name.partition('.')[0]}: instead"
        )
        problems.append(listed.problem(message))
    if problems:
        raise FileError(problems)
    return Choices(path=item.name, options=tuple(options), when=_condition(item, node))


def _key(value: object) -> tuple[bool, object]:
    """What tells values apart: true is not 1, but 1 is 1.0."""
    return isinstance(value, bool), value


def _numbers(item: Parameter, node: Node) -> Numbers:
    if not node.mapping:
        raise FileError([node.problem(f"{item.name}: found {node.found()}; {_expected(item)}")])
    if item.type not in (int, float):
        message = f"{item.name}: has no range; {_expected(item)}"
        raise FileError([node.problem(message)])
    problems = unknown_keys(item, node, RANGE)
    try:
        low, high, step, log = read_ends(item, node, _expected(item))
    except FileError as error:
        raise FileError([*problems, *error.problems]) from None
    if problems:
        raise FileError(problems)
    return Numbers(
        path=item.name,
        low=low,
        high=high,
        step=step,
        log=log,
        integer=item.type is int,
        when=_condition(item, node),
    )


def _expected(item: Parameter) -> str:
    """How a parameter of this kind is searched."""
    if item.type in (int, float):
        return "expected {low: ..., high: ...} or a list of values"
    if item.type is bool:
        return "expected the list [true, false]"
    if get_origin(item.type) is not None and get_args(item.type):
        known = ", ".join(str(choice) for choice in get_args(item.type))
        return f"expected a list of two or more of: {known}"
    return "expected a list of two or more values"


def _condition(item: Parameter, node: Node) -> Condition | None:
    """`when: {gait.heel_strike: [add]}`; the values alone are not checked here."""
    when = node.mapping.get("when")
    if when is None:
        return None
    if len(when.mapping) != 1:
        found = when.found() if len(when.mapping) == 0 else f"{len(when.mapping)} parameters"
        message = (
            f"{item.name}: when: found {found}; expected one other searched choice and its "
            "values, {gait.heel_strike: [add]} for instance"
        )
        raise FileError([when.problem(message)])
    ((path, values),) = when.mapping.items()
    listed = [value.value for value in values.items or (values,)]
    fitting = tuple(value for value in listed if isinstance(value, bool | int | float | str))
    if not fitting or len(fitting) < len(listed):
        message = f"{item.name}: when: found {values.found()}; expected values of {path}"
        raise FileError([values.problem(message)])
    return Condition(path=path, values=fitting)


def _wrong_condition(
    item: Numbers | Choices, space: dict[str, Numbers | Choices], search: Node
) -> Iterator[Problem]:
    if item.when is None:
        return
    when = search.mapping[item.path].mapping["when"]
    place, path = when.keys[item.when.path], item.when.path
    other = space.get(path)
    choices = [known.path for known in space.values() if isinstance(known, Choices)]
    if path == item.path:
        yield place.problem(f"{item.path}: when: it cannot depend on itself; name another one")
    elif path not in search.mapping:
        message = f"{item.path}: when: {path!r} is not searched{suggestion(path, choices)}"
        yield place.problem(message)
    elif isinstance(other, Numbers):
        message = f"{item.path}: when: {path} is a range; a condition names a list of choices"
        yield place.problem(f"{message}{suggestion('', choices)}")
    elif isinstance(other, Choices) and other.when is not None:
        message = f"{item.path}: when: {path} has a condition itself; only one level is searched"
        yield place.problem(message)
    elif isinstance(other, Choices):
        yield from _wrong_values(item, other, when.mapping[path])


def _wrong_values(item: Numbers | Choices, other: Choices, values: Node) -> Iterator[Problem]:
    known = [_key(option) for option in other.options]
    wanted = values.items or (values,)
    wrong = [node for node in wanted if _key(node.value) not in known]
    options = [str(option) for option in other.options]
    for node in wrong:
        hint = suggestion(str(node.value), options)
        yield node.problem(f"{item.path}: when: found {node.found()} for {other.path}{hint}")
    if not wrong and len({_key(node.value) for node in wanted}) == len(options):
        message = f"{item.path}: when: lists all values of {other.path}; leave `when` out"
        yield values.problem(message)
