"""What a message says of a wrong value: found, allowed, meaning, nearest."""

from __future__ import annotations

from math import isfinite, pi
from typing import Literal, cast, get_args, get_origin

from gaitlab.documents.nodes import Node
from gaitlab.documents.typed import instead, typed_number
from gaitlab.errors import Problem
from gaitlab.parameters import Parameter, parameter_table
from gaitlab.plugins import nearest, suggestion

FAR_OUTSIDE = 4.0  # times the largest value allowed; nearer ones are rather bold than in mm
SLIPS = {  # factor from what was probably meant to SI, by unit
    "m": ((1e-3, "millimetres"), (1e-2, "centimetres")),
    "rad": ((pi / 180.0, "degrees"),),
    "rad/s": ((pi / 180.0, "degrees a second"), (pi / 30.0, "turns a minute")),
    "s": ((1e-3, "milliseconds"),),
    "kg": ((1e-3, "grams"),),
}


def allowed(item: Parameter) -> str:
    """What a parameter takes, in words."""
    if get_origin(item.type) is Literal:
        return f"one of {', '.join(str(choice) for choice in get_args(item.type))}"
    if item.type is bool:
        return "true or false"
    if item.type not in (int, float):
        section = item.type is Node or Node in get_args(item.type)
        known = {tuple: "a list", dict: "a mapping"}
        return "a section of the file" if section else known.get(get_origin(item.type), "text")
    kind = "a whole number" if item.type is int else "a number"
    unit = "" if item.unit == "-" else f" {item.unit}"
    low, high = (None if bound is None else f"{bound:g}" for bound in (item.low, item.high))
    if low is not None and high is not None:
        return f"{kind} from {low} to {high}{unit}"
    return f"{kind}{f' of at least {low}' if low else f' of at most {high}' if high else ''}{unit}"


def unknown_key(cls: type, root: Node, parent: str, name: str) -> Problem:
    """A key that nothing is called by, at its place."""
    owner = root
    for part in filter(None, parent.split(".")):
        owner = owner.mapping[part]
    prefix = f"{parent}." if parent else ""
    known = {
        path.removeprefix(prefix).split(".")[0]: None
        for path in parameter_table(cls)
        if path.startswith(prefix)
    }
    where = f" in {parent!r}" if parent else ""
    return owner.keys[name].problem(f"unknown key {name!r}{where}{suggestion(name, known)}")


def expected_mapping(cls: type, node: Node, path: str = "") -> str:
    """What stands where a mapping should, and its keys."""
    what = f"{path}: " if path else ""
    names = list(
        dict.fromkeys(
            key.removeprefix(f"{path}.").split(".")[0]
            for key in parameter_table(cls)
            if not path or key.startswith(f"{path}.")
        )
    )
    return f"{what}found {node.found()}; expected a mapping with any of: {', '.join(names)}"


def wrong_value(item: Parameter, node: Node) -> str:
    """What was found, what is allowed, what it means and what was probably meant."""
    unit = "" if item.unit == "-" or not isinstance(node.value, int | float) else f" {item.unit}"
    found = f"{item.name}: found {node.found()}{'' if isinstance(node.value, bool) else unit}"
    choice = ""
    if get_origin(item.type) is Literal and isinstance(node.value, str):
        choice = nearest(node.value, map(str, get_args(item.type)))
    hint = (
        choice
        or former_unit(item, node.value)
        or _slip(item, node.value)
        or _typing(item, node.value)
    )
    return f"{found}; allowed is {allowed(item)} ({item.doc}){hint}"


def _typing(item: Parameter, value: object) -> str:
    """What was probably meant when a text stands where a number should."""
    if item.type not in (int, float) or not isinstance(value, str):
        return ""
    number, rest = typed_number(value)
    if number and rest:
        return f"; write the number alone, without {rest[:20]!r}, in the unit above"
    return f"; write {number} without quotes" if number and not instead(value) else ""


def former_unit(item: Parameter, value: object) -> str:
    """What a number is today that was right in the unit which the parameter once had."""
    known = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    if item.former is None or not known or item.low is None or item.high is None:
        return ""
    today = cast(float, value) * item.former.factor
    if not item.low <= today <= item.high:
        return ""
    return (
        f"; it is in {item.former.today} and no longer in {item.former.name}: "
        f"{value:g} {item.former.name} are written {today:.6g}"
    )


def _slip(item: Parameter, value: object) -> str:
    """What was probably meant when a number fits in another unit."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        return ""
    if item.low is None or item.high is None:
        return ""
    low, high = item.low, item.high
    for factor, unit in SLIPS.get(item.unit, ()):
        within = low <= value * factor <= high
        if within and abs(value) > FAR_OUTSIDE * max(abs(low), abs(high)):
            meant = f"{value:g} {unit} are written {value * factor:.4g}"
            return f"; units are SI: {meant}"
    return ""
