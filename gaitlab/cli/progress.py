"""How far a run is: a bar on a terminal, a line a minute elsewhere, or a JSON object an event.

For people always on stderr, for programs (`--json-lines`) on stdout.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress

from rich.console import Console, Group
from rich.live import Live
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.progress import Progress as Moving
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from gaitlab.cli.printing import MINUTE, duration, number, plural, tell, tell_at_once
from gaitlab.documents.printable import visible
from gaitlab.documents.steps import heard
from gaitlab.running import Ended, Progress, Started, Summary

WIDEST = 100  # characters; a longer bar says nothing more
FRAMES_A_SECOND = 4
SILENT = 5.0  # s, after which a step of a report is said where there is no bar
SHOWN_RUNNING = 8  # trials that are named while they run


def progress(*, quiet: bool = False) -> Progress:
    """What is called while trials run.

    Args:
        quiet: Say only what a user has to know now.
    """
    if quiet:
        return Messages()
    console = moving_terminal()
    return Bar(console) if console else Lines()


class Messages(Progress):
    """Nothing but messages."""

    def message(self, text: str) -> None:
        """Say it now."""
        tell_at_once(text)


class Lines(Messages):
    """A line at the start, one a minute, and one at the end.

    Args:
        clock: Gives the time, in [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._last = clock, 0.0

    def start(self, summary: Summary) -> None:
        """Say how much there is to do."""
        tell(f"{plural(summary.planned, 'trial')}, {_due(summary)} to run; {_counts(summary)}")
        self._last = self._clock()

    def update(self, summary: Summary) -> None:
        """Say how far it is, if it is time."""
        if self._clock() - self._last >= MINUTE:
            self._last = self._clock()
            tell(_line(summary))

    def finish(self, summary: Summary) -> None:
        """Say how far it came."""
        if ended(summary):
            tell(_line(summary))


class Bar(Progress):
    """A bar with the time left, the counts below it, and what runs now below them.

    Args:
        console: Where it is drawn.
    """

    def __init__(self, console: Console) -> None:
        self._console, self._summary, self._updated = console, Summary(), time.monotonic()
        self._running: dict[str, str] = {}
        self._messages: list[str] = []
        self._live = Live(
            get_renderable=self._picture, console=console, refresh_per_second=FRAMES_A_SECOND
        )

    def start(self, summary: Summary) -> None:
        """Show the bar."""
        self._summary = summary
        self._live.start()

    def started(self, trial: Started) -> None:
        """One more trial runs."""
        self._running = {**self._running, trial.trial_id: trial_text(trial)}

    def ended(self, trial: Ended) -> None:
        """One less."""
        left = self._running.items()
        self._running = {key: text for key, text in left if key != trial.trial_id}

    def update(self, summary: Summary) -> None:
        """Move the bar."""
        self._summary, self._updated = summary, time.monotonic()

    def message(self, text: str) -> None:
        """Keep it below the bar; a signal may come while the bar is being drawn."""
        self._messages.append(visible(text))

    def finish(self, summary: Summary) -> None:
        """Leave the bar as it is."""
        self._summary, self._running = summary, {}
        self._live.stop()

    def _picture(self) -> Group:
        counts = Text(_counts(self._summary), style="dim")
        running = list(self._running.values())[:SHOWN_RUNNING]
        now = [Text(text, style="dim", no_wrap=True, overflow="ellipsis") for text in running]
        return Group(self._bar(), counts, *now, *(Text(text) for text in self._messages))

    def _bar(self) -> Table:
        summary = self._summary
        table = Table.grid(padding=(0, 1), expand=True)
        table.width = min(WIDEST, self._console.width)
        table.add_column(ratio=1)
        table.add_column(no_wrap=True)
        table.add_column(no_wrap=True)
        bar = ProgressBar(total=max(1, _due(summary)), completed=ended(summary))
        remaining = _remaining(summary, time.monotonic() - self._updated)
        table.add_row(bar, f"{ended(summary)}/{_due(summary)}", remaining)
        return table


@contextmanager
def steps(clock: Callable[[], float] = time.monotonic) -> Iterator[None]:
    """Show what is done meanwhile: a moving bar on a terminal that is gone at the end, else lines.

    Args:
        clock: Gives the time, in [s]; the first step is said at once, the others where it has
            been silent for a while.
    """
    console = moving_terminal()
    if console is None:
        said = -SILENT

        def tell_step(text: str, done: int, expected: int) -> None:
            nonlocal said
            if clock() - said >= SILENT:
                far = f" ({done} of {expected} steps done)" if done else ""
                said = clock()
                tell(f"{text}{far}")

        with heard(tell_step):
            yield
        return
    columns = (
        *(SpinnerColumn(), BarColumn(), MofNCompleteColumn()),
        *(TextColumn("{task.description}"), TimeElapsedColumn()),
    )
    with Moving(*columns, console=console, transient=True) as moving:
        task = moving.add_task("starting", total=None)

        def show_step(text: str, done: int, expected: int) -> None:
            moving.update(task, description=visible(text), completed=done, total=expected)

        with heard(show_step):
            yield


def trial_text(trial: Started) -> str:
    """A trial by the varied values of its cell, `carpet_4mm, step_length 0.04, seed 3`."""
    words = [str(value) for value in trial.cell.values() if isinstance(value, str)]
    numbers = [
        f"{path.rpartition('.')[2]} {number(value)}"
        for path, value in trial.cell.items()
        if not isinstance(value, str)
    ]
    cell = ", ".join(words + numbers)
    return visible(f"{cell}, seed {trial.seed}") if cell else f"seed {trial.seed}"


def ended(summary: Summary) -> int:
    """Trials that this run has brought to an end."""
    return summary.done + summary.infeasible + summary.newly_failed


def _due(summary: Summary) -> int:
    return ended(summary) + summary.left


def _counts(summary: Summary) -> str:
    counts = f"{summary.cached} cached, {plural(summary.falls, 'fall')}"
    counts += f" ({summary.fell_standing} standing)" if summary.fell_standing else ""
    counts += f", {summary.infeasible} infeasible, {summary.failed} failed"
    rate = ended(summary) / summary.seconds if summary.seconds else 0.0
    return f"{counts}, {rate:.2g} trials/s" if rate else counts


def _line(summary: Summary) -> str:
    remaining = _remaining(summary, 0.0)
    return f"{ended(summary)} of {_due(summary)} run; {_counts(summary)}" + (
        f", {remaining}" if remaining else ""
    )


def _remaining(summary: Summary, since: float) -> str:
    """Time left, a time `since` in [s] after the counts; nothing where nothing is left or known."""
    if summary.time_left is None or not summary.left:
        return ""
    return f"{duration(max(0.0, summary.time_left - since))} left"


def moving_terminal() -> Console | None:
    """A console on stderr that can redraw; None for files, pipes and dumb terminals."""
    console = Console(stderr=True)
    terminal = sys.stderr is not None and sys.stderr.isatty()
    return console if terminal and not console.is_dumb_terminal else None


COUNTS = (
    *("planned", "cached", "done", "infeasible", "failed", "newly_failed"),
    *("falls", "fell_standing"),
)


def summary_object(summary: Summary) -> dict[str, object]:
    """What `--json` prints of a run."""
    rest = {"seconds": round(summary.seconds, 3), "interrupted": summary.interrupted}
    return {**_numbers(summary), **rest}


def end_line(summary: Summary) -> str:
    """The last line of a run."""
    return json.dumps({"event": "end", **summary_object(summary)})


class JsonLines(Progress):
    """Writes an event a line, each at once and whole.

    Args:
        clock: Gives the time, in [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._last = clock, clock()
        # Its own way out, because others' output is kept from stdout while trials run.
        self._file = os.dup(1) if sys.stdout is not None else os.open(os.devnull, os.O_WRONLY)

    def start(self, summary: Summary) -> None:
        """The plan is known."""
        self._write("start", _numbers(summary))

    def ended(self, trial: Ended) -> None:
        """A trial has ended."""
        found = {"id": trial.trial_id, "state": trial.state, "stable": trial.stable}
        where = {"cell": dict(trial.cell), "seed": trial.seed, "reason": trial.reason}
        self._write("trial", {**found, **where})

    def update(self, summary: Summary) -> None:
        """The counts, if it is time."""
        if self._clock() - self._last >= MINUTE:
            self._last = self._clock()
            left = summary.time_left
            rounded = None if left is None else round(left, 1)
            self._write("minute", {**_numbers(summary), "time_left": rounded})

    def message(self, text: str) -> None:
        """Something the user should know now."""
        self._write("message", {"text": text})

    def finish(self, summary: Summary) -> None:
        """Close the way out; the command itself writes the end."""
        os.close(self._file)

    def _write(self, event: str, content: Mapping[str, object]) -> None:
        with suppress(BrokenPipeError):  # who read it has gone; the run goes on
            os.write(self._file, f"{json.dumps({'event': event, **content})}\n".encode())


def _numbers(summary: Summary) -> dict[str, object]:
    return {name: getattr(summary, name) for name in COUNTS}
