"""Numbers that a trial is judged by: a file a family, each metric a pure function of the log.

A metric is a function that takes a `TrialLog`, decorated with `@metric(unit="m", better="higher")`.
Adding one is adding it to a family's file, or naming a file of one's own in an experiment.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from gaitlab.errors import UnknownName, WrongValue
from gaitlab.log import TrialLog
from gaitlab.metrics import balance, energy, feet, joints, stability, travel
from gaitlab.metrics.metric import REQUISITES, Better, Metric, Value, metric
from gaitlab.plugins import Files, user_code, wrong_file

__all__ = [
    "REQUISITES",
    "Better",
    "Metric",
    "Value",
    "lookup",
    "measure",
    "metric",
    "names",
    "numeric_names",
    "take_in",
]

_SHIPPED: dict[str, Metric[Value]] = {
    found.name: found
    for family in (balance, energy, feet, joints, stability, travel)
    for found in vars(family).values()
    if isinstance(found, Metric)
}
_own: dict[str, Metric[Value]] = {}  # from files of the user's own that an experiment has named


def names() -> tuple[str, ...]:
    """Names of all metrics, sorted."""
    return tuple(sorted({**_SHIPPED, **_own}))


def numeric_names() -> tuple[str, ...]:
    """Names of the metrics that are numbers, neither words nor flags, sorted."""
    return tuple(name for name in names() if lookup(name).kind in (float, int))


def lookup(name: str) -> Metric[Value]:
    """The metric of a name.

    Raises:
        UnknownName: If there is none; lists those that there are.
    """
    try:
        return {**_SHIPPED, **_own}[name]
    except KeyError:
        known = ", ".join(names())
        raise UnknownName(f"there is no metric {name!r}; known are {known}") from None


def measure(log: TrialLog, own: Sequence[str] = ()) -> dict[str, Value]:
    """Every metric of a log by name, sorted.

    Args:
        log: The log.
        own: Names of the user's own metrics that it is measured by too.

    Raises:
        WrongValue: If one of these gives what is no number, flag or word.
    """
    with np.errstate(all="ignore"):  # a simulation that blew up is measured as NaN
        found = {name: lookup(name)(log) for name in sorted([*_SHIPPED, *own])}
    return {**found, **{name: _plain(name, found[name]) for name in own}}


def _plain(name: str, value: object) -> Value:
    """A value of the user's own metric as one that a store takes; NumPy's numbers are too."""
    plain = value.item() if isinstance(value, np.generic) else value
    if plain is None or isinstance(plain, bool | int | float | str):
        return plain
    raise WrongValue(f"the metric {name} gave {type(value).__name__}; expected a number or a word")


def take_in(path: Path, files: Files = ()) -> str:
    """Let the metric in a file of the user's own answer to the file's stem.

    It is decorated as those of gaitlab are, or stands beside `UNIT = "m"` and maybe `BETTER`,
    `COUNTS_FALLS` and `NEEDS`.

    Args:
        path: The file.
        files: Further files that its code is made of, as far as known.

    Raises:
        FileError: If it does not load or is no metric.
    """
    name, module = path.stem, user_code(path, files).module
    if name in _SHIPPED:
        raise wrong_file(path, None, f"{name} is a metric of gaitlab's; give the file another name")
    found, unit = getattr(module, name, None), getattr(module, "UNIT", None)
    if callable(found) and not isinstance(found, Metric) and isinstance(unit, str):
        better = cast(Better, getattr(module, "BETTER", "neither"))
        counts = bool(getattr(module, "COUNTS_FALLS", False))
        found = Metric(found, unit, better, counts, tuple(getattr(module, "NEEDS", ())))
    if not isinstance(found, Metric):
        form = f'`@metric(unit="m")` over `def {name}(log: TrialLog) -> float:`'
        raise wrong_file(path, None, f"is no metric; one holds {form}")
    try:
        kind = found.kind
    except (NameError, TypeError) as error:
        raise wrong_file(path, None, f"an annotation of {name} cannot be read: {error}") from error
    if kind is type(None):
        raise wrong_file(path, None, f"`def {name}(log)` says no `-> float`, int, bool or str")
    _own[name] = found
    return name
