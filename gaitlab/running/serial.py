"""Trials one after another in this process."""

from __future__ import annotations

from collections.abc import Generator, Iterable

from gaitlab.running.executor import Job, Outcome
from gaitlab.running.worker import Task


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
