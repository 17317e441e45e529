"""The numbers behind a report as tidy CSV: one row a cell, one row a trial."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from gaitlab.documents.printable import csv_cell
from gaitlab.report.cells import reference_verdicts
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import Score, ScoredCell
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import DOES_NOT_STAND, letter

TIDY = {
    "cells.csv": "one row a cell: counts, shares, 95 % Wilson intervals, verdicts, and if in doubt",
    "trials.csv": "one row a planned trial: varied values, state, every metric, provenance",
}
FIRST = ("trial_id", "experiment", "variant", "surface", "seed", "state", "reason")
SCORES: tuple[tuple[Score, str], ...] = (("stable", ""), ("stable_strict", "_strict"))


def write_tidy(results: Results, folder: Path) -> None:
    """Write cells.csv and trials.csv; the same results give the same bytes."""
    frames = {"cells.csv": cells_frame(results), "trials.csv": trials_frame(results)}
    for name, frame in frames.items():
        _shown(frame).to_csv(folder / name, index=False, lineterminator="\n", encoding="utf-8")


def _shown(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with its texts as a spreadsheet shows them."""
    texts = frame.select_dtypes(["str", "object"])
    cells = {name: [_cell(value) for value in texts[name]] for name in texts}
    return frame.assign(**cells).rename(columns=_cell)


def _cell(value: object) -> object:
    return csv_cell(value) if isinstance(value, str) else value


def trials_frame(results: Results) -> pd.DataFrame:
    """Every planned trial, what identifies it first."""
    trials = results.trials.drop(columns=ONE_ROW, errors="ignore")
    return trials[[*FIRST, *(name for name in trials.columns if name not in FIRST)]]


def cells_frame(results: Results) -> pd.DataFrame:
    """Every planned cell with its counts; rows and columns under their dotted paths."""
    paper = reference_verdicts(results)
    rows = (
        _row(results, variant, row, column, paper.get((variant.label, row, column)))
        for variant in results.variants
        for row in results.row_values
        for column in results.column_values
        if results.cell(variant, row, column).planned
    )
    return pd.DataFrame(rows)


def _row(
    results: Results, variant: Variant, row: Value, column: Value, printed: bool | None
) -> dict[str, object]:
    cell = results.cell(variant, row, column)
    place = {results.rows: row, results.columns: column}
    place.pop(ONE_ROW, None)
    return {
        "variant": variant.label,
        **place,
        "n": cell.n,
        "infeasible": cell.infeasible,
        "fell_standing": cell.standing,
        "failed": cell.failed,
        "missing": cell.missing,
        **dict(_scores(cell)),
        "paper": None if printed is None else letter(printed),
    }


def _scores(cell: ScoredCell) -> Iterator[tuple[str, object]]:
    for score, end in SCORES:
        low, high = cell.interval(score) if cell.n else (None, None)
        yield f"stable{end}", cell.count(score)
        yield f"share{end}", cell.share(score)
        yield f"low{end}", low
        yield f"high{end}", high
        yield f"verdict{end}", _verdict(cell, score)
        yield f"doubtful{end}", cell.doubtful(score)


def _verdict(cell: ScoredCell, score: Score) -> str | None:
    if not cell.n:
        return None
    return letter(bool(cell.verdict(score))) if cell.stands else DOES_NOT_STAND
