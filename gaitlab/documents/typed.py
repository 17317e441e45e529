"""Numbers as people type them: with a decimal comma, from other keyboards and scripts."""

from __future__ import annotations

import re
import unicodedata

MINUSES = "-−‐‑‒–—﹣－"  # of keyboards and of typography
LOOKALIKES = str.maketrans("，．٫＋ｅＥ\N{NO-BREAK SPACE}", ",..+eE ")
NUMBER = re.compile(r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(\S*)")


def typed_number(text: str) -> tuple[str, str]:
    """The number that a text begins with as YAML writes it, whatever keyboard it came from.

    Returns:
        The number and what follows it; both empty if the text begins with none.
    """
    found = NUMBER.match(_plain(text).strip())
    return (found[1].replace(",", "."), found[2]) if found else ("", "")


def instead(text: str) -> str:
    """`write 0.03, with a point`: how a number that YAML takes for a text is written.

    Empty if the text is no number alone, or is one in YAML as well.
    """
    number, rest = typed_number(text)
    reasons = [
        *(["with a point"] if "," in _plain(text) else []),
        *(["with the minus sign of the keyboard"] if set(text) & set(MINUSES[1:]) else []),
        *(["in the digits 0 to 9"] if any(c.isdigit() and not c.isascii() for c in text) else []),
    ]
    return f"write {number}, {' and '.join(reasons)}" if number and reasons and not rest else ""


def _plain(text: str) -> str:
    return "".join(map(_letter, text)).translate(LOOKALIKES)


def _letter(letter: str) -> str:
    if unicodedata.category(letter) == "Nd":
        return str(unicodedata.digit(letter))
    return "-" if letter in MINUSES else letter
