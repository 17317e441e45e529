"""The section `search:` of a study: dotted paths with the range or the choices of each.

gait.step_height: {low: 0.01, high: 0.06}
gait.tick_increment: {low: 0.03, high: 0.12, log: true}
gait.heel_strike: [none, add]
gait.heel_gain: {low: 0.1, high: 0.6, when: {gait.heel_strike: [add]}}
gait.x_law: {choices: [printed, quarter], when: {gait.heel_strike: add}}
gait.gait_period: {low: 0.7, high: 1.5, relative: true}   # times the value that it has before
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import floor
from typing import Any, cast, get_args, get_origin

from gaitlab.documents import Node, Reader, check, collected, read_mapping
from gaitlab.errors import FileError, Problem, WrongValue
from gaitlab.experiment.axes import nearly_listed
from gaitlab.experiment.parts import Parts, Value
from gaitlab.experiment.study import Choices, Condition, Numbers
from gaitlab.parameters import Parameter
from gaitlab.plugins import suggestion

ROUNDING = 1e-6  # steps; forgives 0.05 / 0.01 being below 5
RELATIVE = Parameter(
    name="relative", type=bool, doc="whether low and high are times the value before the search"
)
FACTOR = Parameter(name="", type=float, low=-1000.0, high=1000.0, doc="times the value before")
LOG = Parameter(name="log", type=bool, doc="whether ratios count and not differences")


def read_search(node: Node, parts: Parts | None) -> tuple[Numbers | Choices, ...]:
    """The space; what is searched only under a condition comes last.

    Args:
        node: The section.
        parts: What the paths change; None if that is wrong, and then the space is left empty.

    Raises:
        FileError: All mistakes.
    """
    if not node.mapping:
        message = (
            f"search: found {node.found()}; expected lines of the form "
            "`gait.step_height: {low: 0.01, high: 0.06}` or `gait.heel_strike: [none, add]`"
        )
        raise FileError([node.problem(message)])
    if parts is None:
        return ()
    problems: list[Problem] = []
    items = {p: collected(problems, partial(_read_item, p, node, parts)) for p in node.mapping}
    space = {path: item for path, item in items.items() if item is not None}
    problems += [p for item in space.values() for p in _wrong_condition(item, space, node)]
    if problems:
        raise FileError(problems)
    return tuple(sorted(space.values(), key=lambda item: item.when is not None))


def first_values(node: Node | None) -> dict[str, Node]:
    """A value of every searched path, for parameters that only the search gives."""
    values = {}
    for path, item in (node.mapping if node else {}).items():
        listed = item.mapping.get("choices", item).items
        value = item.mapping.get("low", listed[0] if listed else None)
        if value is not None and "relative" not in item.mapping:
            values[path] = value
    return values


def read_range(
    item: Parameter, node: Node, further: Mapping[str, Reader], expected: str
) -> tuple[Numbers, dict[str, Any]]:
    """A range of numbers, `{low: 0.01, high: 0.06, log: true}`, and further keys beside it.

    Args:
        item: What is ranged over; its limits bind the ends.
        node: The mapping.
        further: Other keys that it may have, each with what reads it; `step` if it may have one.
        expected: What the file should hold, for the message when an end is missing.

    Raises:
        FileError: All mistakes.
    """
    keys: dict[str, Reader] = {"low": item, "high": item, "log": LOG, **further}
    given = read_mapping(item.name, node, keys, required=("low", "high"), expected=expected)
    numbers = Numbers(
        path=item.name,
        low=given.pop("low"),
        high=given.pop("high"),
        step=given.pop("step", None),
        log=given.pop("log", False),
        integer=item.type is int,
    )
    problems = list(_wrong_range(item.name, node, numbers))
    if problems:
        raise FileError(problems)
    return numbers, given


def _wrong_range(name: str, node: Node, numbers: Numbers) -> Iterator[Problem]:
    low, high, step, log = numbers.low, numbers.high, numbers.step, numbers.log
    if low >= high:
        what = "is empty" if low == high else "is upside down"
        message = f"{name}: the range from {low:g} to {high:g} {what}; low is below high"
        yield node.mapping["high"].problem(message)
        return
    if log and low <= 0.0:
        message = f"{name}: low is {low:g}, and with `log: true` it is above 0"
        yield node.mapping["low"].problem(message)
    if step is None:
        return
    at_step = node.mapping["step"]
    if log:
        yield at_step.problem(f"{name}: `step` and `log: true` exclude each other; drop one")
    elif step <= 0.0:
        yield at_step.problem(f"{name}: found a step of {step:g}; it is above 0")
    elif step > (high - low) * (1.0 + ROUNDING):
        message = f"{name}: a step of {step:g} is wider than the range from {low:g} to {high:g}"
        yield at_step.problem(f"{message}; write a smaller one")
    elif abs((high - low) / step - round((high - low) / step)) > ROUNDING:
        last = low + step * floor((high - low) / step)
        message = f"{name}: steps of {step:g} from {low:g} do not meet {high:g}"
        yield at_step.problem(f"{message}; write `high: {last:g}` or `high: {last + step:g}`")


def _read_item(path: str, search: Node, parts: Parts) -> Numbers | Choices:
    """One searched parameter."""
    node = search.mapping[path]
    try:
        item = replace(parts.parameter(path, everywhere=True), name=path)
    except WrongValue as error:
        raise FileError([search.keys[path].problem(f"search: {error}")]) from None
    condition = partial(_read_condition, path)
    if node.items or node.value == ():
        return _read_choices(item, node, parts)
    if "choices" in node.mapping:
        keys: dict[str, Reader] = {
            "choices": partial(_read_choices, item, parts=parts),
            "when": condition,
        }
        given = read_mapping(path, node, keys, expected=_expected(item))
        return replace(given["choices"], when=given.get("when"))
    if node.mapping and item.type not in (int, float):
        raise FileError([node.problem(f"{path}: has no range; {_expected(item)}")])
    if "relative" in node.mapping:
        node = _from_base(item, node, parts)
    least = 1 if item.type is int else None
    step = replace(item, low=least, high=None, doc="distance of the allowed values")
    further: dict[str, Reader] = {"step": step, "when": condition}
    numbers, given = read_range(item, node, further, _expected(item))
    return replace(numbers, when=given.get("when"))


def _from_base(item: Parameter, node: Node, parts: Parts) -> Node:
    """A range with its ends as values; what goes beyond the parameter's own limits ends there.

    Raises:
        FileError: If the value before the search is 0, none, or several.
    """
    if not check(replace(RELATIVE, name=f"{item.name}: relative"), node.mapping["relative"]):
        return node.without("relative")
    before = parts.base_values(item.name)
    if item.type is not float or len(before) != 1 or not before[0]:
        shown = ", ".join(map(str, before)) or "nothing"
        message = (
            f"{item.name}: relative: the value before the search is {shown}; one number other than "
            "0 is needed. Write low and high in the parameter's unit"
        )
        raise FileError([node.mapping["relative"].problem(message)])
    base = float(cast(float, before[0]))
    factors = [
        check(replace(FACTOR, name=f"{item.name}: {end}"), node.mapping[end])
        for end in ("low", "high")
        if end in node.mapping
    ]
    if len(factors) < 2:
        return node.without("relative")  # what lacks is said by whoever reads it
    least, most = (base * factor for factor in sorted(factors, key=lambda f: base * f))
    ends = {
        "low": least if item.low is None else max(least, item.low),
        "high": most if item.high is None else min(most, item.high),
    }
    return node.without("relative").replaced(
        **{end: node.mapping[end].holding(Node(file=node.file, value=v)) for end, v in ends.items()}
    )


def _read_choices(item: Parameter, node: Node, parts: Parts) -> Choices:
    problems: list[Problem] = []
    options: list[Value] = []
    for option in node.items:
        value = collected(problems, partial(parts.check, item.name, option))
        if value is None:
            continue
        if not isinstance(value, bool | int | float | str):
            problems.append(option.problem(f"{item.name}: a list cannot be one of the choices"))
        elif _key(value) in map(_key, options):
            problems.append(option.problem(f"{item.name}: {value} is listed twice; keep one"))
        problems += nearly_listed(option, item.name, value, options)
        options.append(value)
    if len(node.items) < 2:
        found = f"only {node.items[0].value!r}" if node.items else "no value"
        message = (
            f"{item.name}: found {found}; a choice has at least two values. To hold it at one, "
            f"write it under {item.name.partition('.')[0]}: instead"
        )
        problems.append(node.problem(message))
    if problems:
        raise FileError(problems)
    return Choices(path=item.name, options=tuple(options))


def _key(value: object) -> tuple[bool, object]:
    """What tells values apart: true is not 1, but 1 is 1.0."""
    return isinstance(value, bool), value


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


def _read_condition(name: str, node: Node) -> Condition:
    """`when: {gait.heel_strike: [add]}`; the values alone are not checked here."""
    if len(node.mapping) != 1:
        found = f"{len(node.mapping)} parameters" if node.mapping else node.found()
        message = (
            f"{name}: when: found {found}; expected one other searched choice and its "
            "values, {gait.heel_strike: [add]} for instance"
        )
        raise FileError([node.problem(message)])
    ((path, values),) = node.mapping.items()
    listed = [value.value for value in values.items or (values,)]
    fitting = tuple(value for value in listed if isinstance(value, bool | int | float | str))
    if not fitting or len(fitting) < len(listed):
        message = f"{name}: when: found {values.found()}; expected values of {path}"
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
