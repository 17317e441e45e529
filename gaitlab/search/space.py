"""The search space of a study as Optuna knows it, and the values that come out of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil, floor, log10
from typing import TypeAlias

import numpy as np
from optuna import Trial
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)

from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Choices, Numbers, Study

DIGITS = 3  # of the range at least that a searched number keeps, so that it can be typed in
Parameter: TypeAlias = Numbers | Choices


def distribution(item: Parameter) -> BaseDistribution:
    """A searched parameter as Optuna knows it."""
    if isinstance(item, Choices):
        return CategoricalDistribution(item.options)
    if item.integer:
        step = int(item.step or 1)
        return IntDistribution(int(item.low), int(item.high), log=item.log, step=step)
    return FloatDistribution(item.low, item.high, log=item.log, step=item.step)


def distributions(study: Study, values: Mapping[str, Value]) -> dict[str, BaseDistribution]:
    """Distributions of the parameters that these values set."""
    return {item.path: distribution(item) for item in study.search if item.path in values}


def ordered(study: Study) -> Iterator[Parameter]:
    """The parameters, each after the one that its condition asks about."""
    waiting, seen = list(study.search), set[str]()
    while waiting:
        ready = [item for item in waiting if item.when is None or item.when.path in seen]
        if not ready:
            raise ValueError(f"conditions of {', '.join(i.path for i in waiting)} form a circle")
        yield from ready
        seen |= {item.path for item in ready}
        waiting = [item for item in waiting if item.path not in seen]


def wanted(item: Parameter, values: Mapping[str, Value]) -> bool:
    """Whether a parameter is searched beside these values."""
    return item.when is None or values.get(item.when.path) in item.when.values


def suggested(study: Study, trial: Trial) -> dict[str, Value]:
    """Values that a sampler proposes, those whose condition does not hold left out."""
    values: dict[str, Value] = {}
    for item in ordered(study):
        if wanted(item, values):
            values[item.path] = rounded(item, _suggest(trial, item))
    return in_order(study, values)


def _suggest(trial: Trial, item: Parameter) -> Value:
    if isinstance(item, Choices):
        return item.options[item.options.index(trial.suggest_categorical(item.path, item.options))]
    if item.integer:
        step, low, high = int(item.step or 1), int(item.low), int(item.high)
        return int(trial.suggest_int(item.path, low, high, step=step, log=item.log))
    return float(trial.suggest_float(item.path, item.low, item.high, step=item.step, log=item.log))


def at(study: Study, place: np.ndarray) -> dict[str, Value]:
    """Values at a place of the unit cube, one coordinate a parameter in the order of the file.

    Args:
        place: Shape (parameters,), each in [0, 1).
    """
    coordinate = dict(zip((item.path for item in study.search), place.tolist(), strict=True))
    values: dict[str, Value] = {}
    for item in ordered(study):
        if wanted(item, values):
            values[item.path] = rounded(item, _stretched(item, coordinate[item.path]))
    return in_order(study, values)


def _stretched(item: Parameter, share: float) -> Value:
    """Value at a share of the range; of whole numbers and choices each has as much room."""
    if isinstance(item, Choices):
        return item.options[int(share * len(item.options))]
    if item.log:
        low, high = (item.low - 0.5, item.high + 0.5) if item.integer else (item.low, item.high)
        value = low * (high / low) ** share
        return min(int(item.high), max(int(item.low), round(value))) if item.integer else value
    step = item.step or (1.0 if item.integer else None)
    if step is None:
        return item.low + share * (item.high - item.low)
    count = floor((item.high - item.low) / step + 1e-9) + 1
    value = item.low + step * int(share * count)
    return round(value) if item.integer else value


def rounded(item: Parameter, value: Value) -> Value:
    """A number without the digits that nobody could type in or set on a robot."""
    if isinstance(item, Choices) or item.integer or not isinstance(value, float):
        return value
    if item.log:
        short = float(f"{value:.{DIGITS + 1}g}")
    else:
        short = round(value, DIGITS + ceil(-log10(item.high - item.low)))
    return min(item.high, max(item.low, short))


def in_order(study: Study, values: Mapping[str, Value]) -> dict[str, Value]:
    """The same values in the order of the file."""
    return {item.path: values[item.path] for item in study.search if item.path in values}


def key(values: Mapping[str, Value]) -> tuple[tuple[str, Value], ...]:
    """What tells two candidates apart."""
    return tuple(sorted(values.items()))


def base_values(experiment: Experiment, study: Study) -> dict[str, Value] | None:
    """The values that the experiment starts from, if the space holds them."""
    values: dict[str, Value] = {}
    for item in ordered(study):
        base = experiment.parts.base_values(item.path)
        if wanted(item, values):
            if len(base) != 1 or not _holds(item, base[0]):
                return None
            values[item.path] = base[0]
    return in_order(study, values)


def _holds(item: Parameter, value: Value) -> bool:
    if isinstance(item, Choices):
        return value in item.options
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    inside = item.low <= value <= item.high
    steps = (value - item.low) / item.step if item.step else 0.0
    return inside and abs(steps - round(steps)) < 1e-6
