"""The declarations that files are validated by, as JSON Schema (draft 7), for editors.

A schema says what can be known of a value alone: type, range, names of keys. What hangs on other
files, or on several values together, `gaitlab run -n` says.

References:
    draft-07: Wright, Andrews and Luff, JSON Schema Validation: A Vocabulary for Structural
        Validation of JSON, draft 7, 2018.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterable, Mapping
from types import UnionType
from typing import Any, Literal, TypeAlias, Union, cast, get_args, get_origin

from gaitlab.documents.fields import DESCRIBED, allowed
from gaitlab.documents.nodes import Node
from gaitlab.parameters import Parameter, field_types
from gaitlab.plugins import SUFFIXES, Kind, names

Schema: TypeAlias = dict[str, Any]
DRAFT = "http://json-schema.org/draft-07/schema#"
NUMBERS: Mapping[Any, str] = {float: "number", int: "integer"}
PLAIN: Mapping[Any, str] = {**NUMBERS, bool: "boolean", str: "string"}


def document(title: str, content: Schema, definitions: Mapping[str, Schema]) -> Schema:
    """The schema of a kind of files."""
    defined = {"definitions": dict(definitions)} if definitions else {}
    return {"$schema": DRAFT, "title": title, **content, **defined}


def value_schema(item: Parameter, *, origin: bool = False) -> Schema:
    """What a parameter takes.

    Args:
        item: The parameter.
        origin: Whether it may be written with its unit and source, where it is a number.
    """
    schema = _of_type(item.type)
    if item.type in NUMBERS:
        bounds = {"minimum": item.low, "maximum": item.high}
        schema |= {key: bound for key, bound in bounds.items() if bound is not None}
        if origin:
            schema = {"anyOf": [schema, _with_origin(item, schema)]}
    default = item.default
    if isinstance(default, bool | int | float | str) and default != "":
        schema["default"] = default
    return {**schema, "description": described(item)}


def described(item: Parameter) -> str:
    """Meaning, unit, range and source of a parameter in words."""
    takes = allowed(item)
    known = "" if takes == "a section of the file" else f"; {takes}"
    return f"{item.doc}{known}" + (f". {item.source}" if item.source else "")


def _with_origin(item: Parameter, number: Schema) -> Schema:
    value, unit, source = DESCRIBED
    return {
        "type": "object",
        "properties": {value: number, unit: {"const": item.unit}, source: {"type": "string"}},
        "required": [value, unit],
        "additionalProperties": False,
    }


def _of_type(hint: Any) -> Schema:
    if hint in PLAIN:
        return {"type": PLAIN[hint]}
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Literal:
        return {"enum": list(parts)}
    if hint is Node or Node in parts:
        return {}
    if origin in (Union, UnionType):
        others = [_of_type(part) for part in parts if part is not type(None)]
        return {"anyOf": [*others, {"type": "null"}]}
    if origin is tuple:
        return {"type": "array", "items": _of_type(parts[0])}
    return {"type": "object"} if origin is dict else {}


def object_schema(
    cls: type,
    *,
    further: Mapping[str, Schema] | None = None,
    required: bool = False,
    closed: bool = True,
    leave_out: Collection[str] = (),
) -> Schema:
    """The mapping that `build` makes a dataclass of.

    Args:
        cls: The dataclass; nested dataclasses are nested mappings.
        further: Other keys; they replace those of the dataclass.
        required: Whether what has no default has to stand there.
        closed: Whether other keys are refused.
        leave_out: Fields that a file does not give.
    """
    properties: dict[str, Schema] = {}
    needed: list[str] = []
    for item, made in _fields(cls):
        if item.name in leave_out:
            continue
        properties[item.name] = made
        if item.default is dataclasses.MISSING and item.default_factory is dataclasses.MISSING:
            needed.append(item.name)
    return mapping({**properties, **(further or {})}, needed if required else (), closed=closed)


def _fields(cls: type) -> Iterable[tuple[dataclasses.Field[Any], Schema]]:
    hints = field_types(cls)
    for item in dataclasses.fields(cast(Any, cls)):
        hint = hints[item.name]
        if "unit" in item.metadata:
            made = Parameter(name=item.name, type=hint, default=item.default, **item.metadata)
            yield item, value_schema(made, origin=True)
        elif dataclasses.is_dataclass(hint) and isinstance(hint, type) and hint is not Node:
            yield item, {**object_schema(hint), "description": (hint.__doc__ or "").split("\n")[0]}


def mapping(
    properties: Mapping[str, Schema],
    required: Collection[str] = (),
    *,
    closed: bool = True,
    doc: str = "",
) -> Schema:
    """A mapping with these keys."""
    return {
        "type": "object",
        "properties": dict(properties),
        **({"required": list(required)} if required else {}),
        **({"additionalProperties": False} if closed else {}),
        **({"description": doc} if doc else {}),
    }


def name_schema(kind: Kind, *more: str) -> Schema:
    """A name of a kind that is shipped, as a suggestion, or a file of the user's own.

    Args:
        kind: What is named.
        more: Further names.
    """
    return {"anyOf": [{"enum": [*more, *names(kind)]}, file_schema(*SUFFIXES[kind])]}


def file_schema(*suffixes: str) -> Schema:
    """A file of the user's own, `./mine.py` for instance."""
    return {"type": "string", "pattern": f"[^/]({'|'.join(map(re.escape, suffixes))})$"}


def list_schema(items: Schema, *, least: int = 1, doc: str = "") -> Schema:
    """A list of such values."""
    return {
        "type": "array",
        "items": items,
        "minItems": least,
        **({"description": doc} if doc else {}),
    }


def chosen(condition: Schema, then: Schema, otherwise: Schema | None = None) -> Schema:
    """What holds if a condition does."""
    return {"if": condition, "then": then, **({"else": otherwise} if otherwise else {})}
