"""The largest push and the steepest slope that half of the seeds survive, where they are varied."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf

import numpy as np
import pandas as pd

from gaitlab.report.markdown import escape, table
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import SCORED, cell_of
from gaitlab.report.variants import find_variants, value_text
from gaitlab.report.words import NOTHING, column_text
from gaitlab.statistics import Count, HalfPoint, half_point

# What is harder the farther it is from nothing: the word of the table, and of its two sides.
HARDER: Mapping[str, tuple[str, str, str]] = {
    "push.impulse": ("largest push", "", ""),
    "slope.pitch": ("steepest slope", "uphill", "downhill"),
    "slope.roll": ("steepest slope", "rising to the left", "rising to the right"),
}
FEWEST_LEVELS = 2
HOW_TO_READ = (
    "So much do half of the seeds survive to the end of the trial; in brackets the 95 % interval, "
    "between levels that were tried. Nothing is guessed beyond those."
)


def threshold_tables(results: Results) -> str:
    """A table of each; empty where none is varied, or nothing has been simulated."""
    found = [_table(results, path) for path in HARDER if path in results.trials]
    texts = [text for text in found if text]
    return "\n\n".join([*texts, HOW_TO_READ]) if texts else ""


def _table(results: Results, path: str) -> str:
    """Everything else that is varied down, the columns of the tables across."""
    unit = results.units.get(path, "-")
    across = results.columns if results.columns != path else None
    further = {key for variant in results.variants for key in variant.values}
    known = dict.fromkeys((results.rows, *sorted(further)))
    taken = (path, across, ONE_ROW)
    down = [p for p in known if p not in taken and results.trials[p].nunique(dropna=False) > 1]
    titles = [column_text(results, v) for v in results.column_values] if across else [""]
    title, *sides = HARDER[path]
    body = []
    for label, trials in _groups(results, down):
        values = results.column_values if across else (None,)
        parts = [trials if v is None else trials[trials[across] == v] for v in values]
        for sign, side in zip((1.0, -1.0), sides, strict=True):
            cells = [_text(*_at(part, path, sign), unit) for part in parts]
            if any(cell != NOTHING for cell in cells):
                body.append([escape(", ".join(part for part in (label, side) if part)), *cells])
    return table([f"{title} that half survive", *map(escape, titles)], body, "l") if body else ""


def _groups(results: Results, paths: list[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """Trials that differ in the columns, what is swept and the seed, by what they are called."""
    scored = results.trials[results.trials["state"].isin(SCORED)]
    variants, labels = find_variants(scored, paths, results.units)
    named = np.array(labels, dtype=object)
    for variant in variants:
        yield variant.label, scored[named == variant.label]


def _at(trials: pd.DataFrame, path: str, sign: float) -> tuple[list[float], list[Count]]:
    """Levels to one side, rising from nothing, and how many survived each."""
    levels, counts = [], []
    for level in sorted(abs(v) for v in trials[path].unique() if sign * v >= 0.0):
        cell = cell_of(trials[trials[path] == sign * level])
        levels.append(level)
        counts.append(Count(cell.count(), cell.n))
    return levels, counts


def _text(levels: list[float], counts: list[Count], unit: str) -> str:
    """A threshold with its interval and unit."""
    if len(levels) < FEWEST_LEVELS:
        return NOTHING
    found = half_point(levels, counts)
    measured = "" if unit == "-" else f" {unit}"
    return f"{_value(found, levels)}{measured} {_bounds(found)}"


def _value(found: HalfPoint, levels: list[float]) -> str:
    if found.value == inf:
        return f"≥ {value_text(levels[-1])}"
    return f"< {value_text(levels[0])}" if found.value == -inf else f"{found.value:.2g}"


def _bounds(found: HalfPoint) -> str:
    low, high = found.bounds
    if low == -inf and high == inf:
        return "[open]"
    if low == -inf:
        return f"[up to {value_text(high)}]"
    return f"[from {value_text(low)}]" if high == inf else f"[{value_text(low)}–{value_text(high)}]"
