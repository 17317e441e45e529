"""What a run counts, and who is told while it counts."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Counts of one `run`, each trial counted once.

    Attributes:
        planned: Trials that the experiment wants.
        cached: Done or infeasible before this run.
        done: Simulated by this run, falls among them.
        infeasible: Found infeasible by this run.
        failed: Failed, in this run or before it without being run again.
        newly_failed: Failed in this run.
        falls: Trials of the experiment in which the robot fell, cached ones included.
        seconds: Wall time of this run, in [s].
        interrupted: Stopped by Ctrl-C or SIGTERM; the rest is still to be done.
        due_time: Simulated time of the trials that this run is to do, in [s].
        done_time: Simulated time of those that it has done, in [s]; as planned, falls ignored.
    """

    planned: int = 0
    cached: int = 0
    done: int = 0
    infeasible: int = 0
    failed: int = 0
    newly_failed: int = 0
    falls: int = 0
    seconds: float = 0.0
    interrupted: bool = False
    due_time: float = 0.0
    done_time: float = 0.0

    @property
    def left(self) -> int:
        """Trials still to be done."""
        return self.planned - self.cached - self.done - self.infeasible - self.failed

    @property
    def time_left(self) -> float | None:
        """Wall time until the end in [s], long trials weighing more; None before the first ends."""
        if not self.done_time:
            return None
        return self.seconds * max(0.0, self.due_time - self.done_time) / self.done_time


class Progress(Protocol):
    """What is told while trials run."""

    def start(self, summary: Summary) -> None:
        """The work is known; nothing has run."""

    def update(self, summary: Summary) -> None:
        """A trial has ended."""

    def message(self, text: str) -> None:
        """Something the user should know now."""

    def finish(self, summary: Summary) -> None:
        """Nothing runs any more."""


class Careful:
    """Passes on to another what it can: a terminal or a reader that has gone stops no run."""

    def __init__(self, told: Progress) -> None:
        self._told = told

    def start(self, summary: Summary) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.start(summary)

    def update(self, summary: Summary) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.update(summary)

    def message(self, text: str) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.message(text)

    def finish(self, summary: Summary) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.finish(summary)


class Silent:
    """Tells nothing."""

    def start(self, summary: Summary) -> None:
        """Nothing."""

    def update(self, summary: Summary) -> None:
        """Nothing."""

    def message(self, text: str) -> None:
        """Nothing."""

    def finish(self, summary: Summary) -> None:
        """Nothing."""
