"""What a run counts, and what is called while it counts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from gaitlab.experiment import Value
from gaitlab.store import State


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
        fell_standing: Those of them in which it fell before its first step.
        seconds: Wall time of this run, in [s].
        interrupted: Stopped by Ctrl-C or SIGTERM; the rest is still to be done.
        time_left: Wall time until the end in [s], long trials weighing more and those on a ground
            on which the robot soon falls less; None before the first has ended.
    """

    planned: int = 0
    cached: int = 0
    done: int = 0
    infeasible: int = 0
    failed: int = 0
    newly_failed: int = 0
    falls: int = 0
    fell_standing: int = 0
    seconds: float = 0.0
    interrupted: bool = False
    time_left: float | None = None

    @property
    def left(self) -> int:
        """Trials still to be done."""
        return self.planned - self.cached - self.done - self.infeasible - self.failed


def total(summaries: Iterable[Summary]) -> Summary:
    """The sum of several runs, one after the other; a trial that two want counts in both."""
    found = list(summaries)
    return Summary(
        planned=sum(one.planned for one in found),
        cached=sum(one.cached for one in found),
        done=sum(one.done for one in found),
        infeasible=sum(one.infeasible for one in found),
        failed=sum(one.failed for one in found),
        newly_failed=sum(one.newly_failed for one in found),
        falls=sum(one.falls for one in found),
        fell_standing=sum(one.fell_standing for one in found),
        seconds=sum(one.seconds for one in found),
        interrupted=any(one.interrupted for one in found),
    )


@dataclass(frozen=True, kw_only=True)
class Started:
    """A trial that has been given to a worker.

    Attributes:
        trial_id: Identity of the trial.
        cell: Varied values by dotted path, and the ground under `surface`.
        seed: Its seed.
    """

    trial_id: str
    cell: Mapping[str, Value]
    seed: int


@dataclass(frozen=True, kw_only=True)
class Ended(Started):
    """A trial that has ended.

    Attributes:
        state: How.
        stable: Whether the robot stayed up to the horizon; None if nothing was simulated.
        reason: Why it has no result; empty if it has one.
    """

    state: State
    stable: bool | None
    reason: str


class Progress:
    """Is called while trials run; does nothing unless a subclass does."""

    def start(self, summary: Summary) -> None:
        """The work is known; nothing has run."""

    def started(self, trial: Started) -> None:
        """A trial runs from now on."""

    def ended(self, trial: Ended) -> None:
        """A trial has ended; `update` with the new counts comes next."""

    def update(self, summary: Summary) -> None:
        """The counts have changed: a trial has ended."""

    def message(self, text: str) -> None:
        """Something the user should know now."""

    def finish(self, summary: Summary) -> None:
        """Nothing runs any more."""
