"""The connection to a Dask cluster: one that is there, workers of this machine, or SLURM's jobs.

All that knows Dask is here. Its scheduler hands out what it is given; nothing of that is kept when
it dies, nor need it be. Dask says nothing on the terminal and takes no signal.
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
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any, TypeVar

from gaitlab.errors import StoreError, UsageError, WrongValue
from gaitlab.model.settings import EngineName
from gaitlab.running.cluster_file import USUAL, ClusterFile, read_cluster_file
from gaitlab.running.dask_worker import CALL, INSTALL_ALIKE, Order, Reply, probe, unlike, versions
from gaitlab.running.processes import LAST_WORDS, START_TIME, deaf_child

if TYPE_CHECKING:
    from distributed import Client, Future

R = TypeVar("R")
C = TypeVar("C", bound="DaskConnection")
ANSWER_TIME = 5.0  # s in which a scheduler must answer
REFILL_PERIOD = 30.0  # s between looks at jobs that have ended
PATIENCE = 10  # times that a question is put again, each of at least `ANSWER_TIME`
CLOSE_TIME = 1.0  # s for workers of one's own to end by themselves
HOST_AND_PORT = re.compile(r"[\w.-]+:\d+")
FORMS = (
    "give the address of a scheduler (tcp://host:8786) or the file it wrote, `local` for workers "
    "of this machine, or `slurm` or a FILE.yaml that says what to ask SLURM for"
)
GO_ON = "What is committed is safe; the same command goes on from there."
LOGGERS = ("distributed", "tornado", "asyncio", "dask_jobqueue", "bokeh")
NO_DASHBOARD = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}  # a port that is free
SETTINGS: dict[str, object] = {
    "distributed.comm.timeouts.connect": f"{ANSWER_TIME:.0f}s",
    "distributed.scheduler.allowed-failures": 0,  # a lost worker is told of at once
    "distributed.scheduler.work-stealing": False,  # one trial a worker leaves nothing to steal
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": False,
    "distributed.admin.large-graph-warning-threshold": "1GB",
}


class SchedulerLost(StoreError):
    """The scheduler of a cluster has gone; the store is whole, and holds what was committed."""


class WorkerLost(Exception):
    """The process that had a trial has ended, whatever ended it.

    Attributes:
        address: Of the last one.
        workers: How many were lost with it, one after the other.
        words: What it printed last, where that is known.
    """

    def __init__(self, address: str, workers: int, words: str) -> None:
        super().__init__(address, workers, words)
        self.address, self.workers, self.words = address, workers, words


class DaskConnection:
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

    def __enter__(self: C) -> C:
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

    def threads(self) -> dict[str, int]:
        """Threads of each worker that is there, by its address.

        Raises:
            UsageError: If the scheduler does not answer.
            SchedulerLost: If it is lost.
        """
        client = self.client
        with self._scheduler_there():
            found: dict[str, int] = self._patiently(client.nthreads)
            return found

    @property
    def scheduler(self) -> str:
        """Address at which workers join."""
        found: str = self.client.scheduler.address
        return found

    def submit(self, order: Order, ended: Callable[[Future], None]) -> Future:
        """Hand an order to the scheduler; `ended` is called, in another thread, when it is done.

        Raises:
            SchedulerLost: If it is lost.
        """
        key, names = f"gaitlab-{order.trial_id[:8]}-{token_hex(8)}", {"order": pickle.dumps(order)}
        client = self.client
        with self._scheduler_there():
            future = client.submit(eval, CALL, names, key=key, pure=False, retries=0)
            future.add_done_callback(ended)
            return future

    def reply(self, future: Future, engine: EngineName) -> Reply:
        """What a worker says of an order that is done.

        Raises:
            WorkerLost: If the process that had it has ended.
            SchedulerLost: If the scheduler has.
            WrongValue: If a worker could not read it: it has another gaitlab or Python.
        """
        from distributed import KilledWorker

        try:
            with self._scheduler_there():
                return self._patiently(future.result)
        except KilledWorker as error:
            last = error.last_worker
            words = self._last_words(last.pid)
            raise WorkerLost(last.address, error.allowed_failures + 1, words) from None
        except StoreError:
            raise
        except Exception as error:
            self._explain(engine)
            raise RuntimeError(f"on a worker of Dask: {error}") from error

    def take_back(self, futures: list[Future]) -> None:
        """Cancel orders; a trial that runs on elsewhere ends harmlessly."""
        if futures and self.client.status == "running":
            with suppress(Exception):
                self.client.cancel(futures, force=True)

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
            limit = ANSWER_TIME if self.address else START_TIME
            client = Client(target, timeout=limit, set_as_default=False)
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
        with self._scheduler_there():
            info = self._patiently(partial(self.client.scheduler_info, n_workers=-1))
        there = info["workers"].values()
        living = {name for name in slurm.workers if any(_is_of(name, w["name"]) for w in there)}
        missing = (self._started | living) - living
        ended, self._missing = missing & self._missing, missing  # a killed worker is back by then
        self._started = (self._started | living) - ended  # its successor may wait for long

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

    @contextmanager
    def _scheduler_there(self) -> Iterator[None]:
        """What the loss of the scheduler raises becomes one error."""
        gone = SchedulerLost(
            f"the scheduler of Dask at {self.address or 'this machine'} is gone. {GO_ON}"
        )
        try:
            yield
        except (asyncio.CancelledError, CancelledError, OSError) as error:
            raise gone from error
        if self.client.status != "running":
            raise gone

    def _patiently(self, ask: Callable[[], R]) -> R:
        """An answer of the scheduler, which may be slow but whose connection stands."""
        for _ in range(PATIENCE):
            try:
                return ask()
            except OSError:
                if self.client.status != "running":
                    raise
        return ask()

    def _last_words(self, pid: int) -> str:
        """What a worker of this machine printed before it ended, each line after a line's end."""
        if self.output is None:
            return ""
        with suppress(OSError):
            words = (self.output / str(pid)).read_text(errors="replace").splitlines()
            return "".join(f"\n{line}" for line in words[-LAST_WORDS:])
        return ""

    def _explain(self, engine: EngineName) -> None:
        """Find out whether a worker has another gaitlab or Python, or no gaitlab at all."""
        here = versions(engine)
        with self._scheduler_there():
            told = self.client.run(eval, probe(engine), on_error="return")
        for found in told.values():
            if isinstance(found, tuple):
                host, *others = found
                there = type(here)(*others)
                if not there.alike(here):
                    raise unlike(host, str(there), here)

    def _local(self) -> Any:
        from distributed import LocalCluster

        with deaf_child():
            cluster = LocalCluster(
                n_workers=self._jobs,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=None,
                scheduler_kwargs=NO_DASHBOARD,
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

        try:
            slurm = self._slurm = SLURMCluster(**_slurm_options(file))
            self._resources.callback(_end_slurm, slurm)

            async def submit() -> None:  # `scale` would keep what sbatch says to itself
                for _ in range(file.jobs):
                    slurm.worker_spec.update(slurm.new_worker_spec())
                await slurm

            slurm.sync(submit)
        except (RuntimeError, ValueError, OSError) as error:  # what sbatch or the network said
            said = str(error).partition("stderr:")[2].strip() or str(error)
            raise UsageError(
                f"--dask slurm: nothing could be submitted: {' '.join(said.split())}; "
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
        "scheduler_options": NO_DASHBOARD,
        "silence_logs": logging.CRITICAL,
    }


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
    warnings.filterwarnings("ignore", module="distributed")
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
    """End a cluster of SLURM's jobs; those that SLURM never took are none to wait for.

    A job of dask-jobqueue never says itself that it is closed, which the cluster asks of those that
    have been replaced.
    """
    from distributed.core import Status

    for job in list(slurm._created):
        job.status = Status.failed if job.job_id is None else Status.closing
    slurm.close()
