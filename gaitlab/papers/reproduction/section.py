"""What a section of a reproduction's page is given, and how it declares its options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, Union

from gaitlab.experiment import Experiment
from gaitlab.parameters import Parameter
from gaitlab.report.results import Results
from gaitlab.store import Store

# What an option holds: plain data, lists as tuples.
Value: TypeAlias = Union[bool, int, float, str, "tuple[Value, ...]", "Mapping[str, Value]", None]


@dataclass(frozen=True, kw_only=True)
class Section:
    """What the file says of a section.

    Attributes:
        kind: Name of its file in `sections`.
        title: Heading.
        text: A paragraph in Markdown that stands below the heading; may be empty.
        experiments: Names of the members that it is made from, at least one.
        options: Every option that its kind declares, as given or by default.
        details: Whether it stands on the second page.
    """

    kind: str
    title: str
    text: str
    experiments: tuple[str, ...]
    options: Mapping[str, Value]
    details: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Context:
    """What a section is made from.

    Attributes:
        results: Of each member by the name of its experiment; those of which the store holds
            no trial are left out.
        experiments: Each member by name.
        store: Where the trials are.
        folder: Of the page; figures are saved beside it under names of their own.
    """

    results: Mapping[str, Results]
    experiments: Mapping[str, Experiment]
    store: Store
    folder: Path


def option(
    name: str,
    kind: Any,
    default: Value,
    doc: str,
    *,
    low: float | None = None,
    high: float | None = None,
) -> Parameter:
    """An option that a kind of section takes, for its constant OPTIONS.

    Args:
        name: Key in the file.
        kind: Type of the value: bool, int, float, str, a Literal, `tuple[str, ...]` for a list,
            `dict[str, ...]` for a mapping.
        default: Value when the file says nothing.
        doc: Meaning, one line.
        low: Smallest number allowed.
        high: Largest number allowed.
    """
    return Parameter(
        name=name, type=kind, default=default, unit="-", low=low, high=high, doc=doc, source=""
    )
