"""What an audit of a paper finds, as data, and the page that shows it.

One file a paper in `gaitlab/papers`, each with a function `audit() -> Page`; the name of the file
is the name on the command line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

Cell = str | float | int | None


@dataclass(frozen=True, kw_only=True)
class Erratum:
    """An equation or number found wrong in print.

    Attributes:
        where: Equation, table or figure of the paper.
        printed: What is printed.
        correct: What it has to be.
        effect: Size of the error it causes, with unit, computed.
    """

    where: str
    printed: str
    correct: str
    effect: str


@dataclass(frozen=True, kw_only=True)
class Row:
    """One published number beside ours.

    Attributes:
        label: What it is.
        printed: As published; None where the paper is silent.
        ours: Computed or simulated; None where it cannot be.
        note: Misprint, rounding, why it differs; empty when there is nothing to say.
    """

    label: str
    printed: Cell
    ours: Cell
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A published table, number by number.

    Attributes:
        title: The paper's table and what it shows.
        unit: Unit of both columns, `-` for none.
        digits: Digits after the point that are shown.
        rows: In the paper's order.
    """

    title: str
    unit: str
    digits: int
    rows: Sequence[Row]


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of ours that has no printed numbers beside it.

    Attributes:
        title: What it shows.
        text: What stands above it, Markdown; empty when there is nothing to say.
        header: Titles of the columns.
        rows: Cells as they are shown.
    """

    title: str
    text: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A figure beside the page.

    Attributes:
        name: Name of its file, without ending.
        caption: What it shows.
        draw: Writes the file `name`.svg into a folder.
    """

    name: str
    caption: str
    draw: Callable[[Path, str], object]


@dataclass(frozen=True, kw_only=True)
class Page:
    """The audit of one paper.

    Attributes:
        title: Title of the page.
        paper: The paper, cited in full.
        summary: What agrees, what does not, what cannot be decided; plain sentences.
        comparisons: Published tables beside ours.
        errata: What is wrong in print.
        assumptions: What the paper leaves out and what is assumed here instead.
        tables: Further tables, before what is wrong in print.
        pictures: Figures, after the tables.
    """

    title: str
    paper: str
    summary: str
    comparisons: Sequence[Comparison]
    errata: Sequence[Erratum]
    assumptions: Sequence[tuple[str, str]]
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()


def markdown(page: Page, pictures: str = ".") -> str:
    """The page as Markdown; its pictures are looked for in a folder relative to it."""
    return "\n".join(_lines(page, pictures)) + "\n"


def _lines(page: Page, pictures: str) -> Iterator[str]:
    yield from (f"# {page.title}", "", page.paper, "", page.summary)
    for comparison in page.comparisons:
        yield from ("", f"## {comparison.title}", "")
        yield from _comparison(comparison)
    for table in page.tables:
        yield from _table(table)
    for picture in page.pictures:
        what = picture.caption.partition(":")[0]
        yield from ("", f"![{what}]({pictures}/{picture.name}.svg)", "")
        yield picture.caption
    if page.errata:
        yield from ("", "## Wrong in print", "", "| where | printed | correct | effect |")
        yield "|---|---|---|---|"
        yield from (
            _row(erratum.where, erratum.printed, erratum.correct, erratum.effect)
            for erratum in page.errata
        )
    if page.assumptions:
        yield from ("", "## Left out by the paper", "", "| what | assumed here |", "|---|---|")
        yield from (_row(*assumption) for assumption in page.assumptions)


def _table(table: Table) -> Iterator[str]:
    yield from ("", f"## {table.title}", "")
    if table.text:
        yield from (table.text, "")
    yield _row(*table.header)
    yield "|---" + "|---:" * (len(table.header) - 1) + "|"
    yield from (_row(*row) for row in table.rows)


def _comparison(comparison: Comparison) -> Iterator[str]:
    unit = "" if comparison.unit == "-" else f" [{comparison.unit}]"
    yield f"|  | printed{unit} | ours{unit} | difference{unit} | note |"
    yield "|---|---:|---:|---:|---|"
    for row in comparison.rows:
        numbers = (row.printed, row.ours, _difference(row))
        shown = (_number(number, comparison.digits) for number in numbers)
        yield _row(row.label, *shown, row.note)


def _difference(row: Row) -> Cell:
    if isinstance(row.printed, float | int) and isinstance(row.ours, float | int):
        return row.ours - row.printed
    return None


def _number(value: Cell, digits: int) -> str:
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{round(value, digits) + 0.0:.{digits}f}"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"
