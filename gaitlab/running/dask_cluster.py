"""Trials on the workers of a Dask cluster, which may come and go while a run goes on.

The scheduler is Dask's: it gives a trial to a worker that is free and, when that worker is lost,
to another. Nothing of it is kept when it dies, nor need it be: what is committed is in the store,
and the same command goes on from there. A trial that Dask starts twice gives the same twice.
"""

from __future__ import annotations

import asyncio
import json
import logging
import pickle
import re
import shutil
import tempfile
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from secrets import token_hex
from typing import TYPE_CHECKING, Any

from gaitlab.errors import StoreError, UsageError, WrongValue
from gaitlab.running.cluster_file import USUAL, ClusterFile, read_cluster_file
from gaitlab.running.dask_worker import (
    CALL,
    INSTALL_ALIKE,
    Order,
    Reply,
    Token,
    probe,
    unlike,
    versions,
)
from gaitlab.running.executor import Executor, Job, Outcome
from gaitlab.running.processes import ATTEMPTS, LAST_WORDS, deaf_child, fair_memory
from gaitlab.running.worker import encoded
from gaitlab.simulation.engines import engine_of
from gaitlab.store import Store, TrialRecord
from gaitlab.store.durable import PARTIAL, unwritable

if TYPE_CHECKING:
    from distributed import Client, Future

ANSWER_TIME = 5.0  # s in which a scheduler must answer
LOOK_PERIOD = 0.5  # s between looks at who is there
REFILL_PERIOD = 30.0  # s between looks at jobs that have ended
SIGHT_TIME = 60.0  # s in which a network's folder must show what a worker has committed
PAUSE = 3.0  # s before the second attempt at a trial: workers of a job or a machine die together
CLOSE_TIME = 1.0  # s for workers of one's own to end by themselves
HOST_AND_PORT = re.compile(r"[\w.-]+:\d+")
FORMS = (
    "give the address of a scheduler (tcp://host:8786) or the file it wrote, `local` for workers "
    "of this machine, or `slurm` or a FILE.yaml that says what to ask SLURM for"
)
GO_ON = "What is committed is safe; the same command goes on from there."
LOGGERS = ("distributed", "tornado", "asyncio", "dask_jobqueue", "bokeh")
SETTINGS: dict[str, object] = {
    "distributed.comm.timeouts.connect": f"{ANSWER_TIME:.0f}s",
    "distributed.scheduler.allowed-failures": 0,  # the second attempt is ours, see PAUSE
    "distributed.scheduler.work-stealing": False,  # one trial a worker leaves nothing to steal
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": False,
    "distributed.admin.large-graph-warning-threshold": "1GB",
}


class SchedulerLost(StoreError):
    """The scheduler of a cluster has gone; the store is whole, and holds what was committed."""


class DaskCluster:
    """Workers that Dask has, or starts when the first trial needs them.

    Args:
        where: Address of a scheduler, a scheduler's file, `local`, `slurm`, or a YAML file for
            SLURM.
        jobs: Workers of a local one.
        shared: Whether the workers see the store; else results travel through the scheduler.

    Raises:
        UsageError: If nothing of that form is there.
        WrongValue: If Dask is not installed.
        FileError: If the YAML file is wrong.
    """

    def __init__(self, where: str, *, jobs: int = 1, shared: bool = True) -> None:
        _require_installed("distributed")
        self.shared, self._jobs = shared, jobs
        self.address, self.file = _place(where)
        self._resources = ExitStack()
        self._refilled = time.monotonic()
        self._slurm: Any = None
        self._started, self._missing = set[str](), set[str]()  # jobs of SLURM, by name

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def local(self) -> bool:
        """Whether the workers are this machine's and end with this process."""
        return not self.address and self.file is None

    @property
    def workers(self) -> int:
        """Trials that run side by side now, or will when the workers are there; at least 1.

        Raises:
            UsageError: If the scheduler does not answer.
        """
        if self.local:
            return self._jobs
        return self.file.workers if self.file else max(1, len(self.threads()))

    def executor(
        self, store: Path, task: Callable[..., TrialRecord], message: Callable[[str], None]
    ) -> Executor:
        """What runs trials here into a store; see `Cluster`."""
        return DaskExecutor(self, Store(store.absolute()), task, message)

    def threads(self) -> dict[str, int]:
        """Threads of each worker that is there, by its address."""
        found: dict[str, int] = self.client.nthreads()
        return found

    @cached_property
    def client(self) -> Client:
        """The connection; made, and workers of one's own started, at the first use."""
        import dask
        from distributed import Client

        _silence()
        self._resources.enter_context(dask.config.set(SETTINGS))
        if self.address:
            _require_answer(self.address)
        target = self.address or (self._submitted(self.file) if self.file else self._local())
        try:
            client = Client(target, timeout=ANSWER_TIME, set_as_default=False)
        except ImportError as error:  # another Dask
            raise WrongValue(
                f"--dask {self.address}: {str(error).strip()}; {INSTALL_ALIKE}"
            ) from error
        except OSError as error:
            raise _no_answer(self.address) from error
        self._resources.callback(client.close, ANSWER_TIME)
        return client

    @cached_property
    def output(self) -> Path | None:
        """Folder for what local workers print, which would else come to the terminal."""
        if not self.local:
            return None
        folder = tempfile.TemporaryDirectory(prefix="gaitlab-", ignore_cleanup_errors=True)
        return Path(self._resources.enter_context(folder))

    def refill(self) -> None:
        """Ask SLURM for another job in the place of each that has ended, at its walltime mostly."""
        if self._slurm is None or time.monotonic() < self._refilled + REFILL_PERIOD:
            return
        self._refilled, slurm = time.monotonic(), self._slurm
        there = self.client.scheduler_info(n_workers=-1)["workers"].values()
        living = {name for name in slurm.workers if any(_is_of(name, w["name"]) for w in there)}
        missing = (self._started | living) - living
        ended, self._missing = missing & self._missing, missing  # a killed worker is back by then
        self._started |= living

        async def replace() -> None:
            for name in ended & set(slurm.workers):
                await slurm.workers.pop(name).close()
            await slurm

        if ended:
            with suppress(RuntimeError):  # SLURM takes no more now; later it may
                slurm.sync(replace)

    def close(self) -> None:
        """End the connection, and the workers that were started for it."""
        with suppress(Exception):  # whatever has gone already
            self._resources.close()
        self.__dict__.pop("client", None)
        self.__dict__.pop("output", None)

    def _local(self) -> Any:
        from distributed import LocalCluster

        with deaf_child():
            cluster = LocalCluster(
                n_workers=self._jobs,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=None,
                memory_limit=0,
                silence_logs=logging.CRITICAL,
                env={"NUMBA_NUM_THREADS": "1"},
            )
        self._resources.callback(_end, cluster)
        return cluster

    def _submitted(self, file: ClusterFile) -> Any:
        _require_installed("dask_jobqueue")
        if shutil.which("sbatch") is None:
            raise UsageError(
                "--dask slurm: there is no `sbatch` here; run this on a machine that submits jobs"
            )
        from dask_jobqueue import SLURMCluster

        slurm = self._slurm = SLURMCluster(**_slurm_options(file))
        self._resources.callback(_end_slurm, slurm)

        async def submit() -> None:  # `scale` would keep what sbatch says to itself
            for _ in range(file.jobs):
                slurm.worker_spec.update(slurm.new_worker_spec())
            await slurm

        try:
            slurm.sync(submit)
        except RuntimeError as error:  # what sbatch said
            said = str(error).partition("stderr:")[2].strip() or str(error)
            raise UsageError(
                f"--dask slurm: SLURM takes no such job: {' '.join(said.split())}; "
                "mend the file for SLURM"
            ) from error
        return slurm


def _is_of(job: str, worker: str) -> bool:
    """Whether a worker is one of a job's, by their names."""
    return worker == job or worker.startswith(f"{job}-")


def _slurm_options(file: ClusterFile) -> dict[str, Any]:
    """What dask-jobqueue is given: workers that end before SLURM ends them, not all at once."""
    lifetime = ["--lifetime", f"{file.seconds - file.margin}s"]
    stagger = ["--lifetime-stagger", f"{file.margin // 2}s"]
    return {
        "cores": file.cores,
        "processes": file.cores,
        "memory": file.memory,
        "walltime": file.walltime,
        "queue": file.partition or None,
        "account": file.account or None,
        "interface": file.interface or None,
        "job_extra_directives": list(file.sbatch),
        "job_script_prologue": list(file.prologue),
        "log_directory": file.logs,
        "worker_extra_args": [*lifetime, *stagger, "--memory-limit", "0"],
        "scheduler_options": {"dashboard": False, "dashboard_address": None},
        "silence_logs": logging.CRITICAL,
    }


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
        cluster: DaskCluster,
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
        key = f"gaitlab-{job.trial_id[:8]}-{token_hex(8)}"
        with _scheduler_there(cluster):
            names = {"order": pickle.dumps(order)}
            future = cluster.client.submit(eval, CALL, names, key=key, pure=False, retries=0)
        self._flights[future] = flight
        future.add_done_callback(self._ended.put)

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
        with _scheduler_there(self._cluster):
            self._threads = self._cluster.threads()
            self._cluster.refill()
        if token is not None and not token.path.exists() and self._store.path.is_dir():
            _write(token)  # another run has tidied up
        if not self._threads and self._cluster.address:
            self._say(
                f"no worker has joined the scheduler at {self._address}; waiting. "
                f"Start some with `dask worker {self._address} --nthreads 1 --nworkers N`"
            )
        elif not self._threads and self._cluster.file:
            self._say(
                "waiting until SLURM starts a job; `squeue --me` says why it does not, and what "
                f"jobs print is in {self._cluster.file.logs}"
            )
        elif any(count > 1 for count in self._threads.values()):
            self._say(
                "a worker walks one trial at a time, and some here have more threads: "
                f"start them with `dask worker {self._address} --nthreads 1 --nworkers N`"
            )
        self._next_look = time.monotonic() + LOOK_PERIOD

    @property
    def _address(self) -> str:
        found: str = self._cluster.client.scheduler.address
        return found

    def _say(self, text: str) -> None:
        """Tell the user, once."""
        if text not in self._said:
            self._said.add(text)
            with suppress(OSError):
                self._message(text)

    def _collect(self, future: Future) -> Outcome | None:
        """The outcome of a job that has ended; None if it is to be run again."""
        from distributed import KilledWorker

        flight = self._flights[future]
        try:
            with _scheduler_there(self._cluster, future):
                reply: Reply = future.result()
        except KilledWorker as error:
            del self._flights[future]
            return self._lost(flight, error)
        except (StoreError, UsageError):
            raise
        except Exception as error:
            self._explain(flight.job)
            raise RuntimeError(f"on a worker of Dask: {error}") from error
        del self._flights[future]
        if isinstance(reply.result, Exception):
            raise reply.result
        if isinstance(reply.result, TrialRecord):
            self._require_there(reply.result, reply.host)
            return Outcome(job=flight.job, record=reply.result)
        record, content = reply.result
        self._store.commit_file(record.trial_id, content)
        return Outcome(job=flight.job, record=record)

    def _lost(self, flight: Flight, error: Any) -> Outcome | None:
        now, seconds = time.monotonic(), time.monotonic() - flight.start
        if flight.attempt < ATTEMPTS:
            self._again.append(replace(flight, start=now + PAUSE, attempt=flight.attempt + 1))
            return None
        attempts = flight.attempt * (error.allowed_failures + 1)
        last = error.last_worker
        if seconds >= flight.job.timeout:
            reason = f"time-out: not done within {flight.job.timeout:.0f} s"
        else:
            reason = "worker process was lost"
        reason += f" (the last one was {last.address})"
        folder = self._cluster.output
        if folder is not None:
            with suppress(OSError):
                words = (folder / str(last.pid)).read_text(errors="replace").splitlines()
                reason += "".join(f"\n{line}" for line in words[-LAST_WORDS:])
        return Outcome(
            job=flight.job,
            record=None,
            reason=f"{reason}\n({attempts} attempts)",
            seconds=seconds,
        )

    def _explain(self, job: Job) -> None:
        """Find out whether a worker could not even read what it was given.

        Raises:
            WrongValue: If one has another gaitlab or Python, or none.
        """
        engine = engine_of(job.trial)
        here = versions(engine)
        with _scheduler_there(self._cluster):
            told = self._cluster.client.run(eval, probe(engine), on_error="return")
        for found in told.values():
            if isinstance(found, tuple):
                host, package, python, code = found
                there = type(here)(package, python, code)
                if not there.alike(here):
                    raise unlike(host, str(there), here)

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
        if futures and self._cluster.client.status == "running":
            with suppress(Exception):
                self._cluster.client.cancel(futures, force=True)


def _place(where: str) -> tuple[str, ClusterFile | None]:
    """Address of a scheduler or the file for SLURM; neither for workers of this machine."""
    path = Path(where)
    if where == "local":
        return "", None
    if where == "slurm":
        if not USUAL.exists():
            raise UsageError(
                f"--dask slurm: there is no {USUAL} here; write one with `workers:`, `memory:` and "
                "`walltime:`, or name another with --dask FILE.yaml"
            )
        return "", read_cluster_file(USUAL)
    if path.suffix in (".yaml", ".yml"):
        return "", read_cluster_file(path)
    if "://" in where:
        return where, None
    if HOST_AND_PORT.fullmatch(where):
        return f"tcp://{where}", None
    try:
        address = json.loads(path.read_text())["address"]
    except OSError as error:
        raise UsageError(f"--dask {where}: no such file ({error.strerror}); {FORMS}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"--dask {where}: not a file that a scheduler wrote; {FORMS}") from error
    return str(address), None


def _require_installed(package: str) -> None:
    if find_spec(package) is None:
        raise WrongValue(
            f"--dask needs {package.replace('_', '-')}, which is not installed: "
            "`pip install 'gaitlab[cluster]'`"
        )


def _require_answer(address: str) -> None:
    """Find out who listens there; a client of Dask's waits for ever for one who is silent.

    Raises:
        UsageError: If it is no scheduler.
    """
    from distributed import rpc

    async def identity() -> dict[str, Any]:
        async with rpc(address) as peer:
            found: dict[str, Any] = await asyncio.wait_for(peer.identity(n_workers=0), ANSWER_TIME)
            return found

    try:
        with ThreadPoolExecutor(1) as thread:  # a notebook has a loop running in this one
            found = thread.submit(lambda: asyncio.run(identity())).result()
    except Exception as error:  # whatever a foreign program's answer makes of Dask
        raise _no_answer(address) from error
    if found.get("type") != "Scheduler":
        raise _no_answer(address)


def _no_answer(address: str) -> UsageError:
    return UsageError(
        f"--dask {address}: no scheduler of Dask answers there within {ANSWER_TIME:.0f} s; start "
        "one with `dask scheduler`, or check host and port"
    )


def _silence() -> None:
    """Nothing that Dask says of itself reaches the user's terminal."""
    from distributed.versions import VersionMismatchWarning

    warnings.filterwarnings("ignore", category=VersionMismatchWarning)
    for name in {*LOGGERS, *logging.root.manager.loggerDict}:
        if name.partition(".")[0] in LOGGERS:
            logger = logging.getLogger(name)
            logger.handlers, logger.propagate = [logging.NullHandler()], False


def _end(cluster: Any) -> None:
    """End a local cluster, whatever its workers do."""

    async def end_workers() -> None:
        nannies = list(cluster.workers.values())
        for nanny in nannies:
            nanny.auto_restart = False
        await asyncio.gather(
            *(nanny.kill(timeout=CLOSE_TIME) for nanny in nannies), return_exceptions=True
        )

    with suppress(Exception):
        cluster.sync(end_workers)
    cluster.close()


def _end_slurm(slurm: Any) -> None:
    """End a cluster of SLURM's jobs; those that SLURM never took are none to wait for."""
    from distributed.core import Status

    for job in list(slurm.workers.values()):
        if job.job_id is None:
            job.status = Status.failed
    slurm.close()


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


@contextmanager
def _scheduler_there(cluster: DaskCluster, future: Future | None = None) -> Iterator[None]:
    """What the loss of the scheduler raises becomes one error.

    Raises:
        SchedulerLost: If it is lost.
    """
    try:
        yield
    except (asyncio.CancelledError, CancelledError, OSError) as error:
        raise SchedulerLost(
            f"the scheduler of Dask at {cluster.address or 'this machine'} is gone. {GO_ON}"
        ) from error
    if cluster.client.status != "running":
        raise SchedulerLost(
            f"the scheduler of Dask at {cluster.address or 'this machine'} is gone. {GO_ON}"
        )
