"""The tables of stability: the headline, and cell by cell, beside a reference table if any."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isnan, nan
from typing import NamedTuple

from gaitlab.experiment.reference import ReferenceCell, ReferenceTable
from gaitlab.report.comparison import Comparison, difference, loud
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import (
    Score,
    ScoredCell,
    efficiency_draws,
    interval_of,
    mean_percent,
    surface_percent,
)
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import (
    DOES_NOT_STAND,
    NOTHING,
    cell_text,
    column_text,
    interval,
    letter,
    path_text,
    percent,
    plural,
    share,
    with_unit,
)
from gaitlab.statistics import efficiency, stability_percent, wilson

CELLS = "Cell by cell"  # title of the section with the tables of cells
DO_NOT_STAND = (DOES_NOT_STAND, "do not stand")  # of one cell, of several
MOST_DIFFERENCES = 3  # rows of the first table; more are on the second page
SCORES: tuple[tuple[Score, str], ...] = (("stable", ""), ("stable_strict", ", strict"))
STEP = "gait.step_length"
DIRECTIONS = ("forward", "backward")


def headline(results: Results) -> str:
    """Share of stable cells of each column and their mean, one row a variant and score."""
    header = ["", *_titles(results), f"efficiency [{95} % interval]"]
    ours = [
        _score_row(results, variant, score, f"{escape(variant.label)}{suffix}")
        for variant in results.variants
        for score, suffix in SCORES
    ]
    return table(header, [*ours, *reference_rows(results)], "l")


def _titles(results: Results) -> list[str]:
    return [escape(column_text(results, value)) for value in results.column_values]


def _score_row(results: Results, variant: Variant, score: Score, label: str) -> list[str]:
    columns = results.by_column(variant)
    cells = [_percent_text(cells, score) for cells in columns]
    return [label, *cells, _efficiency_text(columns, score)]


def _percent_text(cells: Sequence[ScoredCell], score: Score) -> str:
    known = [cell for cell in cells if cell.n]
    stable = sum(bool(cell.verdict(score)) for cell in known)
    if not known:
        return NOTHING
    fallen = _fallen(known)
    count = f"{stable}/{len(known)}" + (f", {fallen} {DO_NOT_STAND[fallen > 1]}" if fallen else "")
    return f"{percent(surface_percent(cells, score))} ({count})"


def _fallen(cells: Sequence[ScoredCell]) -> int:
    """Cells in which the robot does not stand."""
    return sum(not cell.stands for cell in cells)


def _efficiency_text(columns: Sequence[Sequence[ScoredCell]], score: Score) -> str:
    if not any(cell.n for cells in columns for cell in cells):
        return NOTHING
    bounds = interval_of(efficiency_draws(columns, score))
    text = f"{percent(mean_percent(columns, score))} {interval(bounds)}"
    fallen = _fallen([cell for cells in columns for cell in cells])
    text += f"; {plural(fallen, 'cell')} {DO_NOT_STAND[fallen > 1]}" if fallen else ""
    feasible = [[cell for cell in cells if cell.feasible] for cells in columns]
    if feasible == [list(cells) for cells in columns]:
        return text
    return f"{text}; {percent(mean_percent(feasible, score))} of the cells within reach"


def reference_rows(results: Results) -> list[list[str]]:
    """What is printed elsewhere: as stated, as counted, and counted over the cells here too."""
    tables = reference_tables(results)
    surfaces = [str(value) for value in results.column_values]
    if not tables or results.columns != "surface":
        return []
    stated, means = [t.stated for t in tables], [t.content.stated_mean for t in tables]
    counted, same = [t.counted for t in tables], [_same_cells(results, t) for t in tables]
    rows = [
        _reference_row("printed, counted", counted, surfaces, [t.counted_mean for t in tables]),
        _reference_row("printed, our rows only", same, surfaces, [_mean(v) for v in same]),
    ]
    if not any(stated):
        return rows
    known = [nan if mean is None else mean for mean in means]
    return [_reference_row("printed, stated", stated, surfaces, known), *rows]


def reference_tables(results: Results) -> list[ReferenceTable]:
    """Those that the variants stand beside, each once, in the order of their names."""
    found = {v.compare.name: v.compare for v in results.variants if v.compare is not None}
    return [found[name] for name in sorted(found)]


def _reference_row(
    label: str,
    tables: Sequence[Mapping[str, float]],
    surfaces: Sequence[str],
    efficiencies: Sequence[float],
) -> list[str]:
    cells = [_arrow([values.get(surface, nan) for values in tables]) for surface in surfaces]
    return [label, *cells, _arrow(efficiencies)]


def _same_cells(results: Results, reference: ReferenceTable) -> dict[str, float]:
    """Percentage of stable cells of a table, of those cells that were planned here too."""
    chosen = {variant.label for variant in results.variants if variant.compare is reference}
    cells: dict[str, list[bool]] = {}
    for (label, _, surface), verdict in reference_verdicts(results).items():
        if label in chosen:
            cells.setdefault(str(surface), []).append(verdict)
    return {surface: stability_percent(verdicts) for surface, verdicts in cells.items()}


def _mean(percents: Mapping[str, float]) -> float:
    return efficiency(list(percents.values()))


def _arrow(values: Sequence[float]) -> str:
    if any(isnan(value) for value in values):
        return NOTHING
    return " → ".join(f"{value:.0f}" for value in values) + " %"


def runs_table(results: Results, compared: Sequence[Comparison] = ()) -> str:
    """Runs still on their feet at the end, of all scored runs, with Wilson intervals.

    Below them the differences of a few variants to the first, by column and over all.
    """
    header = ["runs not fallen", *_titles(results), "all"]
    rows = []
    for variant in results.variants:
        columns = results.by_column(variant)
        every = [cell for cells in columns for cell in cells]
        rows.append([escape(variant.label), *map(_runs_text, columns), _runs_text(every)])
    shown = compared if len(compared) <= MOST_DIFFERENCES else ()
    rows += [_difference_row(results, item) for item in shown if item.stable.n]
    return table(header, rows, "l")


def _difference_row(results: Results, item: Comparison) -> list[str]:
    cells = [item.columns.get(value) for value in results.column_values]
    label = f"*{escape(item.second)}* less *{escape(item.first)}*"
    told = f"{difference(item.stable)}: {loud(item.stable)}"
    return [label, *(difference(cell) if cell else NOTHING for cell in cells), told]


def _runs_text(cells: Sequence[ScoredCell]) -> str:
    n = sum(cell.n for cell in cells)
    count = sum(cell.count() for cell in cells)
    return share(count, n, wilson(count, n)) if n else NOTHING


HOW_TO_READ = """\
A run is stable when the robot did not fall within the horizon; *strict* also asks for half of the
commanded distance, so a robot that stays up without getting anywhere does not pass. A cell is
stable when at least half of its seeds are; a percentage is the share of stable cells (count/cells)
and efficiency its mean over the columns. A cell whose steps are out of reach counts as not stable,
and so does one in which more than half of the seeds fell before their first step: there the robot
does not stand, and nothing is said of its gait.
The interval of the efficiency follows from the seeds alone (cells fixed, each cell's share drawn
from its Jeffreys posterior); the intervals of shares are Wilson's. All hold 95 %."""

PRINTED_ROWS = """\
The printed rows read from the first table to the last: the percentages that the text states, those
counted from the printed cells, and those counted over the cells that are here too."""


def verdicts_note(results: Results) -> str:
    """How many verdicts there are, and how many of them the seeds leave open."""
    cells = [cell for v in results.variants for cells in results.by_column(v) for cell in cells]
    known = [cell for cell in cells if cell.n and cell.feasible]
    open_ = sum(cell.doubtful() for cell in known)
    if not open_:
        return ""
    return (
        f"**{open_} of {plural(len(known), 'verdict')} {'rests' if open_ == 1 else 'rest'} on a "
        "share whose 95 % interval holds one half** (marked ? in the tables): other seeds could "
        "turn them."
    )


def seeds_text(results: Results) -> str:
    """How many seeds a cell has, `10 seeds a cell` or a range."""
    sizes = [
        cell.planned
        for variant in results.variants
        for cells in results.by_column(variant)
        for cell in cells
    ]
    low, high = min(sizes), max(sizes)
    count = f"{low}" if low == high else f"{low} to {high}"
    return f"{count} {'seed' if high == 1 else 'seeds'} a cell"


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


def cells_in_order(results: Results) -> Iterator[tuple[Variant, Value, Value]]:
    """Variant, row and column of every cell of the tables, as they are read."""
    for variant in results.variants:
        for _, rows in _by_direction(results):
            for row in _planned(results, variant, rows):
                for column in results.column_values:
                    yield variant, row, column


def _planned(results: Results, variant: Variant, rows: Sequence[Value]) -> list[Value]:
    """The rows in which a variant has any cell."""
    columns = results.column_values
    return [r for r in rows if any(results.cell(variant, r, c).planned for c in columns)]


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
    planned = _planned(results, variant, rows)
    if not planned:
        return []
    label = escape(variant.label) if len(results.variants) > 1 else ""
    title = ", ".join(part for part in (direction.capitalize(), label) if part)
    body = []
    for row in planned:
        cells = [_marked(results, variant, row, column) for column in results.column_values]
        body.append([escape(row_title(results, row)), *cells])
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


def row_title(results: Results, row: Value) -> str:
    """Title of a row: the printed number and the value it stands for, or the value."""
    reference, value = reference_of(results), with_unit(results, results.rows, row)
    if reference is None:
        return value
    printed = abs(reference.printed(float(row), results.reading))
    return f"{printed:.4g} ({value})"


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
