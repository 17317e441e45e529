"""What goes into an executor and what comes out, the one that runs in this process, and manners.

Manners are for the case that several runs on one store want the same trial: it is simulated once.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from gaitlab.running.worker import Task
from gaitlab.store import Claims, Store, TrialRecord

LOOK = 0.2  # s between two looks at what other runs are simulating
TIMEOUT = 120.0  # s of work that any trial may take
TIMEOUT_RATIO = 20.0  # s of work per simulated second, some fifty times the usual
TIMED_OUT = "time-out"  # how the reason of a trial begins that took too long; it may be the machine


@dataclass(frozen=True, kw_only=True)
class Job:
    """One trial to run.

    Attributes:
        trial_id: Identity of the trial.
        trial: The trial as plain data.
        timeout: How long it may work, and how long do nothing, in [s]; only worker processes can
            keep to it.
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


class Considerate:
    """An executor that leaves a trial alone while another run on the store simulates it.

    What others are at comes last; by then it is mostly in the store.

    Args:
        executor: Runs what nobody else is at.
        store: Where all of them put their trials.
    """

    def __init__(self, executor: Executor, store: Store) -> None:
        self._executor, self._store = executor, store
        self._claims = Claims(store.path)
        self._elsewhere: list[Job] = []
        self._again: deque[Job] = deque()
        self._settled: deque[Outcome] = deque()
        self._draining = False

    @property
    def running(self) -> int:
        """Jobs in flight."""
        return self._executor.running

    def drain(self) -> None:
        """Take no more jobs; those that run are finished."""
        self._draining = True
        self._executor.drain()

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Run the jobs, and take from the store what others have put there meanwhile."""
        waiting = iter(jobs)
        with closing(self._claims):
            while True:
                with closing(self._executor.run(_Claimed(self, waiting))) as outcomes:
                    for outcome in outcomes:
                        self._claims.release(outcome.job.trial_id)
                        yield outcome
                        yield from self._of_others()
                settled = bool(self._settled)
                yield from self._of_others()
                if self._draining or not (settled or self._elsewhere):
                    return
                if self._elsewhere:
                    time.sleep(LOOK)
                    self._again.extend(self._elsewhere)
                    self._elsewhere.clear()

    def claimed(self, waiting: Iterator[Job]) -> Job | None:
        """The next job that is this run's; None when there is none for now."""
        while job := next(waiting, None) or (self._again.popleft() if self._again else None):
            if not self._claims.take(job.trial_id):
                self._elsewhere.append(job)
            elif (record := self._store.committed(job.trial_id)) is None:
                return job
            else:
                self._claims.release(job.trial_id)
                self._settled.append(Outcome(job=job, record=record))
        return None

    def _of_others(self) -> Iterator[Outcome]:
        """Outcomes of trials that others have committed meanwhile."""
        while self._settled:
            yield self._settled.popleft()


class _Claimed(Iterator[Job]):
    """Jobs that nobody else is at; like the jobs themselves it may seem to end and go on."""

    def __init__(self, considerate: Considerate, waiting: Iterator[Job]) -> None:
        self._considerate, self._waiting = considerate, waiting

    def __next__(self) -> Job:
        job = self._considerate.claimed(self._waiting)
        if job is None:
            raise StopIteration
        return job
