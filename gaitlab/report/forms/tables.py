"""Every table of a page as files of its own: LaTeX to paste into a paper, CSV to compute with.

Beside them the numbers behind a report as tidy CSV: one row a cell, one row a trial.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from markdown_it.token import Token

from gaitlab.documents.printable import csv_cell
from gaitlab.report.cells import reference_verdicts
from gaitlab.report.forms.latex import PACKAGES, latex_table
from gaitlab.report.forms.tokens import (
    PageTable,
    headings,
    page_tables,
    parse,
    plain,
    slug,
    unused,
    whole_text,
)
from gaitlab.report.markdown import code, escape, fenced, table
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import Score, ScoredCell
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import DOES_NOT_STAND, letter

FOLDER = "tables"
COUNTS = {"trials": "{}", "seeds": "Seeds {}"}  # facts that say how much a table rests on
PARAMETERS = "parameter"  # begins a table of settings, which rests on no trial
FIRST, TABLE = "headline", "table"  # names of tables that stand below the title of the page
TIDY = {
    "cells.csv": "one row a cell: counts, shares, 95 % Wilson intervals, verdicts, and if in doubt",
    "trials.csv": "one row a planned trial: varied values, state, every metric, provenance",
}
IDENTIFYING = ("trial_id", "experiment", "variant", "surface", "seed", "state", "reason")
SCORES: tuple[tuple[Score, str], ...] = (("stable", ""), ("stable_strict", "_strict"))


@dataclass(frozen=True, kw_only=True)
class Origin:
    """What a page says of itself.

    Attributes:
        title: Its heading.
        facts: Lines of the tables without titles: digests, trials, seeds, versions.
        commands: Shell lines that make it again.
    """

    title: str
    facts: tuple[str, ...]
    commands: tuple[str, ...]


def write_tables(page: Path, results: Results | None = None) -> list[Path]:
    """Write the tables of a page into `tables/` beside it; the same page gives the same bytes.

    Args:
        page: The page, in Markdown.
        results: What it was computed from, for `cells.csv` and `trials.csv`; None for neither.

    Returns:
        The files, README.md first.
    """
    tokens = parse(whole_text(page))
    folder = page.parent / FOLDER
    folder.mkdir(exist_ok=True)
    named, origin = dict(named_tables(tokens)), origin_of(tokens)
    contents = {name: text for key in named for name, text in _forms(key, named[key], origin)}
    tidy = TIDY if results is not None else {}
    contents = {"README.md": _readme(named, tidy, origin), **contents}
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    if results is not None:
        write_tidy(results, folder)
    return [folder / name for name in (*contents, *tidy)]


def named_tables(tokens: Sequence[Token]) -> Iterator[tuple[str, PageTable]]:
    """Tables that have titles above their columns, each with the name of its files.

    The name is that of the heading above; a further table below the same heading adds the title
    of its first column.
    """
    taken = {slug(Path(name).stem): 0 for name in (*TIDY, "README")}
    anchors: set[str] = set()
    for found in page_tables(tokens):
        if any(plain(title).strip() for title in found.header):
            again = found.heading.anchor in anchors
            anchors.add(found.heading.anchor)
            yield unused(_name(found, again), taken), found


def _name(found: PageTable, again: bool) -> str:
    titled = found.heading.level > 1
    below = slug(found.heading.text) if titled else ""
    first = slug(plain(found.header[0])) if again else ""
    named = "-".join(part for part in (below, first) if part)
    return named or (TABLE if titled or again else FIRST)


def origin_of(tokens: Sequence[Token]) -> Origin:
    """Title, facts and commands of a page."""
    title = next((heading.text for heading in headings(tokens).values()), "")
    lists = [t for t in page_tables(tokens) if not any(plain(c).strip() for c in t.header)]
    facts = [": ".join(plain(cell) for cell in row) for found in lists for row in found.rows]
    shell = [t.content.splitlines() for t in tokens if t.type == "fence" and t.info == "sh"]
    return Origin(title=title, facts=tuple(facts), commands=tuple(shell[-1] if shell else ()))


def _forms(name: str, found: PageTable, origin: Origin) -> Iterator[tuple[str, str]]:
    caption = _caption(found, origin)
    notes = [caption, rf"Needs \usepackage{{{PACKAGES}}}.", *origin.facts]
    again = ["Made again by:", *(f"    {line}" for line in origin.commands)]
    yield f"{name}.tex", latex_table(found, caption, name, [*notes, *again])
    lines = io.StringIO()
    csv.writer(lines, lineterminator="\n").writerows(
        [csv_cell(plain(item)) for item in row] for row in (found.header, *found.rows)
    )
    yield f"{name}.csv", lines.getvalue()


def _caption(found: PageTable, origin: Origin) -> str:
    """What the table is, how to read it, what it is of and n."""
    below = found.heading.text if found.heading.level > 1 else ""
    parts = [below, found.legend, origin.title]
    if plain(found.header[0]) != PARAMETERS:
        facts = dict(line.split(": ", 1) for line in origin.facts if ": " in line)
        parts += [text.format(facts[name]) for name, text in COUNTS.items() if name in facts]
    return " ".join(f"{part.rstrip('.')}." for part in parts if part)


def _what(found: PageTable) -> str:
    if found.heading.level > 1:
        return found.heading.text
    return found.legend or plain(found.header[0])


def _readme(named: dict[str, PageTable], tidy: dict[str, str], origin: Origin) -> str:
    rows = [
        [code(f"{name}.tex"), code(f"{name}.csv"), escape(_what(found))]
        for name, found in named.items()
    ]
    rows += [["", code(name), escape(what)] for name, what in tidy.items()]
    blocks = [
        f"# Tables of {escape(origin.title)}",
        f"The LaTeX needs `\\usepackage{{{PACKAGES}}}`; a CSV beside it has the same cells as "
        "text. Every file is overwritten when the report is written again.",
        table(["LaTeX", "CSV", "what"], rows, "lll"),
        table(["", ""], [_fact(line) for line in origin.facts], "ll") if origin.facts else "",
        fenced("\n".join(origin.commands), "sh") if origin.commands else "",
    ]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _fact(line: str) -> list[str]:
    name, _, value = line.partition(": ")
    return [escape(name), escape(value)]


def write_tidy(results: Results, folder: Path) -> None:
    """Write cells.csv and trials.csv; the same results give the same bytes."""
    frames = {"cells.csv": cells_frame(results), "trials.csv": trials_frame(results)}
    for name, frame in frames.items():
        texts = frame.select_dtypes(["str", "object"])
        cells = {name: [_cell(value) for value in texts[name]] for name in texts}
        shown = frame.assign(**cells).rename(columns=_cell)
        shown.to_csv(folder / name, index=False, lineterminator="\n", encoding="utf-8")


def _cell(value: object) -> object:
    return csv_cell(value) if isinstance(value, str) else value


def trials_frame(results: Results) -> pd.DataFrame:
    """Every planned trial, what identifies it first."""
    trials = results.trials.drop(columns=ONE_ROW, errors="ignore")
    return trials[[*IDENTIFYING, *(name for name in trials.columns if name not in IDENTIFYING)]]


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
