"""Cell by cell: how many more of its seeds the second variant keeps up."""

from __future__ import annotations

from gaitlab.report.cells import row_text
from gaitlab.report.comparison.matching import Matched
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.words import NOTHING, column_text, path_text
from gaitlab.statistics import holm, mcnemar, stratified_exact

LEVEL = 0.05  # two-sided, for all cells together
NOTE = """\
Stable runs more (+) or fewer (-) than the first, of the seeds compared; bold where one cell alone
tells (Holm over the cells in which enough runs differ to tell anything, after Tarone, 1990)."""


def cell_grid(results: Results, runs: Matched) -> str:
    """Table over rows and columns; empty when there is a single cell, or none differs."""
    places = {(k[0], k[1]): part for k, part in runs.parts([results.rows, results.columns]).items()}
    gaps = {place: _gap(part) for place, part in places.items()}
    if len(places) < 2 or not any(gaps.values()):
        return ""
    sure, columns = _sure(places), results.column_values
    rows = [
        [
            row_text(results, row),
            *(_text(places, gaps, sure, (row, c)) for c in results.column_values),
        ]
        for row in results.row_values
        if any((row, column) in places for column in columns)
    ]
    head = "" if results.rows == ONE_ROW else escape(path_text(results.rows))
    titles = [escape(column_text(results, value)) for value in columns]
    return f"{table([head, *titles], rows, 'r')}\n\n{NOTE}"


Place = tuple[object, object]


def _gap(part: Matched) -> float:
    """Stable runs more than the first; without pairs per seed of the first."""
    first, second = part.flags()
    if part.paired:
        return float(second.sum() - first.sum())
    return float(second.mean() - first.mean()) * len(first)


def _text(
    places: dict[Place, Matched], gaps: dict[Place, float], sure: set[Place], place: Place
) -> str:
    if place not in places:
        return NOTHING
    n = len(places[place].first)
    text = f"{gaps[place]:+.2g}/{n}" if gaps[place] else f"0/{n}"
    return f"**{text}**" if place in sure else text


def _sure(places: dict[Place, Matched]) -> set[Place]:
    """Cells that differ for sure. What cannot be significant at its totals is no test."""
    tests = {place: _test(part) for place, part in places.items()}
    able = {place: p for place, (p, least) in tests.items() if least < LEVEL}
    adjusted = holm(list(able.values()))
    return {place for place, p in zip(able, adjusted, strict=True) if p < LEVEL}


def _test(part: Matched) -> tuple[float, float]:
    """p-value of a cell and the least that its totals allow."""
    if not part.paired:
        return _unpaired(part)
    first, second = part.flags()
    test = mcnemar(zip(second.tolist(), first.tolist(), strict=True))
    discordant = test.only_first + test.only_second
    return test.p_value, 2.0 * 0.5**discordant


def _unpaired(part: Matched) -> tuple[float, float]:
    (first, second), *_ = part.counts()
    return stratified_exact([(second, first)]), 0.0
