"""Trials on the workers of a Dask cluster, which may come and go while a run goes on.

One trial is in flight for each worker that is there. A trial whose worker was lost is given out
once more, as with worker processes; one that failed is a result. A trial that Dask starts twice
gives the same twice. Where the scheduler or this process dies, what is committed is in the store.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from secrets import token_hex
from typing import TYPE_CHECKING

from gaitlab.errors import StoreError
from gaitlab.running.dask_connection import GO_ON, DaskConnection, WorkerLost
from gaitlab.running.dask_worker import Order, Token, versions
from gaitlab.running.executor import Executor, Job, Outcome
from gaitlab.running.processes import ATTEMPTS, fair_memory
from gaitlab.running.worker import encoded
from gaitlab.simulation.engines import engine_of
from gaitlab.store import Store, TrialRecord
from gaitlab.store.durable import PARTIAL, unwritable

if TYPE_CHECKING:
    from gaitlab.running.dask_connection import Future

LOOK_PERIOD = 0.5  # s between looks at who is there
SIGHT_TIME = 60.0  # s in which a network's folder must show what a worker has committed
PAUSE = 3.0  # s before the second attempt at a trial: workers of a job or a machine die together


class DaskCluster(DaskConnection):
    """Workers that Dask has, or starts when the first trial needs them; see `Cluster`."""

    def executor(
        self, store: Path, task: Callable[..., TrialRecord], message: Callable[[str], None]
    ) -> Executor:
        """What runs trials there into a store."""
        return DaskExecutor(self, Store(store.absolute()), task, message)


@dataclass(frozen=True, kw_only=True)
class Flight:
    """A job on its way.

    Attributes:
        job: The job.
        start: When the scheduler got it, or gets it, in [s].
        attempt: How many workers of it may have been lost before, and one.
    """

    job: Job
    start: float
    attempt: int = 1


class DaskExecutor:
    """Trials on the workers of a cluster, one in flight for each.

    Args:
        cluster: The cluster.
        store: Where results go.
        task: What to do with a trial where the store is shared.
        message: Is given what the user should know at once.
    """

    def __init__(
        self,
        cluster: DaskConnection,
        store: Store,
        task: Callable[..., TrialRecord],
        message: Callable[[str], None],
    ) -> None:
        self._cluster, self._store, self._message = cluster, store, message
        self._task = partial(task, store=store.path) if cluster.shared else encoded
        self._flights: dict[Future, Flight] = {}
        self._again: deque[Flight] = deque()
        self._ended: SimpleQueue[Future] = SimpleQueue()
        self._threads: dict[str, int] = {}
        self._next_look = 0.0
        self._said: set[str] = set()
        self._draining = False

    @property
    def running(self) -> int:
        """Jobs in flight."""
        return len(self._flights)

    def drain(self) -> None:
        """Take no more jobs; those that run are finished."""
        self._draining = True

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Keep every worker busy until the jobs end or `drain` is called.

        Workers that join get a job too. The jobs may seem to end and go on. Closing the iterator
        takes back what still runs.

        Raises:
            UsageError: If the scheduler does not answer.
            SchedulerLost: If it is lost while trials run.
            WrongValue: If a worker has another gaitlab or Python.
            StoreError: If a worker does not see the store, or cannot write it.
            Exception: What else the task raised.
        """
        waiting = iter(jobs)
        with _token(self._store.path, self._cluster.shared) as token:
            try:
                while self._assign(waiting, token):
                    future = self._next_ended(token)
                    outcome = self._collect(future) if future is not None else None
                    if outcome is not None:
                        yield outcome
            finally:
                self._take_back()

    def _assign(self, waiting: Iterator[Job], token: Token | None) -> bool:
        """Give every free worker a job; False when nothing runs and nothing is left.

        Where no worker is there yet, a job waits with the scheduler.
        """
        while not self._draining and self.running < max(1, len(self._threads)):
            flight = self._next(waiting)
            if flight is None:
                break
            self._submit(flight, token)
        return self.running > 0 or (bool(self._again) and not self._draining)

    def _next(self, waiting: Iterator[Job]) -> Flight | None:
        if self._due:
            return self._again.popleft()
        job = next(waiting, None)
        return None if job is None else Flight(job=job, start=time.monotonic())

    @property
    def _due(self) -> bool:
        """Whether a lost trial is to be tried again now."""
        return bool(self._again) and time.monotonic() >= self._again[0].start

    def _submit(self, flight: Flight, token: Token | None) -> None:
        cluster, job = self._cluster, flight.job
        order = Order(
            trial_id=job.trial_id,
            trial=job.trial,
            timeout=job.timeout,
            task=self._task,
            versions=versions(engine_of(job.trial)),
            token=token,
            output=cluster.output,
            memory=fair_memory(cluster.workers) if cluster.local else None,
        )
        self._flights[cluster.submit(order, self._ended.put)] = flight

    def _next_ended(self, token: Token | None) -> Future | None:
        """What has ended; None if there is room for another job, or nothing to wait for."""
        while True:
            if time.monotonic() >= self._next_look:
                before = len(self._threads)
                self._look(token)
                if len(self._threads) > before:
                    return None
                if self._draining and not self._threads:
                    self._take_back()
                    return None
            with suppress(Empty):
                future = self._ended.get(timeout=LOOK_PERIOD)
                if future in self._flights:
                    return future
            if self._due and not self._draining:
                return None

    def _look(self, token: Token | None) -> None:
        """See who is there."""
        self._threads = self._cluster.threads()
        self._cluster.refill()
        if token is not None and not token.path.exists() and self._store.path.is_dir():
            _write(token)  # another run has tidied up
        if not self._threads and self._cluster.address:
            self._say(
                f"no worker has joined the scheduler at {self._cluster.address}; waiting. Start "
                f"some with `{self._start}`"
            )
        elif not self._threads and self._cluster.file:
            self._say(
                "waiting until SLURM starts a job; `squeue --me` says why it does not, and what "
                f"jobs print is in {self._cluster.file.logs}"
            )
        elif any(count > 1 for count in self._threads.values()):
            self._say(
                "a worker walks one trial at a time, and some here have more threads: "
                f"start them with `{self._start}`"
            )
        self._next_look = time.monotonic() + LOOK_PERIOD

    @property
    def _start(self) -> str:
        return f"dask worker {self._cluster.scheduler} --nthreads 1 --nworkers N"

    def _say(self, text: str) -> None:
        """Tell the user, once."""
        if text not in self._said:
            self._said.add(text)
            with suppress(OSError):
                self._message(text)

    def _collect(self, future: Future) -> Outcome | None:
        """The outcome of a job that has ended; None if it is to be run again."""
        flight = self._flights[future]
        try:
            reply = self._cluster.reply(future, engine_of(flight.job.trial))
        except WorkerLost as error:
            del self._flights[future]
            return self._lost(flight, error)
        del self._flights[future]
        if isinstance(reply.result, Exception):
            raise reply.result
        if isinstance(reply.result, TrialRecord):
            self._require_there(reply.result, reply.host)
            return Outcome(job=flight.job, record=reply.result)
        record, content = reply.result
        self._store.commit_file(record.trial_id, content)
        return Outcome(job=flight.job, record=record)

    def _lost(self, flight: Flight, error: WorkerLost) -> Outcome | None:
        now = time.monotonic()
        if flight.attempt < ATTEMPTS:
            self._again.append(replace(flight, start=now + PAUSE, attempt=flight.attempt + 1))
            return None
        seconds, attempts = now - flight.start, flight.attempt * error.workers
        how = "worker process was lost"
        if seconds >= flight.job.timeout:
            how = f"time-out: not done within {flight.job.timeout:.0f} s"
        reason = f"{how} (the last one was {error.address}){error.words}\n({attempts} attempts)"
        return Outcome(job=flight.job, record=None, reason=reason, seconds=seconds)

    def _require_there(self, record: TrialRecord, host: str) -> None:
        """Wait until a folder of the network shows what a worker has committed to it."""
        path, end = self._store.file(record.trial_id), time.monotonic() + SIGHT_TIME
        while not path.exists() and self._store.path.is_dir():
            if time.monotonic() >= end:
                raise StoreError(
                    f"{path}: a worker on {host} has written this file, and it is not to be seen "
                    f"here. Use a folder that both share, or --no-shared-store. {GO_ON}"
                )
            with suppress(OSError):
                next(path.parent.iterdir(), None)  # makes a network's folder look anew
            time.sleep(0.05)

    def _take_back(self) -> None:
        """Cancel what is in flight; a trial that runs on elsewhere ends harmlessly."""
        futures = list(self._flights)
        self._flights.clear()
        self._cluster.take_back(futures)


@contextmanager
def _token(store: Path, shared: bool) -> Iterator[Token | None]:
    """A proof in the store, while the block runs, that who sees it sees this very store."""
    if not shared:
        yield None
        return
    token = Token(store / f"dask-{token_hex(8)}{PARTIAL}", token_hex(16))
    _write(token)
    try:
        yield token
    finally:
        with suppress(OSError):
            token.path.unlink(missing_ok=True)


def _write(token: Token) -> None:
    try:
        token.path.write_text(token.content)
    except OSError as error:
        raise unwritable(token.path, error) from error
