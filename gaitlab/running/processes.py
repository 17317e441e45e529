"""Trials in worker processes, one in flight each.

Whatever ends a worker (a segmentation fault, `os._exit`, SIGKILL, a time-out) costs the trial it
had, which is run once more before it counts as lost. Workers are spawned, replaced after
`MAX_TRIALS`, deaf to the terminal's signals and die with the driver. Each may allocate its share of
the machine's memory.

A pool of the standard library breaks as a whole when one worker dies. pebble's survives most
deaths, but waits out the time-out when a worker leaves with exit code 0 and breaks when an idle
worker dies, so the workers are kept here: a pipe and a process each.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator
from multiprocessing import connection

from gaitlab.running.child import Child
from gaitlab.running.executor import Job, Outcome
from gaitlab.running.worker import Task
from gaitlab.store import TrialRecord

MAX_TRIALS = 50  # of one worker; bounds whatever the physics engine leaks
ATTEMPTS = 2  # a worker may die for reasons of its own once


LEAST_MEMORY = 4 << 30  # byte; libraries reserve far more than they use


def fair_memory(workers: int) -> int:
    """Share of the machine's memory for each of several workers, in [byte]."""
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(LEAST_MEMORY, total // max(1, workers))


def _first_attempt(job: Job) -> tuple[Job, int]:
    return job, 1


class Processes:
    """Trials in worker processes.

    Args:
        task: What to do with a trial; pickled into the workers.
        workers: How many.
        max_trials: A worker is replaced after this many.
        memory: What a worker may allocate, in [byte].
    """

    def __init__(
        self,
        task: Task,
        workers: int,
        max_trials: int = MAX_TRIALS,
        memory: int | None = None,
    ) -> None:
        self._task, self._max_trials = task, max_trials
        self._memory = memory or fair_memory(workers)
        self._slots = workers
        self._workers: list[Child] = []
        self._again: deque[tuple[Job, int]] = deque()
        self._draining = False

    @property
    def running(self) -> int:
        """Jobs in flight."""
        return sum(worker.job is not None for worker in self._workers)

    def drain(self) -> None:
        """Take no more jobs; those that run are finished."""
        self._draining = True

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Keep every worker busy until the jobs end or `drain` is called.

        The jobs may seem to end and go on: whoever adds some while an outcome is looked at finds
        the same workers, still warm.

        Closing the iterator kills the trials that still run.

        Raises:
            Exception: What the task itself raised in a worker, a `StoreError` for instance.
        """
        waiting = map(_first_attempt, jobs)  # unlike a generator, it goes on after an end
        try:
            while self._assign(waiting):
                for worker in self._ready():
                    outcome = self._collect(worker)
                    if outcome is not None:
                        yield outcome
        finally:
            for worker in self._workers:
                worker.kill()
            self._workers.clear()

    def _assign(self, waiting: Iterator[tuple[Job, int]]) -> bool:
        """Give every free worker a job; False when nothing runs and nothing is left."""
        for slot in range(self._slots):
            if slot < len(self._workers) and self._workers[slot].job is not None:
                continue
            following = self._next(waiting)
            if following is None:
                break
            if slot == len(self._workers):
                self._workers.append(Child(self._task, self._memory))
            elif self._workers[slot].done >= self._max_trials or not self._workers[slot].alive:
                self._workers[slot].kill()
                self._workers[slot] = Child(self._task, self._memory)
            self._workers[slot].give(*following)
        return self.running > 0

    def _next(self, waiting: Iterator[tuple[Job, int]]) -> tuple[Job, int] | None:
        if self._draining:
            return None
        return self._again.popleft() if self._again else next(waiting, None)

    def _ready(self) -> list[Child]:
        busy = [worker for worker in self._workers if worker.job is not None]
        patience = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
        connection.wait([handle for worker in busy for handle in worker.handles], patience)
        return busy

    def _collect(self, worker: Child) -> Outcome | None:
        """Outcome of a worker's job; None if it still runs or is to be run again."""
        job, attempt, seconds = worker.job, worker.attempt, time.monotonic() - worker.start
        answer = worker.answer()
        if job is None or answer is None:
            return None
        if isinstance(answer, Exception):
            raise answer
        if isinstance(answer, TrialRecord):
            return Outcome(job=job, record=answer)
        if attempt < ATTEMPTS:
            self._again.append((job, attempt + 1))
            return None
        return Outcome(
            job=job, record=None, reason=f"{answer}\n({attempt} attempts)", seconds=seconds
        )
