"""Text for the terminal: data on stdout, messages on stderr, tables in columns."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0  # s


def say(text: str) -> None:
    """Print data on stdout; silent once the reader has gone (`gaitlab query ... | head`)."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def tell(text: str) -> None:
    """Print a message on stderr."""
    print(text, file=sys.stderr, flush=True)


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in aligned columns: numbers to the right, words to the left."""
    cells = [list(head), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    right = [bool(rows) and all(_is_number(row[i]) for row in rows) for i in range(len(head))]
    return "\n".join(
        "  ".join(
            text.rjust(width) if number else text.ljust(width)
            for text, width, number in zip(row, widths, right, strict=True)
        ).rstrip()
        for row in cells
    )


def number(value: object) -> str:
    """A value for reading: floats to six digits, nothing for nothing."""
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def duration(seconds: float) -> str:
    """A duration with one unit, `2.5 h` for instance."""
    for length, unit in ((365.25 * DAY, "years"), (DAY, "days"), (HOUR, "h"), (MINUTE, "min")):
        if seconds >= length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.0f} s"


def size(content: float) -> str:
    """An amount of data with one unit, `1.2 GB` for instance."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if content < 1000.0:
            return f"{content:.3g} {unit}"
        content /= 1000.0
    return f"{content:.3g} PB"


def _is_number(text: str) -> bool:
    try:
        float(text or "0")
    except ValueError:
        return False
    return True
