"""The tables cell by cell, beside a reference table if there is one, with agreement counted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from gaitlab.experiment.reference import ReferenceCell, ReferenceTable
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import Score, ScoredCell
from gaitlab.report.variants import Value, Variant, value_text
from gaitlab.report.words import cell_text, column_text, letter, path_text, share
from gaitlab.statistics import wilson

STEP = "gait.step_length"
DIRECTIONS = ("forward", "backward")


class Compared(NamedTuple):
    """One of our cells beside that of a reference table."""

    place: ReferenceCell
    ours: ScoredCell
    printed: bool


def reference_verdicts(results: Results) -> dict[tuple[str, Value, Value], bool]:
    """Verdict of the reference table by variant label, row and column, where it has one."""
    found = {}
    for variant in results.variants:
        for row in results.row_values:
            for column in results.column_values:
                printed = _printed(results, variant, row, column)
                if printed is not None:
                    found[variant.label, row, column] = printed[1]
    return found


def _printed(
    results: Results, variant: Variant, row: Value, column: Value
) -> tuple[ReferenceCell, bool] | None:
    reference = variant.compare
    if reference is None or results.columns != "surface" or results.rows != reference.content.rows:
        return None
    place = reference.place(float(row), str(column), results.reading)
    return None if place is None else (place, reference.cells[place])


def compared(results: Results, variant: Variant) -> list[Compared]:
    """Cells of a variant that are scored here and printed there."""
    pairs = []
    for row in results.row_values:
        for column in results.column_values:
            printed = _printed(results, variant, row, column)
            cell = results.cell(variant, row, column)
            if printed is not None and cell.n:
                pairs.append(Compared(printed[0], cell, printed[1]))
    return pairs


def agreement(pairs: Sequence[Compared], score: Score = "stable") -> str:
    """Share of cells with the printed verdict, with n and interval; no verdict is another."""
    equal = sum(pair.ours.verdict(score) == pair.printed for pair in pairs)
    return share(equal, len(pairs), wilson(equal, len(pairs)))


def cell_tables(results: Results) -> str:
    """One table a variant and direction, each with its agreement below."""
    blocks = []
    for variant in results.variants:
        for direction, rows in _by_direction(results):
            blocks += _direction_block(results, variant, direction, rows)
    return "\n\n".join(blocks)


def _by_direction(results: Results) -> list[tuple[str, list[Value]]]:
    if results.rows != STEP:
        return [("", list(results.row_values))]
    groups: Mapping[str, list[Value]] = {name: [] for name in DIRECTIONS}
    for row in results.row_values:
        groups["backward" if float(row) < 0 else "forward"].append(row)
    return [(name, rows) for name, rows in groups.items() if rows]


def _direction_block(
    results: Results, variant: Variant, direction: str, rows: Sequence[Value]
) -> list[str]:
    planned = [
        r for r in rows if any(results.cell(variant, r, c).planned for c in results.column_values)
    ]
    if not planned:
        return []
    label = escape(variant.label) if len(results.variants) > 1 else ""
    title = ", ".join(part for part in (direction.capitalize(), label) if part)
    body = [_row(results, variant, row) for row in planned]
    column_titles = [escape(column_text(results, value)) for value in results.column_values]
    grid = table([_row_title(results), *column_titles], body, "r")
    heading = [f"### {title}"] if title else []
    return [*heading, grid, *_agreement_lines(results, variant, direction)]


def _row_title(results: Results) -> str:
    if reference_of(results) is not None:
        return f"as printed ({escape(path_text(results.rows))})"
    return "" if results.rows == ONE_ROW else escape(path_text(results.rows))


def reference_of(results: Results) -> ReferenceTable | None:
    """The first reference table that a variant stands beside, if its rows are those here."""
    tables = (variant.compare for variant in results.variants if variant.compare)
    return next((table for table in tables if table.content.rows == results.rows), None)


def row_text(results: Results, row: Value) -> str:
    """Title of a row: the printed number and the value it stands for, or the value."""
    reference, unit = reference_of(results), " m" if results.rows == STEP else ""
    if reference is None:
        return escape(value_text(row)) + unit
    printed = abs(reference.printed(float(row), results.reading))
    return f"{printed:.4g} ({float(row):.3g}{unit})"


def _row(results: Results, variant: Variant, row: Value) -> list[str]:
    cells = [_marked(results, variant, row, column) for column in results.column_values]
    return [row_text(results, row), *cells]


def _marked(results: Results, variant: Variant, row: Value, column: Value) -> str:
    """Our verdict and the printed one in brackets; bold where they differ."""
    cell = results.cell(variant, row, column)
    printed = _printed(results, variant, row, column)
    text = cell_text(cell)
    if printed is None:
        return text
    text = f"{text} ({letter(printed[1])})"
    return f"**{text}**" if cell.n and cell.verdict() != printed[1] else text


def _agreement_lines(results: Results, variant: Variant, direction: str) -> list[str]:
    pairs = [pair for pair in compared(results, variant) if pair.place.direction == direction]
    if not pairs or variant.compare is None:
        return []
    title = variant.compare.title
    text = (
        f"Cells with the verdict of {title}, {direction}: {agreement(pairs)}; "
        f"by the strict score {agreement(pairs, 'stable_strict')}."
    )
    return [text]


def legend(results: Results) -> str:
    """How to read the cells."""
    text = (
        "Each cell: verdict (S stable, U unstable), seeds that stayed up of those scored, Wilson "
        "interval of that share in percent, and how many fell standing, before their first step. "
        "Where more than half did, the cell says that the robot does not stand, and nothing of the "
        "gait. A ? marks a verdict that rests on a share whose interval holds one half"
    )
    reference = reference_of(results)
    if reference is None:
        return text + "."
    return (
        f"{text}. In brackets is what is printed in {reference.source}; **bold where the two "
        f"differ**. A printed row is read as {reference.readings[results.reading].text}. "
        f"{reference.content.note}"
    ).strip()
