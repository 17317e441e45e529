"""How far a run is: one bar on a terminal, plain lines elsewhere. Always on stderr."""

from __future__ import annotations

import os
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn
from rich.progress import Progress as RichProgress

from gaitlab.cli.printing import duration, tell
from gaitlab.dispatch import Progress, Summary

LINE_PERIOD = 10.0  # s between two plain lines


def progress() -> Progress:
    """A bar if stderr is a terminal, else plain lines."""
    return Bar() if sys.stderr is not None and sys.stderr.isatty() else Lines()


class Bar:
    """One bar with counts, rate and time left."""

    def __init__(self) -> None:
        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[counts]}"),
            TextColumn("{task.fields[remaining]}"),
            console=Console(stderr=True),
        )
        self._task = TaskID(0)

    def start(self, summary: Summary) -> None:
        """Show the bar."""
        counts, remaining = _counts(summary), _remaining(summary)
        total = _due(summary)
        self._task = self._bar.add_task("trials", total=total, counts=counts, remaining=remaining)
        self._bar.start()

    def update(self, summary: Summary) -> None:
        """Move it."""
        counts, remaining = _counts(summary), _remaining(summary)
        ended = _ended(summary)
        self._bar.update(self._task, completed=ended, counts=counts, remaining=remaining)

    def message(self, text: str) -> None:
        """Written past the bar's buffers, because a signal may come while they are in use."""
        os.write(2, f"\n{text}\n".encode())

    def finish(self, summary: Summary) -> None:
        """Leave the bar as it is."""
        self._bar.stop()


class Lines:
    """A line every few seconds, and one at the end."""

    def __init__(self) -> None:
        self._last = 0.0

    def start(self, summary: Summary) -> None:
        """Say how much there is to do."""
        tell(f"{summary.planned} trials, {_due(summary)} to run; {_counts(summary)}")
        self._last = time.monotonic()

    def update(self, summary: Summary) -> None:
        """Say how far it is, if it is time."""
        if time.monotonic() - self._last >= LINE_PERIOD:
            self._last = time.monotonic()
            tell(_line(summary))

    def message(self, text: str) -> None:
        """Written past Python's buffers, because a signal may come while they are in use."""
        os.write(2, f"{text}\n".encode())

    def finish(self, summary: Summary) -> None:
        """Say how far it came."""
        if _ended(summary):
            tell(_line(summary))


def _due(summary: Summary) -> int:
    return _ended(summary) + summary.left


def _ended(summary: Summary) -> int:
    return summary.done + summary.infeasible + summary.newly_failed


def _counts(summary: Summary) -> str:
    counts = f"{summary.cached} cached, {summary.infeasible} infeasible, {summary.failed} failed"
    ended = _ended(summary)
    return f"{counts}, {ended / summary.seconds:.2g} trials/s" if ended else counts


def _line(summary: Summary) -> str:
    remaining = f", {_remaining(summary)}" if _remaining(summary) else ""
    return f"{_ended(summary)} of {_due(summary)} run; {_counts(summary)}{remaining}"


def _remaining(summary: Summary) -> str:
    time_left = summary.time_left
    return f"{duration(time_left)} left" if time_left is not None and summary.left else ""
