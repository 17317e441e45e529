"""A range of numbers as a file writes it: `{low: 0.01, high: 0.06, log: true}`, checked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import floor
from typing import NamedTuple

from gaitlab.documents import Node, check
from gaitlab.errors import FileError, Problem
from gaitlab.parameters import Parameter
from gaitlab.plugins import suggestion

ROUNDING = 1e-6  # steps; forgives 0.05 / 0.01 being below 5


class Ends(NamedTuple):
    """Low and high end, the distance of the allowed values, and whether ratios count."""

    low: float
    high: float
    step: float | None
    log: bool


def read_ends(item: Parameter, node: Node, expected: str) -> Ends:
    """What the keys `low`, `high`, `step` and `log` of a mapping say.

    Args:
        item: What is ranged over; its limits bind the ends.
        node: The mapping; other keys in it are the caller's.
        expected: What the file should hold, for the message when an end is missing.

    Raises:
        FileError: All mistakes.
    """
    problems = [
        node.problem(f"{item.name}: `{key}:` is missing; {expected}")
        for key in ("low", "high")
        if key not in node.mapping
    ]
    low, high, step = (_number(item, node, key, problems) for key in ("low", "high", "step"))
    log = _log(item, node, problems)
    if low is not None and high is not None:
        problems += _wrong_range(item, node, low, high, step, log)
    if problems or low is None or high is None:
        raise FileError(problems)
    return Ends(low, high, step, log)


def unknown_keys(item: Parameter, node: Node, known: Sequence[str]) -> list[Problem]:
    """Keys of a mapping that mean nothing."""
    return [
        node.keys[key].problem(f"{item.name}: unknown key {key!r}{suggestion(key, known)}")
        for key in node.mapping
        if key not in known
    ]


def _number(item: Parameter, node: Node, key: str, problems: list[Problem]) -> float | None:
    """A number of a range; the limits of the parameter bind its ends."""
    if key not in node.mapping:
        return None
    limits = replace(item, name=f"{item.name}: {key}")
    if key == "step":
        least = 1 if item.type is int else None
        limits = replace(limits, low=least, high=None, doc="distance of the allowed values")
    try:
        value: float = check(limits, node.mapping[key])
    except FileError as error:
        problems += error.problems
        return None
    return value


def _log(item: Parameter, node: Node, problems: list[Problem]) -> bool:
    value = node.mapping.get("log")
    if value is None or isinstance(value.value, bool):
        return bool(value and value.value)
    message = f"{item.name}: log: found {value.found()}; allowed is true or false"
    problems.append(value.problem(message))
    return False


def _wrong_range(
    item: Parameter, node: Node, low: float, high: float, step: float | None, log: bool
) -> Iterator[Problem]:
    at_high, name = node.mapping["high"], item.name
    if low >= high:
        what = "is empty" if low == high else "is upside down"
        message = f"{name}: the range from {low:g} to {high:g} {what}; low is below high"
        yield at_high.problem(message)
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
