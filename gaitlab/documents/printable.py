"""Text that others wrote, made fit to be shown: no terminal, page or spreadsheet obeys it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gaitlab.plugins import shown

SIX_DIGITS, LONGEST_WHOLE = 1e6, 1e15  # floats between are written out, not as powers of ten
# Control characters but line feed and tab; halves of characters; marks that are not seen or that
# turn the direction of writing. Joiners of letters and emojis (U+200C, U+200D) stay.
_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb\U000e0000-\U000e007f]"
)
_FORMULA = ("=", "+", "-", "@", "＝", "＋", "－", "＠")
_BYTE = range(0xDC80, 0xDD00)  # a byte that was no UTF-8, as Python keeps it in names of files


def visible(text: str) -> str:
    r"""The text with what a terminal would obey instead of showing written out, `\x1b` say."""
    return _OBEYED.sub(_written_out, text)


def is_utf8(text: str) -> bool:
    """Whether the text can be written to a file or a database: it holds no half of a character."""
    return text.isascii() or text == text.encode(errors="ignore").decode()


def _written_out(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code - 0xDC00:02x}" if code in _BYTE else ascii(found[0])[1:-1]


def csv_cell(text: str) -> str:
    """The text as a cell that a spreadsheet shows: a `'` before what it would compute."""
    cell = visible(text)
    formula = len(cell) > 1 and cell.lstrip().startswith(_FORMULA)
    return f"'{cell}" if formula and not _is_number(cell) else cell


def number(value: object) -> str:
    """A value for reading: floats to six digits, nothing for nothing, switches as in YAML."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and SIX_DIGITS <= abs(value) < LONGEST_WHOLE:
        return f"{value:.0f}"
    return f"{value:.6g}" if isinstance(value, float) else shown(str(value))


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in aligned columns: numbers to the right, words to the left."""
    cells = [[visible(text).replace("\n", "\\n") for text in row] for row in (head, *rows)]
    rows = cells[1:]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    right = [bool(rows) and all(_is_number(row[i]) for row in rows) for i in range(len(head))]
    return "\n".join(
        "  ".join(
            text.rjust(width) if number else text.ljust(width)
            for text, width, number in zip(row, widths, right, strict=True)
        ).rstrip()
        for row in cells
    )


def _is_number(text: str) -> bool:
    try:
        float(text or "0")
    except ValueError:
        return False
    return True
