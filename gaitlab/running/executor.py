"""What goes into an executor and what comes out, and the one that runs in this process."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from gaitlab.running.worker import Task
from gaitlab.store import TrialRecord

TIMEOUT = 120.0  # s any trial may take
TIMEOUT_RATIO = 20.0  # s of wall time per simulated second, some fifty times the usual


@dataclass(frozen=True, kw_only=True)
class Job:
    """One trial to run.

    Attributes:
        trial_id: Identity of the trial.
        trial: The trial as plain data.
        timeout: Longest time it may take, in [s]; only worker processes can keep to it.
    """

    trial_id: str
    trial: Mapping[str, Any]
    timeout: float


def job_of(trial_id: str, trial: Mapping[str, Any], seconds: float) -> Job:
    """The job of a trial that simulates so many seconds at most."""
    return Job(trial_id=trial_id, trial=trial, timeout=TIMEOUT + TIMEOUT_RATIO * seconds)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a job.

    Attributes:
        job: The job.
        record: What the trial committed; None if its worker was lost.
        reason: How the worker was lost; empty if it was not.
        seconds: How long the lost trial took, in [s].
    """

    job: Job
    record: TrialRecord | None
    reason: str = ""
    seconds: float = 0.0


class Executor(Protocol):
    """Runs jobs and gives their outcomes as they finish."""

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Take jobs as there is room for them; never more than one ahead of the workers."""

    def drain(self) -> None:
        """Take no more jobs; those that run are finished."""

    @property
    def running(self) -> int:
        """Jobs in flight."""


class Cluster(Protocol):
    """Worker processes elsewhere, which outlive a run."""

    @property
    def workers(self) -> int:
        """How many there are, or are to be."""

    def executor(
        self, store: Path, task: Callable[..., TrialRecord], message: Callable[[str], None]
    ) -> Executor:
        """What runs trials there into a store.

        Args:
            store: Folder of the store.
            task: What to do with a trial; takes the folder of the store as `store`.
            message: Is given what the user should know at once.
        """


class Serial:
    """One trial after another in this process: for looking at a trial in a debugger."""

    def __init__(self, task: Task) -> None:
        self._task, self._draining, self.running = task, False, 0

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Run the jobs in their order."""
        waiting = iter(jobs)
        while not self._draining and (job := next(waiting, None)) is not None:
            self.running = 1
            record = self._task(job.trial_id, job.trial)
            self.running = 0
            yield Outcome(job=job, record=record)

    def drain(self) -> None:
        """Stop after the job that runs."""
        self._draining = True
