"""Markdown that a code-hosting page renders: tables, images, escaped text of users."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from gaitlab.documents.printable import visible

DETAILS = "details.md"  # second page of a report, beside the first
_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~$!&])")


def escape(text: str) -> str:
    """Text that stands as it is written: one line, no mark-up, no HTML, no cell borders."""
    line = _SPECIAL.sub(r"\\\1", visible(" ".join(str(text).split())))
    line = re.sub(r"^([-+=])(?!\d)", r"\\\1", line)  # a list or a rule, but not a number
    return re.sub(r"^(\d+)([.)])(?!\d)", r"\1\\\2", line)


def code(text: str) -> str:
    """Text in a code span that no backtick in it can end; safe in a table cell."""
    line = visible(" ".join(str(text).split()))
    if set(line) & set("|\\"):
        return escape(line)  # no code span in a table can hold every mix of these two
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", line)), default=0))
    pad = " " if "`" in line else ""
    return f"{fence}{pad}{line}{pad}{fence}" if line else ""


def fenced(text: str, language: str = "") -> str:
    """A block of code that no fence in it can end."""
    text = visible(text)
    fence = "`" * max(3, 1 + max((len(run) for run in re.findall("`+", text)), default=0))
    return f"{fence}{language}\n{text.rstrip()}\n{fence}"


def table(header: Sequence[str], rows: Sequence[Sequence[str]], align: str = "") -> str:
    """A pipe table, padded so that its source reads well too.

    Args:
        header: Titles.
        rows: Cells, already escaped.
        align: One letter a column, `l`, `c` or `r`; missing letters mean `c`.
    """
    letters = align.ljust(len(header), "c")
    widths = [max(3, *(len(row[i]) for row in (header, *rows))) for i in range(len(header))]
    rules = []
    for letter, width in zip(letters, widths, strict=True):
        left, right = {"l": ("", ""), "r": ("", ":"), "c": (":", ":")}[letter]
        rules.append(left + "-" * (width - len(left) - len(right)) + right)
    lines = [header, rules, *rows]
    return "\n".join(_line(cells, widths) for cells in lines)


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = (cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
    return f"| {' | '.join(padded)} |"


def image(alt: str, file: str) -> str:
    """An image beside the page; the text is what a reader gets who cannot see it."""
    return f"![{escape(alt)}]({file})"


def details(summary: str, *blocks: str) -> str:
    """Blocks behind a line that opens them; empty when there is no block."""
    shown = [block for block in blocks if block]
    if not shown:
        return ""
    return "\n\n".join([f"<details>\n<summary>{summary}</summary>", *shown, "</details>"])


def section(title: str, *blocks: str) -> str:
    """A heading of the second level and what stands below it, empty blocks left out."""
    return "\n\n".join([f"## {title}", *(block for block in blocks if block)])


def write_pages(folder: Path, first: Iterable[str], second: Iterable[str]) -> Path:
    """Write blocks as README.md and details.md into a folder, empty ones left out; the first."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, blocks in (("README.md", first), (DETAILS, second)):
        text = "\n\n".join(block for block in blocks if block)
        (folder / name).write_text(text + "\n", encoding="utf-8")
    return folder / "README.md"
