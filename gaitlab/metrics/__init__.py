"""Numbers that a trial is judged by: one file each, a pure function of the log.

A metric is a file of this folder with a constant `UNIT` and a function of the file's own name that
takes a `TrialLog`. It reads nothing but the log and raises nothing: what is not defined for a log
is NaN, or None for words. A constant `BETTER`, `higher` or `lower`, says which way a walk gets
better; a metric without it takes no side in a comparison. `COUNTS_FALLS = True` says that a fall
shortens what is measured as it should; other metrics compare only walks that went on. `NEEDS` says
without which of `REQUISITES` it has no value whatever happens. Adding a metric is adding a file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import Literal, TypeAlias, cast, get_type_hints

import numpy as np

from gaitlab.errors import UnknownName, WrongValue
from gaitlab.log import TrialLog
from gaitlab.plugins import Files, user_code, wrong_file

Value: TypeAlias = float | bool | int | str | None
Better: TypeAlias = Literal["higher", "lower", "neither"]

REQUISITES = {  # what a trial may have to have, as the end of a sentence
    "gantry": "a robot on a gantry",
    "couplings": "a robot with belts or gears between joints",
    "force sensors": "a robot with force sensors in its soles",
    "distance": "a gait that is commanded to get ahead",
    "cycle": "a horizon of at least one whole cycle of the gait",
}


_own: dict[str, ModuleType] = {}  # files of the user's own that an experiment has named


@cache
def _shipped() -> dict[str, ModuleType]:
    names = sorted(module.name for module in iter_modules(__path__))
    return {name: import_module(f"{__name__}.{name}") for name in names}


def names() -> tuple[str, ...]:
    """Names of all metrics, sorted."""
    return tuple(sorted({**_shipped(), **_own}))


def take_in(path: Path, files: Files = ()) -> str:
    """Let a file of the user's own answer to its stem, as the files of this folder do to theirs.

    Args:
        path: The file.
        files: Further files that its code is made of, as far as known.

    Raises:
        FileError: If it does not load or is no metric.
    """
    name, module = path.stem, user_code(path, files).module
    if name in _shipped():
        raise wrong_file(path, None, f"{name} is a metric of gaitlab's; give the file another name")
    function = getattr(module, name, None)
    if not callable(function) or not isinstance(getattr(module, "UNIT", None), str):
        form = f'`UNIT = "m"` and `def {name}(log: TrialLog) -> float:`'
        raise wrong_file(path, None, f"is no metric; one holds {form}")
    try:
        kind = get_type_hints(function).get("return")
    except (NameError, TypeError) as error:
        raise wrong_file(path, None, f"an annotation of {name} cannot be read: {error}") from error
    if kind not in (float, int, bool, str):
        raise wrong_file(path, None, f"`def {name}(log)` says no `-> float`, int, bool or str")
    _own[name] = module
    return name


def numeric_names() -> tuple[str, ...]:
    """Names of the metrics that are numbers, neither words nor flags, sorted."""
    kinds = {name: get_type_hints(metric(name))["return"] for name in names()}
    return tuple(name for name, kind in kinds.items() if kind in (float, int))


def metric(name: str) -> Callable[[TrialLog], Value]:
    """The function of one metric.

    Raises:
        UnknownName: If no file answers to the name; lists those that do.
    """
    function: Callable[[TrialLog], Value] = getattr(_module(name), name)
    return function


def unit_of(name: str) -> str:
    """SI unit of a metric, `-` for counts, flags, ratios and words.

    Raises:
        UnknownName: If no file answers to the name; lists those that do.
    """
    return str(_module(name).UNIT)


def better(name: str) -> Better:
    """Which way a metric gets better; `neither` if its file does not say.

    Raises:
        UnknownName: If no file answers to the name; lists those that do.
    """
    return cast(Better, getattr(_module(name), "BETTER", "neither"))


def counts_falls(name: str) -> bool:
    """Whether a metric stays fair when one walk ended in a fall and the other did not.

    Raises:
        UnknownName: If no file answers to the name; lists those that do.
    """
    return bool(getattr(_module(name), "COUNTS_FALLS", False))


def needs(name: str) -> tuple[str, ...]:
    """Those of `REQUISITES` that a metric has no value without.

    Raises:
        UnknownName: If no file answers to the name; lists those that do.
    """
    return tuple(getattr(_module(name), "NEEDS", ()))


def measure(log: TrialLog, own: Sequence[str] = ()) -> dict[str, Value]:
    """Every metric of a log by name, sorted.

    Args:
        log: The log.
        own: Names of the user's own metrics that it is measured by too.

    Raises:
        WrongValue: If one of these gives what is no number, flag or word.
    """
    with np.errstate(all="ignore"):  # a simulation that blew up is measured as NaN
        found = {name: metric(name)(log) for name in sorted([*_shipped(), *own])}
    return {**found, **{name: _plain(name, found[name]) for name in own}}


def _plain(name: str, value: object) -> Value:
    """A value of the user's own metric as one that a store takes; NumPy's numbers are too."""
    plain = value.item() if isinstance(value, np.generic) else value
    if plain is None or isinstance(plain, bool | int | float | str):
        return plain
    raise WrongValue(f"the metric {name} gave {type(value).__name__}; expected a number or a word")


def _module(name: str) -> ModuleType:
    try:
        return {**_shipped(), **_own}[name]
    except KeyError:
        known = ", ".join(names())
        raise UnknownName(f"there is no metric {name!r}; known are {known}") from None
