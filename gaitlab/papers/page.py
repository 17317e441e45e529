"""What an audit of a paper finds, as data, and the page that shows it.

One file a paper in `gaitlab/papers`, each with a function `audit() -> Page`; its name is the name
on the command line. What nobody computes of a page, its errata with their wording among it, is
`printed/<paper>.yaml`; an erratum there names the function that computes its effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from gaitlab.documents import Node, load
from gaitlab.parameters import Parameter
from gaitlab.report.markdown import image, section, table

Cell = str | float | int | None
Numbers = Mapping[str, object]
PRINTED = Path(__file__).parent / "printed"


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
class PrintedNumber:
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
class PrintedTable:
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
    rows: Sequence[PrintedNumber]


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
        draw: Writes the file `name`.png into a folder.
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
    comparisons: Sequence[PrintedTable]
    errata: Sequence[Erratum]
    assumptions: Sequence[tuple[str, str]]
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()


@cache
def _written(paper: str) -> Mapping[str, Node]:
    """What `printed/<paper>.yaml` holds."""
    return load(PRINTED / f"{paper}.yaml").mapping


def text_of(paper: str, key: str, **numbers: object) -> str:
    """`title`, `paper` or `summary` of a paper, its numbers filled in."""
    return str(_written(paper)[key].value).strip().format(**numbers)


def errata_of(paper: str, module: ModuleType) -> list[Erratum]:
    """Every mistake of a paper's file, in its order, the functions taken from a module."""
    return [Erratum(**filled) for filled in _filled(paper, "errata", module)]


def assumptions_of(paper: str, module: ModuleType | None = None) -> list[tuple[str, str]]:
    """What a paper leaves out and what is assumed instead, as its file has it."""
    return [(each["what"], each["assumed"]) for each in _filled(paper, "assumptions", module)]


def default_text(item: Parameter) -> str:
    """Default of a parameter with its unit, if it has one."""
    shown = f"{item.default:.4g}" if isinstance(item.default, float) else str(item.default)
    return shown if item.unit == "-" else f"{shown} {item.unit}"


def _filled(paper: str, key: str, module: ModuleType | None) -> Iterator[dict[str, str]]:
    for item in _written(paper)[key].items:
        texts = {name: str(node.value).strip() for name, node in item.mapping.items()}
        function = texts.pop("numbers", None)
        numbers: Numbers = getattr(module, function)() if function else {}
        yield {name: text.format(**numbers) for name, text in texts.items()}


def matrix(
    title: str,
    text: str,
    columns: Sequence[str],
    rows: Mapping[str, tuple[np.ndarray, np.ndarray]],
    bold: Callable[[str, int], bool],
) -> Table:
    """A printed table as it is laid out, in brackets how far ours lies from each number.

    Args:
        title: The paper's table and what it shows.
        text: What stands above it.
        columns: Titles of the columns of numbers.
        rows: Printed numbers and ours, by the title of the row.
        bold: Whether the cell of a row and a column is a misprint.
    """
    body = []
    for name, (printed, ours) in rows.items():
        off = np.round(ours - printed, 2) + 0.0
        cells = [f"{p:.2f} ({q:+.2f})" for p, q in zip(printed, off, strict=True)]
        body.append([name, *(f"**{c}**" if bold(name, j) else c for j, c in enumerate(cells))])
    return Table(title=title, text=text, header=["", *columns], rows=body)


def markdown(page: Page, pictures: str = ".") -> str:
    """The page as Markdown; its pictures are looked for in a folder relative to it."""
    blocks = [
        f"# {page.title}",
        page.paper,
        page.summary,
        *(section(item.title, _comparison(item)) for item in page.comparisons),
        *(section(item.title, item.text, _table(item.header, item.rows)) for item in page.tables),
        *(_picture(item, pictures) for item in page.pictures),
    ]
    if page.errata:
        wrong = [(item.where, item.printed, item.correct, item.effect) for item in page.errata]
        head = ("where", "printed", "correct", "effect")
        blocks.append(section("Wrong in print", _table(head, wrong, "llll")))
    if page.assumptions:
        left_out = _table(("what", "assumed here"), page.assumptions, "ll")
        blocks.append(section("Left out by the paper", left_out))
    return "\n\n".join(block for block in blocks if block) + "\n"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], align: str = "") -> str:
    """A table of cells that may hold mark-up; empty without rows."""
    if not rows:
        return ""
    cells = [[cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    return table(header, cells, align or "l".ljust(len(header), "r"))


def _picture(picture: Picture, folder: str) -> str:
    what = picture.caption.partition(":")[0]
    return f"{image(what, f'{folder}/{picture.name}.png')}\n\n{picture.caption}"


def _comparison(comparison: PrintedTable) -> str:
    unit = "" if comparison.unit == "-" else f" [{comparison.unit}]"
    header = ["", f"printed{unit}", f"ours{unit}", f"difference{unit}", "note"]
    rows = []
    for row in comparison.rows:
        numbers = (row.printed, row.ours, _difference(row))
        rows.append([row.label, *(_number(n, comparison.digits) for n in numbers), row.note])
    return _table(header, rows, "lrrrl")


def _difference(row: PrintedNumber) -> Cell:
    if isinstance(row.printed, float | int) and isinstance(row.ours, float | int):
        return row.ours - row.printed
    return None


def _number(value: Cell, digits: int) -> str:
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{round(value, digits) + 0.0:.{digits}f}"
