"""How objectives, constraints and searched values are written, the same on every page."""

from __future__ import annotations

import math

from gaitlab.experiment import Value
from gaitlab.experiment.study import Aggregate, Choices, Constraint, Numbers, Objective
from gaitlab.metrics import lookup
from gaitlab.report.variants import value_text
from gaitlab.report.words import path_text, percent
from gaitlab.statistics import Interval

UNKNOWN = "—"
SIGNS = {True: "≥", False: "≤"}


def metric_text(metric: str) -> str:
    """A metric as a reader calls it: `walking_speed` becomes `walking speed`."""
    return metric.replace("_", " ")


def metric_unit(metric: str) -> str:
    """Unit of a metric, empty for a ratio."""
    unit = lookup(metric).unit
    return "" if unit == "-" else unit


def with_unit(text: str, unit: str) -> str:
    """A text followed by its unit in brackets, if it has one."""
    return f"{text} [{unit}]" if unit else text


def objective_axis(objective: Objective) -> str:
    """Label of an axis that holds an objective."""
    return with_unit(metric_text(objective.metric), metric_unit(objective.metric))


def better(objective: Objective) -> str:
    """`larger` or `smaller`, whichever is better."""
    return "larger" if objective.direction == "maximize" else "smaller"


def objective_text(objective: Objective, grounds: int) -> str:
    """An objective in words, for instance `largest walking speed (mean over seeds)`."""
    most = "largest" if objective.direction == "maximize" else "smallest"
    return f"{most} {metric_text(objective.metric)} ({_over(objective, grounds)})"


def constraint_text(constraint: Constraint, grounds: int) -> str:
    """A constraint in words: `walking speed ≥ 0.15 m/s (mean over seeds)`."""
    bound = number(constraint.bound, metric_unit(constraint.metric))
    sign = SIGNS[constraint.at_least]
    return f"{metric_text(constraint.metric)} {sign} {bound} ({_over(constraint, grounds)})"


def _over(asked: Objective | Constraint, grounds: int) -> str:
    """What the numbers are taken over; a single ground needs no word."""
    seeds = _aggregate(asked.over_seeds, "seed")
    return f"{seeds}, {_aggregate(asked.over_surfaces, 'ground')}" if grounds > 1 else seeds


def _aggregate(aggregate: Aggregate, noun: str) -> str:
    if aggregate.kind == "worst":
        return f"worst {noun}"
    if aggregate.kind == "mean":
        return f"mean over {noun}s"
    if aggregate.kind == "quantile":
        return f"{percent(100.0 * aggregate.share)} quantile of the {noun}s from the worst"
    return f"mean of the worst {percent(100.0 * aggregate.share)} of {noun}s"


def number(value: float, unit: str = "") -> str:
    """A number to four digits with its unit; a dash for one that is not known."""
    if not math.isfinite(value):
        return UNKNOWN
    text = value_text(float(value) + 0.0)
    return f"{text} {unit}" if unit else text


def interval(bounds: Interval) -> str:
    """An interval of numbers in square brackets; nothing if an end is not known."""
    known = all(map(math.isfinite, bounds))
    return f"[{bounds.low:.4g}, {bounds.high:.4g}]" if known else ""


def value(shown: Value | None, unit: str = "") -> str:
    """A searched value with its unit."""
    if shown is None:
        return UNKNOWN
    if isinstance(shown, bool):
        return str(shown).lower()
    return shown if isinstance(shown, str) else number(shown, unit)


def range_text(parameter: Numbers | Choices, unit: str) -> str:
    """What a searched parameter may be."""
    if isinstance(parameter, Choices):
        return ", ".join(value(option) for option in parameter.options)
    text = f"{parameter.low:.4g} to {parameter.high:.4g}"
    text += f" {unit}" if unit else ""
    text += f", steps of {parameter.step:.4g}" if parameter.step else ""
    return f"{text}, by ratio" if parameter.log else text


def short_paths(paths: list[str]) -> dict[str, str]:
    """Paths as a reader calls them, the group kept where two would be called the same."""
    names = [path_text(path) for path in paths]
    return {
        path: path.replace(".", " ").replace("_", " ") if names.count(name) > 1 else name
        for path, name in zip(paths, names, strict=True)
    }
