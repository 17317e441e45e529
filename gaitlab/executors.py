"""Trials run one after another here, or in worker processes; one interface for both.

A worker has one trial in flight. Whatever ends it (a segmentation fault, `os._exit`, SIGKILL, a
time-out) costs that one trial, which is run once more before it counts as lost. Workers are
spawned, replaced after `MAX_TRIALS`, ignore the terminal's signals and die with the driver.

A pool of the standard library breaks as a whole when one worker dies. pebble's survives most
deaths, but waits out the time-out when a worker leaves with exit code 0 and breaks when an idle
worker dies, so the workers are kept here: a pipe and a process each.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol, TextIO

from gaitlab.store import TrialRecord
from gaitlab.worker import Task, serve

MAX_TRIALS = 50  # of one worker; bounds whatever the physics engine leaks
START_TIME = 60.0  # s granted for imports on a cold, busy disk, on top of a trial's time-out
ATTEMPTS = 2  # a worker may die for reasons of its own once
LAST_WORDS = 25  # lines of a dead worker's output kept in the reason


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


class Processes:
    """Trials in worker processes.

    Args:
        task: What to do with a trial; pickled into the workers.
        workers: How many.
        max_trials: A worker is replaced after this many.
    """

    def __init__(self, task: Task, workers: int, max_trials: int = MAX_TRIALS) -> None:
        self._task, self._max_trials = task, max_trials
        self._slots = workers
        self._workers: list[_Worker] = []
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

        Closing the iterator kills the trials that still run.

        Raises:
            Exception: What the task itself raised in a worker, a `StoreError` for instance.
        """
        waiting = ((job, 1) for job in jobs)
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
            self._worker(slot).give(*following)
        return self.running > 0

    def _next(self, waiting: Iterator[tuple[Job, int]]) -> tuple[Job, int] | None:
        if self._draining:
            return None
        return self._again.popleft() if self._again else next(waiting, None)

    def _worker(self, slot: int) -> _Worker:
        if slot == len(self._workers):
            self._workers.append(_Worker(self._task))
        elif self._workers[slot].done >= self._max_trials or not self._workers[slot].alive:
            self._workers[slot].kill()
            self._workers[slot] = _Worker(self._task)
        return self._workers[slot]

    def _ready(self) -> list[_Worker]:
        busy = [worker for worker in self._workers if worker.job is not None]
        patience = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
        connection.wait([handle for worker in busy for handle in worker.handles], patience)
        return busy

    def _collect(self, worker: _Worker) -> Outcome | None:
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


class _Worker:
    """A process, the pipe to it and the job it has."""

    def __init__(self, task: Task) -> None:
        self.job: Job | None = None
        self.attempt, self.done, self.start, self.deadline = 0, 0, 0.0, 0.0
        self._output = tempfile.NamedTemporaryFile(  # noqa: SIM115, closed by `kill`
            mode="r", prefix="gaitlab-", errors="replace"
        )
        self._pipe, other = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(
            target=serve, args=(other, task, os.getpid(), Path(self._output.name)), daemon=True
        )
        with _deaf_child(), _single_threaded_child():
            self._process.start()
        other.close()

    @property
    def alive(self) -> bool:
        return self._process.is_alive()

    @property
    def handles(self) -> tuple[Connection, int]:
        return self._pipe, self._process.sentinel

    def give(self, job: Job, attempt: int) -> None:
        self.job, self.attempt = job, attempt
        starting = 0.0 if self.done else START_TIME
        self.start = time.monotonic()
        self.deadline = self.start + job.timeout + starting
        try:
            self._pipe.send((job.trial_id, job.trial))
        except OSError:
            return  # it has died meanwhile; `answer` finds that out

    def answer(self) -> TrialRecord | Exception | str | None:
        """Record or exception of the job, how it was lost, or None while it runs."""
        found = self._received()
        if found is None and not self.alive:
            found = self._received() or self._death()
        elif found is None and time.monotonic() >= self.deadline:
            found = self._hung()
        if found is not None:
            self.job, self.done = None, self.done + 1
        return found

    def kill(self) -> None:
        """End the process at once, whatever it does."""
        self._process.kill()
        self._process.join()
        self._pipe.close()
        self._output.close()

    def _received(self) -> TrialRecord | Exception | None:
        try:
            return self._pipe.recv() if self._pipe.poll() else None
        except (EOFError, OSError):
            self._process.join(timeout=1.0)  # the pipe closes an instant before the process ends
            return None

    def _death(self) -> str:
        code = self._process.exitcode or 0
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"worker process ended with {how}{self._last_words()}"

    def _hung(self) -> str:
        self._process.kill()
        self._process.join()
        timeout = self.job.timeout if self.job is not None else 0.0
        return f"time-out: not done within {timeout:.0f} s{self._last_words()}"

    def _last_words(self) -> str:
        lines = _tail(self._output)
        return "".join(f"\n{line}" for line in lines)


def _tail(output: TextIO) -> list[str]:
    output.seek(0)
    return output.read().splitlines()[-LAST_WORDS:]


@contextmanager
def _deaf_child() -> Iterator[None]:
    """A process started herein never sees Ctrl-C or SIGTERM, not even while it imports."""
    deaf = {signal.SIGINT, signal.SIGTERM}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, deaf)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@contextmanager
def _single_threaded_child() -> Iterator[None]:
    """A process started herein uses one thread; numpy reads these variables when it is loaded."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
