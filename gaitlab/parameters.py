"""Fields of a dataclass that an experiment may set: unit, range, meaning and source of each.

A gait, robot, surface or servo is a frozen dataclass whose fields are made with `parameter`.
Everything that reads user files or prints help works from what is declared here. `canonical_json`
is the one spelling of their values, each in its declared type: equal numbers give equal text, which
is what identities are made from.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any, NamedTuple, cast, get_args, get_origin, get_type_hints

from gaitlab.errors import WrongValue


class Former(NamedTuple):
    """A unit that a parameter once had, so that a file which still has it is told what to write.

    Attributes:
        name: What was counted, for instance `ticks of 2 ms`.
        factor: From it to today's unit.
        today: Today's unit in words, for instance `seconds`.
    """

    name: str
    factor: float
    today: str


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """What is known of one field.

    Attributes:
        name: Dotted path below the object, for instance `leg.thigh`.
        type: Its Python type; a `Literal` lists the choices.
        default: Value when nothing is said; `dataclasses.MISSING` when one must be given.
        unit: SI unit, `-` for a ratio or a choice, `rad` for an angle.
        low: Smallest value allowed, None for no bound.
        high: Largest value allowed, None for no bound.
        doc: Meaning, one line.
        source: Where the default comes from; starts with `assumption` or `reconstruction` when
            nobody published it.
        late: Came when results were there already: at its default, which changes nothing, it
            stays out of what a trial is called by.
        former: The unit it once had; None if it always had this one.
        contents_of: The parameter, a file, whose content this one stands for and is filled in from.
            The place of that file is then no part of what a trial is called by.
    """

    name: str
    type: Any
    default: Any = None
    unit: str = "-"
    low: float | None = None
    high: float | None = None
    doc: str
    source: str = ""
    late: bool = False
    former: Former | None = None
    contents_of: str = ""


def parameter(
    default: Any = dataclasses.MISSING,
    *,
    unit: str,
    doc: str,
    low: float | None = None,
    high: float | None = None,
    source: str = "",
    late: bool = False,
    former: Former | None = None,
    contents_of: str = "",
) -> Any:
    """A dataclass field with unit, inclusive range [low, high], meaning and source."""
    metadata = {"unit": unit, "doc": doc, "low": low, "high": high, "source": source}
    rest = {"late": late, "former": former, "contents_of": contents_of}
    return field(default=default, metadata={**metadata, **rest})


@cache
def field_types(cls: Hashable) -> Mapping[str, Any]:
    """Types of a dataclass's fields by name, remembered: as texts they are compiled each time."""
    return get_type_hints(cast(type, cls))


def parameters(cls: type, prefix: str = "") -> Iterator[Parameter]:
    """Every parameter of a dataclass, in order, nested dataclasses by dotted path."""
    hints = field_types(cls)
    for item in dataclasses.fields(cls):
        path, hint = f"{prefix}{item.name}", hints[item.name]
        if "unit" in item.metadata:
            yield Parameter(name=path, type=hint, default=item.default, **item.metadata)
        elif dataclasses.is_dataclass(hint) and isinstance(hint, type):
            yield from parameters(hint, f"{path}.")


def parameter_table(cls: type) -> Mapping[str, Parameter]:
    """Parameters of a dataclass by dotted path, remembered."""
    return _parameter_table(cls)


@cache
def _parameter_table(cls: Hashable) -> Mapping[str, Parameter]:
    return {item.name: item for item in parameters(cast(type, cls))}


def get_path(owner: Any, path: str) -> Any:
    """Value of a dotted path below a nested dataclass."""
    for name in path.split("."):
        owner = getattr(owner, name)
    return owner


def set_path(owner: Any, path: str, value: Any) -> Any:
    """Copy of a nested frozen dataclass in which one dotted path has another value."""
    head, _, rest = path.partition(".")
    if rest:
        value = set_path(getattr(owner, head), rest, value)
    return dataclasses.replace(owner, **{head: value})


Value = bool | int | float | str | None | list[Any]


def values(owner: object) -> dict[str, Value]:
    """Parameters of a dataclass by dotted path, each in its declared type.

    A late parameter at its default is left out, so that older results keep their names.
    """
    table = parameter_table(type(owner))
    given = {path: canonical(item, get_path(owner, path)) for path, item in table.items()}
    return {k: v for k, v in given.items() if not (table[k].late and v == table[k].default)}


def canonical(item: Parameter, value: Any) -> Value:
    """A value in its declared type, so that 1 and 1.0, 0.0 and -0.0 are the same length.

    Raises:
        WrongValue: If it is no finite number.
    """
    if item.type is float and not isinstance(value, bool):
        value = float(value) + 0.0
        if value - value != 0.0:
            raise WrongValue(f"{item.name} is {value}; only finite numbers make a trial")
        return value
    if item.type is int:
        return int(value)
    return list(value) if isinstance(value, tuple | list) else value


def instance(cls: type, given: Mapping[str, Value]) -> Any:
    """Dataclass from its parameters by dotted path, the inverse of `values`.

    Raises:
        WrongValue: If a path is no parameter of the class.
    """
    unknown = sorted(set(given) - set(parameter_table(cls)))
    if unknown:
        raise WrongValue(
            f"{cls.__name__} has no parameter {unknown[0]!r}; another version wrote it"
        )
    hints = field_types(cls)
    return cls(**{name: _built(hints[name], part) for name, part in _grouped(given).items()})


def _grouped(given: Mapping[str, Value]) -> dict[str, Any]:
    groups: dict[str, Any] = {}
    for path, value in given.items():
        head, _, rest = path.partition(".")
        if rest:
            groups.setdefault(head, {})[rest] = value
        else:
            groups[head] = value
    return groups


def _built(hint: Any, value: Any) -> Any:
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return instance(hint, value)
    if not isinstance(value, list):
        return value
    listed = get_origin(hint) is tuple or any(get_origin(part) is tuple for part in get_args(hint))
    return tuple(value) if listed else value


def canonical_json(data: object) -> str:
    """JSON with sorted keys, shortest floats and no NaN: equal data, equal text."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)


def fragment(owner: object) -> str:
    """Canonical JSON of what a dataclass's parameters amount to, wherever its files are.

    Remembered, because trials share their parts.
    """
    try:
        hash(owner)
    except TypeError:
        return canonical_json(_contents(owner))
    return _remembered(owner)


def _contents(owner: object) -> dict[str, Value]:
    """Parameters without the places of files whose content is among them."""
    places = {item.contents_of for item in parameter_table(type(owner)).values()}
    return {path: value for path, value in values(owner).items() if path not in places}


@lru_cache(maxsize=4096)
def _remembered(owner: object) -> str:
    return canonical_json(_contents(owner))
