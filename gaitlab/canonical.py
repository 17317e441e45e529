"""The one spelling of a dataclass's parameters: each in its declared type, sorted, as JSON.

Equal numbers give equal text, which is what identities are made from.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, get_args, get_origin, get_type_hints

from gaitlab.errors import WrongValue
from gaitlab.parameters import Parameter, get_path, parameter_table

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
    hints = get_type_hints(cls)
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
    listed = get_origin(hint) is tuple or any(get_origin(part) is tuple for part in get_args(hint))
    return tuple(value) if listed and isinstance(value, list) else value


def canonical_json(data: object) -> str:
    """JSON with sorted keys, shortest floats and no NaN: equal data, equal text."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)


def fragment(owner: object) -> str:
    """Canonical JSON of a dataclass's parameters; remembered, because trials share their parts."""
    try:
        hash(owner)
    except TypeError:
        return canonical_json(values(owner))
    return _remembered(owner)


@lru_cache(maxsize=4096)
def _remembered(owner: object) -> str:
    return canonical_json(values(owner))
