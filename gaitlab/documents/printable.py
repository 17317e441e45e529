"""Text that others wrote, made fit to be shown: no terminal, page or spreadsheet obeys it."""

from __future__ import annotations

import re

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
    shown = visible(text)
    if len(shown) < 2 or not shown.lstrip().startswith(_FORMULA):
        return shown
    try:
        float(shown)
    except ValueError:
        return f"'{shown}"
    return shown
