"""The terminal that a live picture of progress needs."""

from __future__ import annotations

import sys

from rich.console import Console


def moving_terminal() -> Console | None:
    """A console on stderr that can redraw; None for files, pipes and dumb terminals."""
    console = Console(stderr=True)
    terminal = sys.stderr is not None and sys.stderr.isatty()
    return console if terminal and not console.is_dumb_terminal else None
