"""A worker process as its driver sees it: a pipe, a deadline, and how it ended."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO

from gaitlab.running.executor import Job
from gaitlab.running.worker import OUT_OF_MEMORY, Task, serve
from gaitlab.store import TrialRecord

START_TIME = 60.0  # s granted for the start of a worker on a cold, busy disk
LAST_WORDS = 25  # lines of a dead worker's output kept in the reason
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Child:
    """A process, the pipe to it and the job it has.

    Args:
        task: What it does with a trial.
        memory: What it may allocate, in [byte]; None for as much as there is.
    """

    def __init__(self, task: Task, memory: int | None = None) -> None:
        self.job: Job | None = None
        self.attempt, self.done, self.start, self.deadline = 0, 0, 0.0, 0.0
        self._ready = False
        self._output = _output_file()
        self._pipe, other = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(
            target=serve,
            args=(other, task, os.getpid(), Path(self._output.name), memory),
            daemon=True,
        )
        with _deaf_child(), _single_threaded_child():
            self._process.start()
        other.close()

    @property
    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.is_alive()

    @property
    def handles(self) -> tuple[Connection, int]:
        """What becomes ready when it answers or ends."""
        return self._pipe, self._process.sentinel

    def give(self, job: Job, attempt: int) -> None:
        """Hand it a job; its time-out starts as soon as the process is ready."""
        self.job, self.attempt = job, attempt
        self.start = time.monotonic()
        self.deadline = self.start + (job.timeout if self._ready else START_TIME)
        try:
            self._pipe.send((job.trial_id, job.trial))
        except OSError:
            return  # it has died meanwhile; `answer` finds that out

    def answer(self) -> TrialRecord | Exception | str | None:
        """Record or exception of the job, how it was lost, or None while it runs."""
        found: TrialRecord | Exception | str | None = self._received()
        if found is None and not self.alive:
            found = self._received() or self._death()
        elif found is None and time.monotonic() >= self.deadline:
            self._process.kill()
            self._process.join()
            timeout = self.job.timeout if self.job is not None else 0.0
            what = (
                f"done within {timeout:.0f} s" if self._ready else f"started in {START_TIME:.0f} s"
            )
            found = f"time-out: not {what}{self._last_words()}"
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
            while self._pipe.poll():
                message: TrialRecord | Exception | str = self._pipe.recv()
                if not isinstance(message, str):
                    return message
                self._ready, self.start = True, time.monotonic()
                self.deadline = self.start + (self.job.timeout if self.job is not None else 0.0)
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


def _output_file() -> IO[str]:
    """Where a worker's last words go; nowhere if the disk for temporary files is full."""
    try:
        return tempfile.NamedTemporaryFile(mode="r", prefix="gaitlab-", errors="replace")
    except OSError:
        return open(os.devnull)  # `kill` closes it


@contextmanager
def _deaf_child() -> Iterator[None]:
    """A process started herein never sees the signals that stop a run, not even while importing."""
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
