"""Trials in worker processes, one in flight each.

Whatever ends a worker (a segmentation fault, `os._exit`, SIGKILL, a time-out) costs the trial it
had, which is run once more before it counts as lost. Workers are spawned, replaced after
`MAX_TRIALS`, deaf to the terminal's signals and die with the driver. Each may allocate its share of
the machine's memory.

A time-out counts the processor time that a worker has used, not the time on the clock: where many
workers share little, all are slow and none is wrong. A worker that uses none for as long, although
it could, hangs and is ended too. On a slow machine trials may work longer, by what those that have
ended here took.

A pool of the standard library breaks as a whole when one worker dies. pebble's survives most
deaths, but waits out the time-out when a worker leaves with exit code 0 and breaks when an idle
worker dies, so the workers are kept here: a pipe and a process each.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from multiprocessing.resource_tracker import ensure_running
from multiprocessing.util import Finalize
from pathlib import Path
from types import ModuleType
from typing import IO, TypeAlias

from gaitlab.running.cpu import LOOK, WorkClock
from gaitlab.running.executor import TIMED_OUT, Cluster, Executor, Job, Outcome, Serial
from gaitlab.running.worker import OUT_OF_MEMORY, Task, serve, simulated
from gaitlab.store import TrialRecord

MAX_TRIALS = 50  # of one worker; bounds whatever the physics engine leaks
ATTEMPTS = 2  # a worker may die for reasons of its own once
LEAST_MEMORY = 4 << 30  # byte; libraries reserve far more than they use
START_TIME = 60.0  # s of work, or of none, granted for the start of a worker on a cold, busy disk
SOON = 0.05  # s, the least between two looks at a worker whose time is nearly up
ROOM = 10.0  # times what the slowest trial so far has taken of its limit, every other may take
STRETCH = 20.0  # times its limit, the longest that any may take; no machine is so slow
LAST_WORDS = 25  # lines of a dead worker's output kept in the reason
Due: TypeAlias = tuple[Job, tuple[str, ...]]  # and how its earlier attempts were lost
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Child:
    """A process, the pipe to it and the job it has.

    Args:
        task: What it does with a trial.
        memory: What it may allocate, in [byte]; None for as much as there is.

    Attributes:
        job: What it has been given; None while it has nothing to do.
        lost: How earlier attempts at the job ended.
        done: Jobs that have ended here.
        start: When the job began, in [s].
        deadline: When it has to be looked at again, in [s], both of the monotonic clock.
    """

    def __init__(self, task: Task, memory: int | None = None) -> None:
        self.job: Job | None = None
        self.lost: tuple[str, ...] = ()
        self.done, self.start, self.deadline = 0, 0.0, 0.0
        self._ready = False
        self._output = _output_file()
        self._pipe, other = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(
            target=serve,
            args=(other, task, os.getpid(), Path(self._output.name), memory),
            daemon=True,
        )
        # Not by `weakref.finalize`: at the end of Python that may come after multiprocessing, which
        # waits for every child.
        Finalize(self, _end, (self._process, self._pipe, self._output), exitpriority=0)
        with deaf_child(), _single_threaded_child(), _without_main():
            self._process.start()
        self._clock = WorkClock(self._process.pid or 0)
        other.close()

    @property
    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.is_alive()

    @property
    def handles(self) -> tuple[Connection, int]:
        """What becomes ready when it answers or ends."""
        return self._pipe, self._process.sentinel

    @property
    def share(self) -> float:
        """Of the job's limit, how much it has worked so far."""
        self._clock.look()
        return self._clock.worked / self.job.timeout if self.job and self.job.timeout else 0.0

    def give(self, job: Job, lost: tuple[str, ...] = ()) -> None:
        """Hand it a job; its time-out starts as soon as the process is ready."""
        self.job, self.lost = job, lost
        self._begin()
        try:
            self._pipe.send((job.trial_id, job.trial))
        except OSError:
            return  # it has died meanwhile; `answer` finds that out

    def answer(self, stretch: float = 1.0) -> TrialRecord | Exception | str | None:
        """Record or exception of the job, how it was lost, or None while it runs.

        Args:
            stretch: How many times as long as its job says a trial may work here.
        """
        answer: TrialRecord | Exception | str | None = self._received()
        if answer is None and not self.alive:
            answer = self._received() or self._death()
        elif answer is None and time.monotonic() >= self.deadline:
            answer = self._overtime(stretch)
        return answer

    def free(self) -> None:
        """Take the job away: it has ended, one way or the other."""
        self.job, self.done = None, self.done + 1

    def kill(self) -> None:
        """End the process at once, whatever it does."""
        _end(self._process, self._pipe, self._output)

    def _begin(self) -> None:
        """Count the time of the start, or of the job, from now on."""
        self._clock.restart()
        self.start = time.monotonic()
        self.deadline = self.start + min(LOOK, self._limit)

    @property
    def _limit(self) -> float:
        if not self._ready:
            return START_TIME
        return self.job.timeout if self.job is not None else 0.0

    def _overtime(self, stretch: float) -> str | None:
        """End the process if its time is up, and say so; else see when to look again."""
        self._clock.look()
        idle, work = self._limit, self._limit * (stretch if self._ready else 1.0)
        left = min(idle - self._clock.idle, work - self._clock.worked)
        if left > 0.0:
            self.deadline = time.monotonic() + max(SOON, min(LOOK, left))
            return None
        self._process.kill()
        self._process.join()
        hangs = self._clock.idle >= idle
        how = f"{idle:.0f} s, in which it did nothing" if hangs else f"{work:.0f} s of work"
        what = "done" if self._ready else "started"
        return f"{TIMED_OUT}: not {what} within {how}{self._last_words()}"

    def _received(self) -> TrialRecord | Exception | None:
        try:
            while self._pipe.poll():
                message: TrialRecord | Exception | str = self._pipe.recv()
                if not isinstance(message, str):
                    return message
                self._ready = True
                self._begin()
            return None
        except (EOFError, OSError):
            self._process.join(timeout=1.0)  # the pipe closes an instant before the process ends
            return None

    def _death(self) -> str:
        code = self._process.exitcode or 0
        if code == OUT_OF_MEMORY:
            return f"out of memory{self._last_words()}"
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"worker process ended with {how}{self._last_words()}"

    def _last_words(self) -> str:
        self._output.seek(0)
        lines = self._output.read().splitlines()[-LAST_WORDS:]
        return "".join(f"\n{line}" for line in lines)


def _end(process: SpawnProcess, pipe: Connection, output: IO[str]) -> None:
    """End a process, if it ever began and has not ended, and close what led to it.

    It has to be done even if Ctrl-C strikes while a worker is started or killed: nobody would know
    of that worker, it is deaf to what Python ends its children with, and Python waits for them.
    """
    try:
        if process.pid is not None and process.exitcode is None:
            process.kill()
            process.join()
    finally:
        pipe.close()
        output.close()


def _output_file() -> IO[str]:
    """Where a worker's last words go; nowhere if the disk for temporary files is full."""
    try:
        return tempfile.NamedTemporaryFile(mode="r", prefix="gaitlab-", errors="replace")
    except OSError:
        return open(os.devnull)  # `kill` closes it


@contextmanager
def deaf_child() -> Iterator[None]:
    """A process started herein never sees the signals that stop a run, not even while importing."""
    ensure_running()  # multiprocessing's own process: as it starts it makes all hear again
    deaf = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, deaf)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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


@contextmanager
def _without_main() -> Iterator[None]:
    """A process started herein does not run the script that started it: it needs nothing of it.

    Or else a script of three lines that calls `run` would have to be written around that.
    """
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def fair_memory(workers: int) -> int:
    """Share of the machine's memory for each of several workers, in [byte]."""
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(LEAST_MEMORY, total // max(1, workers))


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
        self._again: deque[Due] = deque()
        self._slowest = 0.0  # the largest share of its limit that a trial has taken here
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
        waiting = map(lambda job: (job, ()), jobs)  # unlike a generator, it goes on after an end
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

    def _assign(self, waiting: Iterator[Due]) -> bool:
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

    def _next(self, waiting: Iterator[Due]) -> Due | None:
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
        job, seconds = worker.job, time.monotonic() - worker.start
        answer = worker.answer(max(1.0, min(STRETCH, ROOM * self._slowest)))
        if job is None or answer is None:
            return None
        if isinstance(answer, TrialRecord):
            self._slowest = max(self._slowest, worker.share)
        worker.free()
        if isinstance(answer, TrialRecord):
            return Outcome(job=job, record=answer)
        if isinstance(answer, Exception):
            raise answer
        lost = (*worker.lost, answer)
        if len(lost) < ATTEMPTS:
            self._again.append((job, lost))
            return None
        worst = next((reason for reason in lost if not reason.startswith(TIMED_OUT)), lost[-1])
        return Outcome(
            job=job, record=None, reason=f"{worst}\n({len(lost)} attempts)", seconds=seconds
        )


def executor(
    store: Path,
    jobs: int,
    cluster: Cluster | None = None,
    message: Callable[[str], None] = lambda text: None,
) -> Executor:
    """What simulates trials into a store: so many worker processes, with 0 this process.

    Args:
        store: Folder of the store.
        jobs: Worker processes; 0 for this process.
        cluster: Has workers instead, elsewhere.
        message: Is given what the user should know at once.
    """
    if cluster is not None:
        return cluster.executor(store, simulated, message)
    task = partial(simulated, store=store)
    return Processes(task, jobs) if jobs else Serial(task)
