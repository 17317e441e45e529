"""Text for the terminal: data on stdout, messages on stderr, tables in columns."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from itertools import zip_longest
from shutil import get_terminal_size
from typing import TextIO

from gaitlab.documents.printable import columns as columns
from gaitlab.documents.printable import number as number
from gaitlab.documents.printable import visible

NARROWEST = 22  # characters of a text in a column of its own
MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0  # s


def say(text: str) -> None:
    """Print data on stdout; silent once the reader has gone (`gaitlab query ... | head`)."""
    _print(text, sys.stdout)


def tell(text: str) -> None:
    """Print a message on stderr; silent once the reader has gone."""
    _print(text, sys.stderr)


def _print(text: str, file: TextIO) -> None:
    try:
        print(visible(text), file=file, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


@contextmanager
def other_output_on_stderr() -> Iterator[None]:
    """What Bullet or a team's own gait prints goes to stderr, so that stdout holds data alone.

    Worker processes that start meanwhile inherit it.
    """
    if sys.stdout is None or sys.stderr is None:  # closed by the shell, `>&-`
        yield
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def tell_at_once(text: str) -> None:
    """The same past Python's buffers, which may be in use when a signal comes."""
    with suppress(OSError):
        os.write(2, f"{visible(text)}\n".encode())


def wrapped(head: Sequence[str], rows: Sequence[Sequence[str]], texts: int) -> str:
    """A table whose last columns are texts: broken to fit a terminal, whole lines elsewhere.

    Args:
        head: Names of the columns.
        rows: Cells.
        texts: How many columns are texts.
    """
    if not sys.stdout.isatty():
        return columns(head, rows)
    first, whole = len(head) - texts, get_terminal_size().columns
    taken = sum(max(len(row[i]) for row in [head, *rows]) + 2 for i in range(first))
    width = (whole - taken) // texts - 2
    if width < NARROWEST:
        return "\n".join(_record(row, first, whole) for row in rows)
    broken = [_lines(row, first, width) for row in rows]
    return columns(head, [line for lines in broken for line in lines])


def _record(row: Sequence[str], first: int, width: int) -> str:
    """A row for a narrow terminal: its name and values, its texts below them."""
    below = "; ".join(text for text in row[first:] if text)
    indented = textwrap.fill(below, width, initial_indent="    ", subsequent_indent="    ")
    return f"{'  '.join(row[:first])}\n{indented}".rstrip()


def _lines(row: Sequence[str], first: int, width: int) -> list[list[str]]:
    """A row as several, its texts broken; the other cells stand in the first."""
    texts = [textwrap.wrap(text, width) or [""] for text in row[first:]]
    lines = zip_longest(*texts, fillvalue="")
    return [[*(row[:first] if not i else [""] * first), *line] for i, line in enumerate(lines)]


def plural(count: int, noun: str) -> str:
    """`1 trial`, `2,000 trials`."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


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
