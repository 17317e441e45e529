"""Fields of a dataclass that an experiment may set: unit, range, meaning and source of each.

A gait, robot, surface or servo is a frozen dataclass whose fields are made with `parameter`.
Everything that reads user files or prints help works from what is declared here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple, cast, get_type_hints


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
) -> Any:
    """A dataclass field with unit, inclusive range [low, high], meaning and source."""
    metadata = {"unit": unit, "doc": doc, "low": low, "high": high, "source": source}
    return field(default=default, metadata={**metadata, "late": late, "former": former})


def parameters(cls: type, prefix: str = "") -> Iterator[Parameter]:
    """Every parameter of a dataclass, in order, nested dataclasses by dotted path."""
    hints = get_type_hints(cls)
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
