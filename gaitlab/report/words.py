"""How values, shares and intervals are written, the same on every page."""

from __future__ import annotations

import math

from gaitlab.report.results import Results
from gaitlab.report.scores import Cell, Score
from gaitlab.report.variants import Value, value_text
from gaitlab.statistics import Interval

NOTHING = "—"  # a cell about which nothing is known


def percent(value: float) -> str:
    """A percentage without digits that n does not carry."""
    return NOTHING if math.isnan(value) else f"{value:.0f} %"


def interval(bounds: Interval, scale: float = 1.0) -> str:
    """An interval in square brackets, whole numbers."""
    return f"[{scale * bounds.low:.0f}–{scale * bounds.high:.0f}]"


def share(count: int, n: int, bounds: Interval) -> str:
    """A proportion: count, n, percent and its interval."""
    return f"{count}/{n}, {percent(100 * count / n)} {interval(bounds, 100)}"


def letter(stable: bool) -> str:
    """S or U, as the tables of the EROS paper print it."""
    return "S" if stable else "U"


def plural(n: int, noun: str) -> str:
    """A count and its noun."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def cell_text(cell: Cell, score: Score = "stable") -> str:
    """Verdict, count and interval of a cell, with everything that did not run."""
    notes = [f"{n} {word}" for n, word in ((cell.failed, "failed"), (cell.missing, "missing")) if n]
    if not cell.n:
        return ", ".join(notes) or NOTHING
    if not cell.feasible:
        return ", ".join([f"INFEASIBLE {cell.infeasible}/{cell.n}", *notes])
    verdict = letter(bool(cell.verdict(score)))
    stalled = cell.count("stable") - cell.count("stable_strict")
    notes = [*([f"{stalled} stalled"] if stalled else []), *notes]
    text = f"{verdict} {cell.count(score)}/{cell.n} {interval(cell.interval(score), 100)}"
    return ", ".join([text, *notes])


def surface_text(name: str) -> str:
    """A surface as a reader calls it: `grass_50mm` becomes `grass 50 mm`."""
    stem = name.rpartition("/")[2].removesuffix(".yaml")
    words = stem.replace("_", " ").split()
    return " ".join(_spaced(word) for word in words)


def _spaced(word: str) -> str:
    number = word.removesuffix("mm")
    return f"{number} mm" if word.endswith("mm") and number.isdigit() else word


def path_text(path: str) -> str:
    """A dotted path as a reader calls it: `gait.step_length` becomes `step length`."""
    return path.rpartition(".")[2].replace("_", " ")


def is_length(path: str) -> bool:
    """Whether a dotted path is a length in [m], by the words it ends with."""
    return path.endswith(("_length", "_height", "_width", "_sway"))


def column_text(results: Results, value: Value) -> str:
    """Title of a column of the tables."""
    if results.columns == "surface":
        return surface_text(str(value))
    return f"{path_text(results.columns)} {value_text(value)}"
