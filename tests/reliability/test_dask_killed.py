"""Workers, scheduler and driver of a Dask cluster die by SIGKILL, and the table is the same.

Trials are pretended; processes, signals and the store are real. The scheduler is as a lab starts
it, which tries a trial up to four times.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from gaitlab.running import Progress, Summary, dispatch
from gaitlab.store import Store
from tests.reliability import sweeps
from tests.reliability.drivers import Drivers, children, drivers, runs, until

pytest.importorskip("distributed", reason="Dask is not installed")

from gaitlab.running.dask_cluster import DaskCluster
from gaitlab.running.dask_connection import SchedulerLost
from tests.clustered import scheduler, worker_pids, workers

KILLS = 20
SEEDS = 6
FORM = f"pretended+seeds-{SEEDS}"
TRIED_AGAIN = 3  # Dask's own setting
TRIAL = 0.1  # s


@pytest.fixture(scope="module")
def gaitlab() -> Iterator[Drivers]:
    with drivers() as started:
        yield started


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """A store that one process has filled."""
    store = Store(tmp_path_factory.mktemp("serial") / "data")
    sweeps.run(store, seeds=SEEDS)
    return store


def there(store: Store, name: str = sweeps.NAME) -> dict[str, bytes]:
    """Every byte but the list of trials, which says what their experiment is called."""
    return {file: text for file, text in sweeps.content(store, name).items() if name not in file}


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> None:
    task = partial(sweeps.pretend, pause=TRIAL)
    monkeypatch.setattr("gaitlab.running.processes.simulated", task)


def run(store: Store, address: str, progress: Progress | None = None) -> Summary:
    with DaskCluster(address) as cluster:
        wanted = sweeps.experiment(seeds=SEEDS)
        return dispatch(wanted, store, jobs=0, cluster=cluster, progress=progress)


def kill_workers(nanny: int, store: Store, over: threading.Event, killed: list[int]) -> None:
    """Kill a worker at random instants until enough are killed.

    A few trials end in between, for no cluster gets anywhere whose workers die as they start.
    """
    chance, known = random.Random(17), 0
    while len(killed) < KILLS and not over.is_set():
        until(partial(_more, store, known + chance.randrange(1, 6), over), seconds=60.0)
        time.sleep(chance.uniform(0.0, 2 * TRIAL))
        known = sweeps.committed(store)
        if pids := worker_pids(nanny):
            with suppress(ProcessLookupError):
                killed.append(pid := chance.choice(pids))
                os.kill(pid, signal.SIGKILL)


def _more(store: Store, wanted: int, over: threading.Event) -> bool:
    return over.is_set() or sweeps.committed(store) >= wanted


@pytest.mark.long
@pytest.mark.usefixtures("slow")
def test_twenty_workers_killed_at_random_instants_leave_no_trace(
    store: Store, tmp_path: Path, serial: Store
) -> None:
    over, killed = threading.Event(), list[int]()
    with (
        scheduler(tmp_path, tried_again=TRIED_AGAIN) as (_, address),
        workers(address, tmp_path, 2) as nanny,
    ):
        killer = threading.Thread(target=kill_workers, args=(nanny.pid, store, over, killed))
        killer.start()
        try:
            summary = run(store, address)
        finally:
            over.set()
            killer.join(90.0)
    assert len(killed) == KILLS, "the run was long enough for all of them"
    assert (summary.left, summary.failed) == (0, 0)
    assert sweeps.content(store) == sweeps.content(serial)


class Killing(Progress):
    """Kills a process after some trials."""

    def __init__(self, pid: int, after: int) -> None:
        self.pid, self.left = pid, after

    def ended(self, trial: object) -> None:
        self.left -= 1
        if self.left == 0:
            os.kill(self.pid, signal.SIGKILL)


@pytest.mark.long
@pytest.mark.usefixtures("slow")
def test_a_killed_scheduler_costs_what_was_in_flight_and_nothing_else(
    store: Store, tmp_path: Path, serial: Store
) -> None:
    with scheduler(tmp_path) as (process, address):
        port = int(address.rpartition(":")[2])
        with workers(address, tmp_path, 2):
            with pytest.raises(SchedulerLost):
                run(store, address, Killing(process.pid, after=20))
            process.wait(30.0)
    assert 20 <= sweeps.committed(store) <= 24
    with scheduler(tmp_path, port=port) as (_, again), workers(again, tmp_path, 2):
        assert again == address, "the same command"
        assert run(store, again).left == 0
    assert sweeps.content(store) == sweeps.content(serial)


@pytest.mark.long
def test_a_killed_driver_leaves_its_workers_whole_and_the_next_goes_on(
    gaitlab: Drivers, store: Store, tmp_path: Path, serial: Store
) -> None:
    with scheduler(tmp_path) as (_, address), workers(address, tmp_path, 2) as nanny:
        command = ("run", str(sweeps.FILE), "--store", str(store.path), "--dask", address)
        command += ("--seeds", str(SEEDS))
        pid = gaitlab.start(*command)
        assert until(lambda: sweeps.committed(store) >= 20, seconds=60.0)
        before = worker_pids(nanny.pid)
        os.kill(pid, signal.SIGKILL)
        assert gaitlab.wait(pid) == -signal.SIGKILL
        assert gaitlab.run(*command, errors=tmp_path / "errors") == 0
        assert worker_pids(nanny.pid) == before, "no worker died of it"
    assert there(store, FORM) == there(serial)
    assert not list(store.path.rglob("*.tmp"))


@pytest.mark.long
def test_workers_of_this_machine_end_with_a_killed_driver(gaitlab: Drivers, store: Store) -> None:
    pid = gaitlab.start(*local(store), task="stuck")
    assert until(lambda: len(list(store.path.glob("stuck-*"))) == 2, seconds=60.0)
    started = children(pid)
    assert started
    os.kill(pid, signal.SIGKILL)
    gaitlab.wait(pid)
    assert until(lambda: not any(map(runs, started)), seconds=10.0)


@pytest.mark.long
def test_the_first_ctrl_c_waits_for_what_runs_and_the_second_does_not(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    with socket.socket() as taken:
        with suppress(OSError):  # somebody else has it
            taken.bind(("127.0.0.1", 8787))  # that of Dask's own pages
            taken.listen()
        pid = gaitlab.start(*local(store), task="stuck", errors=tmp_path / "errors")
        assert until(lambda: len(list(store.path.glob("stuck-*"))) == 2, seconds=60.0)
    started = children(pid)
    os.kill(pid, signal.SIGINT)
    assert until(lambda: "finished first" in (tmp_path / "errors").read_text())
    assert not until(lambda: not runs(pid), seconds=1.0), "it waits for what runs"
    os.kill(pid, signal.SIGINT)
    assert until(lambda: not runs(pid))
    assert gaitlab.wait(pid) == 130
    assert until(lambda: not any(map(runs, started)), seconds=10.0)
    told = (tmp_path / "errors").read_text()
    assert "Traceback" not in told
    assert "distributed" not in told, "Dask says nothing of its own"
    assert "Port" not in told
    assert not list(store.path.rglob("*.tmp"))


@pytest.mark.long
def test_a_stopped_run_drains_and_goes_on_where_it_was(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    pid = gaitlab.start(*local(store), task="held", errors=tmp_path / "errors")
    assert until(lambda: sweeps.committed(store) >= 2, seconds=60.0)
    os.kill(pid, signal.SIGTERM)
    assert until(lambda: "finished first" in (tmp_path / "errors").read_text())
    (tmp_path / "go").touch()
    assert gaitlab.wait(pid) == 130
    done = sweeps.committed(store)
    assert 2 <= done <= 6
    assert sweeps.run(store).cached == done


def local(store: Store) -> tuple[str, ...]:
    return ("run", str(sweeps.FILE), "--store", str(store.path), "--dask", "local", "-j", "2")
