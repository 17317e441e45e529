"""SI units of the columns of the view `trials`, and which columns are numbers though all miss."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from gaitlab.errors import GaitlabError
from gaitlab.metrics import lookup
from gaitlab.metrics import names as metric_names
from gaitlab.model.servo import Servo
from gaitlab.model.settings import SETTINGS
from gaitlab.parameters import Parameter, parameter_table
from gaitlab.plugins import CodeKind, load_class
from gaitlab.plugins import names as plugin_names
from gaitlab.surfaces import SURFACE_TYPES

if TYPE_CHECKING:
    import pandas as pd

SECTIONS = {"servo": Servo, **SETTINGS}
PLUGGED: tuple[CodeKind, ...] = ("gait", "robot", "balance")
NO_UNIT = "-"


def units(trials: pd.DataFrame, known: Mapping[str, str] | None = None) -> dict[str, str]:
    """SI unit of every column that has numbers, `-` for counts, flags and ratios.

    Args:
        trials: Columns as of `Store.table`.
        known: Units of parameters of a team's own code, by dotted path; of those that a table
            alone knows, the shipped robots, gaits and surfaces say it.
    """
    measured = metric_names()
    found = {name: lookup(name).unit for name in trials if name in measured}
    for path in trials.columns:
        if "." in path and (item := _parameter(path, trials)) is not None:
            found[path] = NO_UNIT if item.unit == "file" else item.unit
    found.update(known or {})
    return {name: found[name] for name in trials.columns if name in found}


def _parameter(path: str, trials: pd.DataFrame) -> Parameter | None:
    """What shipped code declares of a dotted path; None if none of it does."""
    group, _, rest = path.partition(".")
    for cls in _classes(group, trials):
        if rest in (table := parameter_table(cls)):
            return table[rest]
    return None


def _classes(group: str, trials: pd.DataFrame) -> Iterable[type]:
    if group in SECTIONS:
        yield SECTIONS[group]
    if group == "surface":
        yield from SURFACE_TYPES.values()
    for kind in PLUGGED:
        if kind == group and kind in trials.columns:
            for name in trials[kind].dropna().unique():
                if name in plugin_names(kind):
                    with suppress(GaitlabError):
                        yield load_class(kind, name)


def is_number(name: str) -> bool:
    """Whether a column is a metric whose values are numbers, be there any or not."""
    return name in metric_names() and lookup(name).kind in (float, int)
