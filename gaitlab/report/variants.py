"""Which variants an experiment has, their names and the reference table each stands beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from gaitlab.experiment.reference import ReferenceTable
from gaitlab.plugins import shown

PLAIN = "plain"
NO_UNITS: Mapping[str, str] = {}
TYPED = 9  # digits that somebody may have typed; a computed number has more
Value = float | int | bool | str


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One combination of everything an experiment varies besides rows, columns and seed.

    Attributes:
        label: Its name in tables and figures.
        values: Dotted path to value.
        compare: Reference table that it stands beside; None for none.
    """

    label: str
    values: Mapping[str, Value] = field(default_factory=dict)
    compare: ReferenceTable | None = None


def label_of(
    values: Mapping[str, Value], shared: Sequence[str] = (), units: Mapping[str, str] = NO_UNITS
) -> str:
    """Name of a variant: what is switched on, `plain` if nothing is.

    Parameters in `shared` take only one value beside `none` and are named without it. Numbers have
    the units of their paths.
    """
    parts = [
        _part(path, value, path in shared, units.get(path, "-")) for path, value in values.items()
    ]
    return " + ".join(part for part in parts if part) or PLAIN


def _part(path: str, value: Value, bare: bool, unit: str) -> str:
    named = path.removesuffix(".type").removesuffix(".name")  # `engine.name` is what engine it is
    name = named.rpartition(".")[2].replace("_", " ")
    if is_off(value):
        return ""
    if path == "experiment":
        return str(value)
    if bare or value is True:
        return name
    measured = unit != "-" and not isinstance(value, (bool, str))
    return f"{name} {value_text(value)}" + (f" {unit}" if measured else "")


def is_off(value: object) -> bool:
    """Whether a parameter says that it does nothing; a length of 0 is a length."""
    return value is False or value is None or (isinstance(value, str) and value == "none")


def value_text(value: object) -> str:
    """A value as a reader writes it: as it was typed, or if it was computed to four digits."""
    if not isinstance(value, (float, np.floating)):
        return shown(str(value))
    short, typed = f"{value:.4g}", f"{value:.{TYPED}g}"
    return typed if float(typed) == value != float(short) else short


def free_paths(trials: pd.DataFrame, candidates: Sequence[str], fixed: Sequence[str]) -> list[str]:
    """Candidates that vary on their own: neither constant nor given by the columns `fixed`."""
    groups = [part for _, part in trials.groupby(list(fixed), sort=False)]
    free = (p for p in candidates if any(part[p].nunique(dropna=False) > 1 for part in groups))
    return [path for path in free if path not in fixed]


def find_variants(
    trials: pd.DataFrame, paths: Sequence[str], units: Mapping[str, str] = NO_UNITS
) -> tuple[list[Variant], list[str]]:
    """The combinations of `paths`, the plain one first, and the label of every trial."""
    shared = [path for path in paths if _switched_only(trials[path])]
    records = [dict(zip(paths, row, strict=True)) for row in trials[list(paths)].to_numpy(object)]
    labels = [label_of(record, shared, units) for record in records]
    pairs = zip(labels, records, strict=True)
    variants = {label: Variant(label=label, values=record) for label, record in pairs}
    return sorted(variants.values(), key=lambda variant: variant.label != PLAIN), labels


def _switched_only(values: pd.Series) -> bool:
    """Whether a parameter is either off or at one value."""
    kinds = set(values.to_numpy(object))
    return any(is_off(v) for v in kinds) and sum(not is_off(v) for v in kinds) == 1
