"""Mappings in a user's file become dataclasses: strict types, ranges, units, known names only.

Whatever is wrong in a mapping is reported at once, each mistake with line and column.
A number is written bare, in the declared SI unit, or with its origin:
`height: {value: 0.050, unit: m, source: "ruler"}`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Hashable, Mapping
from functools import cache
from typing import Annotated, Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

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

from gaitlab.documents.messages import (
    allowed,
    expected_mapping,
    former_unit,
    unknown_key,
    wrong_value,
)
from gaitlab.documents.mistakes import in_order
from gaitlab.documents.nodes import Node, plain
from gaitlab.errors import FileError, GaitlabError, Problem
from gaitlab.parameters import Parameter, parameter_table
from gaitlab.plugins import suggestion

T = TypeVar("T")
CONFIG = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)
DESCRIBED = ("value", "unit", "source")  # keys of a number with its origin


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
    hints = get_type_hints(owner)
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
    hints = get_type_hints(cls)
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
            hint = get_type_hints(cls)[item.name]
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
