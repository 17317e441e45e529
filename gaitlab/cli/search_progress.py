"""How far a search is: a live table on a terminal, a line a minute elsewhere. Always on stderr."""

from __future__ import annotations

import time
from collections.abc import Callable

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from gaitlab.cli.printing import MINUTE, duration, number, plural, tell, tell_at_once
from gaitlab.cli.progress import moving_terminal
from gaitlab.documents.printable import visible
from gaitlab.metrics import lookup
from gaitlab.search import Candidate, History
from gaitlab.search.search import SearchCallback, SearchStatus

WIDEST = 100  # characters
FRAMES_A_SECOND = 2
SHOWN_FRONT = 5  # candidates of a Pareto front


def search_progress(*, quiet: bool = False) -> SearchCallback:
    """What shows a search as it goes on.

    Args:
        quiet: Say only what a user has to know now.
    """
    if quiet:
        return SearchMessages()
    console = moving_terminal()
    return SearchTable(console) if console else SearchLines()


class SearchMessages(SearchCallback):
    """Nothing but messages."""

    def message(self, text: str) -> None:
        """Say it now."""
        tell_at_once(text)


class SearchLines(SearchMessages):
    """A line at the start, one a minute, and one at the end.

    Args:
        clock: Gives the time, in [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._last = clock, 0.0

    def start(self, status: SearchStatus) -> None:
        """Say where the search stands."""
        tell(f"{plural(status.total, 'candidate')}, {status.finished} finished before")
        self._last = self._clock()

    def update(self, status: SearchStatus) -> None:
        """Say how far it is, if it is time."""
        if self._clock() - self._last >= MINUTE:
            self._last = self._clock()
            tell(line(status))

    def finish(self, status: SearchStatus) -> None:
        """Say how far it came."""
        tell(line(status))


class SearchTable(SearchMessages):
    """A bar, the best so far with its values, and the counts.

    Args:
        console: Where it is drawn.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._status: SearchStatus | None = None
        self._updated = time.monotonic()
        self._messages: list[str] = []
        self._live = Live(
            get_renderable=self._picture, console=console, refresh_per_second=FRAMES_A_SECOND
        )

    def start(self, status: SearchStatus) -> None:
        """Show the table."""
        self._status = status
        self._live.start()

    def update(self, status: SearchStatus) -> None:
        """Show the newest state at the next frame."""
        self._status, self._updated = status, time.monotonic()

    def message(self, text: str) -> None:
        """Keep it below the table; a signal may come while that is being drawn."""
        self._messages.append(visible(text))

    def finish(self, status: SearchStatus) -> None:
        """Leave the table as it is."""
        self._status = status
        self._live.stop()

    def _picture(self) -> Group:
        status, lines = self._status, [Text(text) for text in self._messages]
        if status is None:
            return Group(*lines)
        counts = Text(counts_text(status), style="dim")
        return Group(self._bar(status), *_best(status.history), counts, *lines)

    def _bar(self, status: SearchStatus) -> Table:
        table = Table.grid(padding=(0, 1), expand=True)
        table.width = min(WIDEST, self._console.width)
        table.add_column(ratio=1)
        table.add_column(no_wrap=True)
        table.add_column(no_wrap=True)
        bar = ProgressBar(total=max(1, status.total), completed=status.finished)
        left = remaining(status, time.monotonic() - self._updated)
        table.add_row(bar, f"{status.finished}/{status.total}", left)
        return table


def _best(history: History) -> list[Table | Text]:
    if not history.front:
        return [Text("no candidate yet that walked with every seed and breaks no constraint")]
    study = history.study
    shown = history.front[:SHOWN_FRONT]
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("best so far" if len(history.front) == 1 else "front so far")
    for candidate in shown:
        table.add_column(f"candidate {candidate.number}", justify="right")
    for place, objective in enumerate(study.objectives):
        name = with_unit(objective.metric)
        texts = (f"{c.objectives[place]:.4g}" for c in shown)
        table.add_row(Text(name), *texts, style="bold")
    for item in study.search:
        values = (Text(visible(_value(candidate, item.path))) for candidate in shown)
        table.add_row(item.path, *values)
    return [table]


def _value(candidate: Candidate, path: str) -> str:
    return number(candidate.values[path]) if path in candidate.values else "-"


def with_unit(metric: str) -> str:
    """A metric with its unit in brackets, if it has one."""
    unit = lookup(metric).unit
    return metric if unit == "-" else f"{metric} [{unit}]"


def counts_text(status: SearchStatus) -> str:
    """What is finished, what walks and how fast."""
    text = f"{status.count('done')} done, {status.count('pruned')} pruned, "
    text += f"{status.count('infeasible')} infeasible"
    if status.walking:
        text += f"; {status.alive} of {status.walking} of this batch still in the race"
    if status.walked:
        text += f"; {status.rate:.2g} robot-seconds a second"
    return text


def line(status: SearchStatus) -> str:
    """The same and the best so far in one line."""
    text = f"{status.finished} of {status.total} finished: {counts_text(status)}"
    front = status.history.front
    if front:
        values = [
            f"{with_unit(objective.metric)} {value:.4g}"
            for objective, value in zip(
                status.history.study.objectives, front[0].objectives, strict=True
            )
        ]
        what = "best" if len(front) == 1 else f"front of {len(front)}, first"
        text += f"; {what}: candidate {front[0].number}, {', '.join(values)}"
    left = remaining(status, 0.0)
    return f"{text}; {left}" if left else text


def remaining(status: SearchStatus, since: float) -> str:
    """Time left, a time `since` in [s] after the counts; nothing where it is not known."""
    if status.time_left is None or status.finished >= status.total:
        return ""
    return f"about {duration(max(0.0, status.time_left - since))} left"
