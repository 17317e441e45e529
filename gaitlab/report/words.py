"""How values, shares and intervals are written, the same on every page."""

from __future__ import annotations

import math

from gaitlab.render.figure_style import surface_text
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import Score, ScoredCell
from gaitlab.report.variants import Value, value_text
from gaitlab.statistics import Interval

DOES_NOT_STAND = "does not stand"
NOTHING = "—"  # a cell about which nothing is known


def percent(value: float) -> str:
    """A percentage without digits that n does not carry."""
    return NOTHING if math.isnan(value) else f"{value:.0f} %"


def interval(bounds: Interval, scale: float = 1.0) -> str:
    """An interval in square brackets, whole numbers."""
    between = "–" if bounds.low >= 0.0 else ", "  # a dash beside a minus reads badly
    return f"[{scale * bounds.low:.0f}{between}{scale * bounds.high:.0f}]"


def share(count: int, n: int, bounds: Interval) -> str:
    """A proportion: count, n, percent and its interval."""
    return f"{count}/{n}, {percent(100 * count / n)} {interval(bounds, 100)}"


def letter(stable: bool) -> str:
    """S for stable, U for unstable."""
    return "S" if stable else "U"


def plural(n: int, noun: str) -> str:
    """A count and its noun."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def verdict_text(cell: ScoredCell, score: Score = "stable") -> str:
    """S or U, or that the robot does not stand; with a mark where the share may be either."""
    word = letter(bool(cell.verdict(score))) if cell.stands else DOES_NOT_STAND
    return word + ("?" if cell.doubtful(score) else "")


def cell_text(cell: ScoredCell, score: Score = "stable") -> str:
    """Verdict, count and interval of a cell, with everything that did not run."""
    notes = [f"{n} {word}" for n, word in ((cell.failed, "failed"), (cell.missing, "missing")) if n]
    if not cell.n:
        return ", ".join(notes) or NOTHING
    if not cell.feasible:
        return ", ".join([f"INFEASIBLE {cell.infeasible}/{cell.n}", *notes])
    stalled = cell.count("stable") - cell.count("stable_strict")
    counted = ((cell.standing, "fell standing"), (stalled, "stalled"))
    notes = [*(f"{n} {word}" for n, word in counted if n), *notes]
    count = f"{cell.count(score)}/{cell.n} {interval(cell.interval(score), 100)}"
    return ", ".join([f"{verdict_text(cell, score)} {count}", *notes])


def path_text(path: str) -> str:
    """A dotted path as a reader calls it: `gait.step_length` becomes `step length`."""
    return path.rpartition(".")[2].replace("_", " ")


def axis_text(results: Results, path: str) -> str:
    """A dotted path as the label of an axis, with its unit if it has one."""
    unit = results.units.get(path, "-")
    return path_text(path) + (f" [{unit}]" if unit != "-" else "")


def with_unit(results: Results, path: str, value: Value) -> str:
    """A value of a dotted path, with its unit if it has one; a ground by its title."""
    if path == "surface":
        return surface_text(str(value))
    unit = results.units.get(path, "-")
    return value_text(value) + (f" {unit}" if unit != "-" else "")


def place_text(results: Results, row: Value, column: Value) -> str:
    """The cell of a row and a column: `grass 30 mm, step length 0.04 m`."""
    place = column_text(results, column)
    if results.rows in (ONE_ROW, "surface"):
        return place if results.rows == ONE_ROW else f"{surface_text(str(row))}, {place}"
    return f"{place}, {path_text(results.rows)} {with_unit(results, results.rows, row)}"


def column_text(results: Results, value: Value) -> str:
    """Title of a column of the tables."""
    if results.columns == "surface":
        return surface_text(str(value))
    return f"{path_text(results.columns)} {value_text(value)}"
