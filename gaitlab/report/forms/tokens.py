"""A page of Markdown taken apart: its headings with anchors and its tables as rows of cells."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

from gaitlab.report.markdown import DETAILS

SECTION = 2  # level of the headings of sections
DIALECT = "commonmark"  # with tables: what code-hosting pages render


@dataclass(frozen=True, kw_only=True)
class Heading:
    """A heading of the page.

    Attributes:
        level: 1 for the title of the page.
        text: What it says, without mark-up.
        anchor: Its id on the page, as code-hosting pages make it.
    """

    level: int
    text: str
    anchor: str


@dataclass(frozen=True, kw_only=True)
class PageTable:
    """A table of the page.

    Attributes:
        heading: What it stands below.
        legend: The paragraph right above it, or how to read the tables of its section.
        header: Titles of the columns.
        rows: Cells.
        align: One letter a column, `l`, `c` or `r`.
    """

    heading: Heading
    legend: str
    header: tuple[Token, ...]
    rows: tuple[tuple[Token, ...], ...]
    align: str


def whole_text(page: Path) -> str:
    """A page and, if it has a second one, that below it as one text."""
    text, second = page.read_text(encoding="utf-8"), page.with_name(DETAILS)
    if page.name == DETAILS or not second.is_file():
        return text
    _, first, rest = second.read_text(encoding="utf-8").partition("\n## ")
    anchor = anchor_of(rest.partition("\n")[0])
    return f"{text.replace(f']({DETAILS})', f'](#{anchor})')}{first}{rest}"


def parser() -> MarkdownIt:
    """The parser of all pages."""
    return MarkdownIt(DIALECT).enable("table")


def parse(markdown: str) -> list[Token]:
    """The page as tokens."""
    return parser().parse(markdown)


def plain(inline: Token) -> str:
    """What a line of text says, without mark-up."""
    breaks = ("softbreak", "hardbreak")
    children = [child for child in inline.children or () if child.type != "html_inline"]
    return "".join(" " if child.type in breaks else child.content for child in children)


def headings(tokens: Sequence[Token]) -> dict[int, Heading]:
    """Headings by the position of their opening token; anchors differ."""
    found: dict[int, Heading] = {}
    taken: dict[str, int] = {}
    for index, token in enumerate(tokens):
        if token.type == "heading_open":
            text = " ".join(plain(tokens[index + 1]).split())
            found[index] = Heading(
                level=int(token.tag[1:]), text=text, anchor=unused(anchor_of(text), taken)
            )
    return found


def anchor_of(text: str) -> str:
    """Id of a heading: letters and digits in lower case, a dash for every space."""
    kept = re.sub(r"[^\w\- ]", "", text.lower())
    return kept.replace(" ", "-") or "section"


def unused(name: str, taken: dict[str, int]) -> str:
    """The name, with a number if it was given before; remembers what it gave."""
    chosen = name
    while chosen in taken:
        taken[name] += 1
        chosen = f"{name}-{taken[name]}"
    taken[chosen] = 0
    return chosen


def slug(text: str) -> str:
    """Text as the name of a file: ASCII letters, digits and dashes, at most 60 characters."""
    folded = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()
    return re.sub(r"[^a-z0-9]+", "-", folded)[:60].strip("-")


def page_tables(tokens: Sequence[Token]) -> Iterator[PageTable]:
    """Every table with what it stands below, in the order of the page."""
    titles = headings(tokens)
    heading = Heading(level=1, text="", anchor="")
    shared = ""  # how to read the tables of a section
    for index, token in enumerate(tokens):
        heading = titles.get(index, heading)
        if token.type == "heading_open" and heading.level <= SECTION:
            shared = _first_paragraph(tokens[index + 3 :])
        if token.type == "table_open":
            above = _paragraph_above(tokens, index)
            rows = list(_rows(tokens[index:]))
            table = PageTable(
                heading=heading,
                legend=(above or (shared if heading.level > SECTION else "")),
                header=tuple(cell for cell, _ in rows[0]),
                rows=tuple(tuple(cell for cell, _ in row) for row in rows[1:]),
                align="".join(letter for _, letter in rows[0]),
            )
            yield table


def _first_paragraph(tokens: Sequence[Token]) -> str:
    """What a section says first; a line that leads to something else is no legend."""
    if len(tokens) < 2 or tokens[0].type != "paragraph_open":
        return ""
    text = plain(tokens[1])
    return "" if text.endswith(":") else text


def _paragraph_above(tokens: Sequence[Token], index: int) -> str:
    if index < 2 or tokens[index - 1].type != "paragraph_close":
        return ""
    return plain(tokens[index - 2]).removesuffix(":")


def _rows(tokens: Iterable[Token]) -> Iterator[list[tuple[Token, str]]]:
    """Rows of the table that the tokens begin with: the text of each cell and its alignment."""
    row: list[tuple[Token, str]] = []
    letter = "l"
    for token in tokens:
        if token.type in ("th_open", "td_open"):
            side = str(token.attrs.get("style", "text-align:left")).rpartition(":")[2]
            letter = {"center": "c", "right": "r"}.get(side, "l")
        elif token.type == "inline":
            row.append((token, letter))
        elif token.type == "tr_close":
            yield row
            row = []
        elif token.type == "table_close":
            return
