"""Mappings in a user's file become dataclasses: strict types, ranges, units, known names only.

Whatever is wrong in a mapping is reported at once, each mistake with line and column.
A number is written bare, in the declared SI unit, or with its origin:
`height: {value: 0.050, unit: m, source: "ruler"}`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping
from functools import cache, partial
from math import isfinite, pi
from typing import (
    Annotated,
    Any,
    Literal,
    TypeAlias,
    TypeVar,
    cast,
    get_args,
    get_origin,
)

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    InstanceOf,
    TypeAdapter,
    ValidationError,
    create_model,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from gaitlab.documents.nodes import Node, collected, in_order, instead, plain, typed_number
from gaitlab.errors import FileError, GaitlabError, Problem
from gaitlab.parameters import Parameter, field_types, parameter_table
from gaitlab.plugins import nearest, suggestion

S = TypeVar("S")
T = TypeVar("T")
Reader: TypeAlias = Parameter | Callable[[Node], Any]  # what checks or reads a value
CONFIG = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)
DESCRIBED = ("value", "unit", "source")  # keys of a number with its origin
FAR_OUTSIDE = 4.0  # times the largest value allowed; nearer ones are rather bold than in mm
SLIPS = {  # factor from what was probably meant to SI, by unit
    "m": ((1e-3, "millimetres"), (1e-2, "centimetres")),
    "rad": ((pi / 180.0, "degrees"),),
    "rad/s": ((pi / 180.0, "degrees a second"), (pi / 30.0, "turns a minute")),
    "s": ((1e-3, "milliseconds"),),
    "kg": ((1e-3, "grams"),),
}


def build(cls: type[T], node: Node, *, skip: Collection[str] = ("type",)) -> T:
    """Instance of a dataclass made with `parameter` from a mapping in a file.

    Args:
        cls: The dataclass; nested dataclasses are nested mappings.
        node: The mapping; what it leaves out keeps its default.
        skip: Keys that the caller reads.

    Raises:
        FileError: Everything that is wrong in the mapping, in the order of the file.
    """
    if node.value is None:
        node = Node(file=node.file, line=node.line, column=node.column, value={})
    if not isinstance(node.value, Mapping):
        raise FileError([node.problem(expected_mapping(cls, node))])
    bare, problems, wrong = _without_origins(cls, node.without(*skip), "")
    try:
        model = _model(cast(type, cls), False).model_validate(_input(cls, bare))
    except ValidationError as error:
        details = error.errors(include_url=False, include_input=False)
        problems += [_problem(cls, bare, d) for d in details if _path(d) not in wrong]
    if problems:
        raise FileError(in_order(problems))
    return checked(node, lambda: cast(T, _instance(cls, model, None)))


def checked(node: Node, make: Callable[[], T]) -> T:
    """Result of `make()`; what it complains about becomes a mistake at the node.

    Raises:
        FileError: If `make` raises it, another error of gaitlab or a ValueError.
    """
    try:
        return make()
    except FileError:
        raise
    except (GaitlabError, ValueError) as error:
        raise FileError([node.problem(str(error))]) from error


def read_mapping(
    what: str,
    node: Node,
    known: Mapping[str, Reader],
    *,
    required: Collection[str] = (),
    expected: str,
    problems: list[Problem] | None = None,
) -> dict[str, Any]:
    """Entries of a mapping by key, each checked as a parameter or read by a function.

    Args:
        what: What the mapping is, for messages; empty for one whose keys speak for themselves.
        node: The mapping; keys that it leaves out are left out of the result.
        known: What each key takes.
        required: Keys that may not be left out.
        expected: What the file should hold, as the end of a message.
        problems: Where mistakes go, if they are not to be raised; wrong entries are left out.

    Raises:
        FileError: Everything that is wrong in the mapping.
    """
    start = f"{what}: " if what else ""
    if not node.mapping:
        raise FileError([node.problem(f"{start}found {node.found()}; {expected}")])
    wrong = [
        node.keys[key].problem(f"{start}unknown key {key!r}{suggestion(key, known)}")
        for key in node.mapping
        if key not in known
    ]
    wrong += [
        node.problem(f"{start}`{key}:` is missing; {expected}")
        for key in required
        if key not in node.mapping
    ]
    entries = {}
    for key, reader in known.items():
        if key not in node.mapping:
            continue
        if isinstance(reader, Parameter):
            reader = partial(check, dataclasses.replace(reader, name=f"{start}{key}"))
        try:
            entries[key] = reader(node.mapping[key])
        except FileError as error:
            wrong += error.problems
    if wrong and problems is None:
        raise FileError(in_order(wrong))
    if problems is not None:
        problems += wrong
    return entries


def read_each(items: Iterable[S], read: Callable[[S], T]) -> list[T]:
    """What is read of each item, a node for instance or the key of one.

    Raises:
        FileError: Everything that is wrong in any of them.
    """
    problems: list[Problem] = []
    results = [collected(problems, partial(read, item)) for item in items]
    if problems:
        raise FileError(problems)
    return cast(list[T], results)


def check(item: Parameter, node: Node) -> Any:
    """Value of one parameter from a node.

    Raises:
        FileError: If it has the wrong type or lies outside the range.
    """
    try:
        return _adapter(item.type, item.low, item.high).validate_python(plain(node))
    except ValidationError as error:
        detail = error.errors(include_url=False, include_input=False)[0]
        raise FileError([_at(node, detail).problem(wrong_value(item, _at(node, detail)))]) from None


@cache
def _adapter(hint: Any, low: float | None, high: float | None) -> TypeAdapter[Any]:
    return TypeAdapter(_annotated(hint, low, high), config=ConfigDict(strict=True))


def _annotated(hint: Any, low: float | None, high: float | None) -> Any:
    if hint is float:
        return Annotated[float, Field(ge=low, le=high, allow_inf_nan=False)]
    if hint is int:
        return Annotated[int, Field(ge=low, le=high)]
    if get_origin(hint) is Literal:
        return Annotated[hint, BeforeValidator(_no_hidden_bool)]
    return InstanceOf[Node] if _wants_node(hint) else hint


def _wants_node(hint: Any) -> bool:
    return hint is Node or Node in get_args(hint)


def _no_hidden_bool(value: object) -> object:
    # Literal[1, -1] takes True for 1; a switch is not a sign.
    if isinstance(value, bool):
        raise PydanticCustomError("literal_error", "no choice")
    return value


@cache
def _model(cls: Hashable, optional: bool) -> type[BaseModel]:
    """Pydantic model of a dataclass; names hide behind aliases so that none can clash."""
    owner = cast(type, cls)
    hints = field_types(owner)
    fields: dict[str, Any] = {}
    for item in dataclasses.fields(owner):
        hint, given = hints[item.name], optional or _has_default(item)
        default = Field(default=None, alias=item.name) if given else Field(alias=item.name)
        if _nested(hint):
            fields[f"f_{item.name}"] = (_model(hint, given), default)
        elif "unit" in item.metadata:
            bounds = item.metadata["low"], item.metadata["high"]
            fields[f"f_{item.name}"] = (_annotated(hint, *bounds), default)
    return create_model(owner.__name__, __config__=CONFIG, **fields)


def _has_default(item: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return item.default is not missing or item.default_factory is not missing


def _nested(hint: Any) -> bool:
    return isinstance(hint, type) and dataclasses.is_dataclass(hint) and hint is not Node


def _input(cls: type, node: Node) -> object:
    """Plain data for the model, but nodes where the dataclass wants the node itself."""
    if not isinstance(node.value, Mapping):
        return plain(node)
    hints = field_types(cls)
    data: dict[str, object] = {}
    for key, child in node.value.items():
        hint = hints.get(key)
        if _wants_node(hint):
            data[key] = child
        else:
            data[key] = _input(hint, child) if _nested(hint) and hint else plain(child)
    return data


def _instance(cls: type, model: BaseModel, default: Any) -> Any:
    """The dataclass from the validated model; what was not given stays with the default."""
    values = {}
    for item in dataclasses.fields(cls):
        if f"f_{item.name}" in model.model_fields_set:
            value = getattr(model, f"f_{item.name}")
            nested = isinstance(value, BaseModel)
            hint = field_types(cls)[item.name]
            base = _default_of(item, default) if nested else None
            values[item.name] = _instance(hint, value, base) if nested else value
    return cls(**values) if default is None else dataclasses.replace(default, **values)


def _default_of(item: dataclasses.Field[Any], owner: Any) -> Any:
    if owner is not None:
        return getattr(owner, item.name)
    if item.default_factory is not dataclasses.MISSING:
        return item.default_factory()
    return None if item.default is dataclasses.MISSING else item.default


def _without_origins(cls: type, node: Node, prefix: str) -> tuple[Node, list[Problem], list[str]]:
    """Numbers written with unit and source become bare numbers.

    Those with a wrong unit are left out, their problems and paths given.
    """
    problems: list[Problem] = []
    wrong: list[str] = []
    entries: dict[str, Node] = {}
    for key, child in node.mapping.items():
        path, item = f"{prefix}{key}", parameter_table(cls).get(f"{prefix}{key}")
        if child.mapping and item is None:
            entries[key], found, deeper = _without_origins(cls, child, f"{path}.")
            problems, wrong = problems + found, wrong + deeper
        elif child.mapping and item is not None and item.type in (int, float):
            entries[key], found = _bare(item, child)
            problems, wrong = problems + found, wrong + ([path] if found else [])
    dropped = [path.removeprefix(prefix) for path in wrong]
    return node.replaced(**entries).without(*dropped), problems, wrong


def _bare(item: Parameter, node: Node) -> tuple[Node, list[Problem]]:
    problems = [
        node.keys[key].problem(f"unknown key {key!r}{suggestion(key, DESCRIBED)}")
        for key in node.mapping
        if key not in DESCRIBED
    ]
    problems += [
        node.problem(f"{item.name}: `{key}:` is missing; {_form(item)}")
        for key in ("value", "unit")
        if key not in node.mapping
    ]
    unit = node.mapping.get("unit", node)
    value = node.mapping.get("value", node)
    if unit is not node and unit.value != item.unit:
        former = former_unit(item, value.value) if unit.value == "-" else ""
        problems.append(
            unit.problem(
                f"{item.name}: found {unit.found()} as its unit; the unit is {item.unit!r}, "
                f"convert it{former}"
            )
        )
    return value, problems


def _form(item: Parameter) -> str:
    return f"write {{value: number, unit: {item.unit!r}, source: text}} or the number alone"


def _problem(cls: type, root: Node, detail: ErrorDetails) -> Problem:
    """One finding of the validator in our words, at its place in the file."""
    path = _path(detail)
    node = _at(root, detail)
    if detail["type"] == "extra_forbidden":
        *parents, name = (part for part in detail["loc"] if isinstance(part, str))
        return unknown_key(cls, root, ".".join(parents), name)  # the name may hold dots itself
    if detail["type"] == "missing":
        item = parameter_table(cls).get(path)
        wanted = f" ({item.doc}): {allowed(item)}" if item else ""
        return node.problem(f"{path!r} is missing{wanted}; add `{path.split('.')[-1]}: ...`")
    if path in parameter_table(cls):
        return node.problem(wrong_value(parameter_table(cls)[path], node))
    return node.problem(expected_mapping(cls, node, path))


def _path(detail: ErrorDetails) -> str:
    return ".".join(part for part in detail["loc"] if isinstance(part, str))


def _at(root: Node, detail: ErrorDetails) -> Node:
    """Node that a finding is about, or the innermost one on the way to it."""
    node = root
    for part in detail["loc"]:
        if isinstance(part, str) and part in node.mapping:
            node = node.mapping[part]
        elif isinstance(part, int) and part < len(node.items):
            node = node.items[part]
    return node


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
