"""Trials on a real scheduler and real workers of Dask, on this machine's loopback."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, StoreError, WrongValue
from gaitlab.experiment.plan import plan
from gaitlab.running import Progress, dispatch
from gaitlab.running.executor import Job, job_of
from gaitlab.search.search import optimize
from gaitlab.store import Store, TrialRecord
from tests.reliability import sweeps
from tests.reliability.drivers import ROOT, until
from tests.search import searches

pytest.importorskip("distributed", reason="Dask is not installed")

from gaitlab.running.cluster_file import read_cluster_file
from gaitlab.running.dask_cluster import DaskCluster
from gaitlab.running.dask_connection import SchedulerLost
from gaitlab.running.dask_worker import versions
from tests.clustered import pretend_encoded, scheduler, workers

WORKERS = 2


class Place(NamedTuple):
    """A cluster that several tests share."""

    address: str
    nanny: subprocess.Popen[bytes]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    folder = tmp_path_factory.mktemp("cluster")
    with scheduler(folder) as (_, address), workers(address, folder, WORKERS) as nanny:
        yield Place(address, nanny)


@pytest.fixture
def cluster(place: Place) -> Iterator[DaskCluster]:
    with DaskCluster(place.address) as connected:
        assert until(lambda: len(connected.threads()) == WORKERS, seconds=60.0)
        yield connected


@pytest.fixture
def store(tmp_path: Path) -> Store:
    found = Store(tmp_path / "data")
    found.path.mkdir()
    return found


def jobs() -> list[Job]:
    trials = [item.trial for item in plan(sweeps.experiment()).trials()]
    return [job_of(trial.id, trial.to_dict(), 1.0) for trial in trials]


def noting(
    trial_id: str, trial: Mapping[str, Any], store: Path, *, deed: str = "work", bad: str = ""
) -> TrialRecord:
    """As `sweeps.pretend`, each attempt noted; the bad trial does something else."""
    with (store / f"tried-{trial_id}").open("a") as notes:
        notes.write("x")
    if trial_id == bad and deed == "fail":
        record = replace(sweeps.given(trial_id, trial), state="FAILED", reason="on purpose")
        Store(store).commit(record, None)
        return record
    if trial_id == bad and deed == "full disk":
        raise StoreError("the disk is full")
    if trial_id == bad:
        sweeps.DEEDS[deed]()
    return sweeps.pretend(trial_id, trial, store)


def tried(store: Store, trial_id: str) -> int:
    return len((store.path / f"tried-{trial_id}").read_text())


def csv(store: Store, capsys: pytest.CaptureFixture[str]) -> str:
    """What a user asks a store for, in an order that does not hang on how the run went."""
    capsys.readouterr()
    sql = "SELECT trial_id, state, stable, fell, distance, seed FROM trials ORDER BY trial_id"
    assert run_command_line(["query", sql, "--format", "csv", "--store", str(store.path)]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("shared", [True, False])
def test_a_cluster_gives_the_store_of_a_serial_run(
    place: Place, tmp_path: Path, monkeypatch, capsys, shared: bool
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.pretend)
    monkeypatch.setattr("gaitlab.running.dask_cluster.encoded", pretend_encoded)
    there, here = Store(tmp_path / "there"), Store(tmp_path / "here")
    sweeps.run(here)
    with DaskCluster(place.address, shared=shared) as cluster:
        first = dispatch(sweeps.experiment(), there, jobs=0, cluster=cluster)
        again = dispatch(sweeps.experiment(), there, jobs=0, cluster=cluster)
    assert (first.done, first.left) == (first.planned, 0)
    assert (again.cached, again.done) == (first.planned, 0)
    assert sweeps.content(there) == sweeps.content(here)
    assert csv(there, capsys) == csv(here, capsys)
    assert not list(there.path.glob("*.tmp")), "no token is left behind"


def test_as_many_trials_are_in_flight_as_there_are_workers(
    cluster: DaskCluster, store: Store
) -> None:
    taken = 0

    def counted() -> Iterator[Job]:
        nonlocal taken
        for job in jobs():
            taken += 1
            yield job

    executor = cluster.executor(store.path, sweeps.slow, print)
    for ended, _ in enumerate(executor.run(counted())):
        assert taken - ended <= WORKERS
        assert executor.running < WORKERS + 1
        if ended == 5:
            executor.drain()
    assert taken == ended + 1 < len(jobs()), "what runs is finished, nothing more is taken"
    assert executor.running == 0


def test_jobs_may_seem_to_end_and_go_on(cluster: DaskCluster, store: Store) -> None:
    queue = jobs()[:3]

    class Queued(Iterator[Job]):
        def __next__(self) -> Job:
            if not queue:
                raise StopIteration
            return queue.pop()

    ended = cluster.executor(store.path, sweeps.pretend, print).run(Queued())
    wanted = {job.trial_id for job in queue}
    more = jobs()[5]
    assert {next(ended).job.trial_id, next(ended).job.trial_id} < wanted
    queue.append(more)
    assert {outcome.job.trial_id for outcome in ended} >= {more.trial_id}


@pytest.mark.parametrize(("deed", "times"), [("segfault", 2), ("exit", 2), ("fail", 1)])
def test_a_bad_trial_costs_itself_alone_and_a_failed_one_is_not_tried_again(
    cluster: DaskCluster, store: Store, monkeypatch, deed: str, times: int
) -> None:
    bad = jobs()[7].trial_id
    monkeypatch.setattr("gaitlab.running.processes.simulated", partial(noting, deed=deed, bad=bad))
    summary = dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster)
    assert (summary.failed, summary.left) == (1, 0)
    failed = [trial_id for trial_id, state in store.states().items() if state == "FAILED"]
    assert failed == [bad]
    assert tried(store, bad) == times
    if times > 1:
        assert "(2 attempts)" in store.record(bad).reason


def test_a_trial_that_hangs_ends_its_worker_and_is_called_a_time_out(
    cluster: DaskCluster, store: Store
) -> None:
    hanging, working = (replace(job, timeout=2.0) for job in jobs()[:2])
    task = partial(noting, deed="hang", bad=hanging.trial_id)
    found = list(cluster.executor(store.path, task, print).run([hanging, working]))
    reasons = {outcome.job.trial_id: outcome.reason for outcome in found}
    assert reasons[hanging.trial_id].startswith("time-out")
    assert reasons[working.trial_id] == ""
    assert tried(store, hanging.trial_id) == 2


def test_what_the_store_raises_ends_the_run_and_the_next_goes_on(
    cluster: DaskCluster, store: Store, monkeypatch
) -> None:
    bad = jobs()[3].trial_id
    task = partial(noting, deed="full disk", bad=bad)
    monkeypatch.setattr("gaitlab.running.processes.simulated", task)
    with pytest.raises(StoreError, match=f"on {socket.gethostname()}: the disk is full"):
        dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster)
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.pretend)
    assert dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster).left == 0


class Messages(Progress):
    def __init__(self) -> None:
        self.texts: list[str] = []

    def message(self, text: str) -> None:
        self.texts.append(text)


def test_workers_may_join_later_and_one_walks_one_trial_whatever_its_threads(
    tmp_path: Path, store: Store, monkeypatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", alone)
    progress = Messages()
    with scheduler(tmp_path) as (_, address), DaskCluster(address) as cluster:
        joining = workers(address, tmp_path, 1, threads=4)

        class Waiting(Messages):
            def message(self, text: str) -> None:
                progress.message(text)
                if len(progress.texts) == 1:
                    joining.__enter__()

        try:
            summary = dispatch(
                sweeps.experiment(), store, jobs=0, cluster=cluster, progress=Waiting()
            )
        finally:
            joining.__exit__(None, None, None)
    assert (summary.left, summary.failed) == (0, 0)
    assert len(progress.texts) == 2, "that none is there, and that threads do not help, each once"


def alone(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Fails if another trial runs in this process."""
    mark = store / f"busy-{os.getpid()}"
    with mark.open("x"):
        record = sweeps.slow(trial_id, trial, store)
    mark.unlink()
    return record


def other_gaitlab(folder: Path, version: str) -> str:
    """A path with a copy of gaitlab that says another version and simulates otherwise."""
    shutil.copytree(ROOT / "gaitlab", folder / "gaitlab")
    info = folder / f"gaitlab-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: gaitlab\nVersion: {version}\n")
    with (folder / "gaitlab" / "metrics" / "__init__.py").open("a") as file:
        file.write("# other code\n")
    return f"{folder}:{ROOT}"


@pytest.mark.parametrize("knows_dask", [True, False])
def test_a_worker_with_another_gaitlab_ends_the_run_and_both_versions_are_said(
    tmp_path: Path, store: Store, knows_dask: bool
) -> None:
    path = other_gaitlab(tmp_path, "9.8.7")
    if not knows_dask:
        (tmp_path / "gaitlab" / "running" / "dask_worker.py").unlink()
    with (
        scheduler(tmp_path) as (_, address),
        workers(address, tmp_path, 1, path),
        DaskCluster(address) as cluster,
        pytest.raises(WrongValue) as caught,
    ):
        dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster)
    here = versions("bullet")
    assert caught.value.exit_code == 3
    for part in ("9.8.7", here.gaitlab, here.python, here.code, socket.gethostname()):
        assert part in str(caught.value)
    assert not list(store.path.rglob("*.parquet"))


@pytest.mark.long
def test_a_worker_that_does_not_see_the_store_names_itself_and_the_way_out(
    tmp_path: Path, store: Store, monkeypatch
) -> None:
    """In a namespace of its own, where another folder lies over the store."""
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.pretend)
    monkeypatch.setattr("gaitlab.running.dask_cluster.encoded", pretend_encoded)
    over = f"mount -t tmpfs none {store.path}"
    before = ["unshare", "--mount", "sh", "-c", f'{over} && exec "$0" "$@"']
    if not shutil.which("unshare") or subprocess.run([*before, "true"], timeout=120).returncode:
        pytest.skip("this user may not mount a folder over another")
    with scheduler(tmp_path) as (_, address), workers(address, tmp_path, before=before):
        with DaskCluster(address) as cluster, pytest.raises(StoreError) as caught:
            dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster)
        assert "--no-shared-store" in str(caught.value)
        assert socket.gethostname() in str(caught.value)
        assert not list(store.path.rglob("*.parquet"))
        with DaskCluster(address, shared=False) as cluster:
            assert dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster).left == 0


def test_a_lost_scheduler_ends_the_run_and_the_next_goes_on(
    tmp_path: Path, store: Store, monkeypatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.slow)

    class Killing(Progress):
        def ended(self, trial: object) -> None:
            if sweeps.committed(store) >= 5:
                process.kill()

    with (
        scheduler(tmp_path) as (process, address),
        workers(address, tmp_path),
        DaskCluster(address) as cluster,
        pytest.raises(SchedulerLost) as caught,
    ):
        dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster, progress=Killing())
    assert caught.value.exit_code == 7
    there = sweeps.committed(store)
    assert there >= 5
    again = sweeps.run(store)
    assert (again.cached, again.left) == (there, 0)


def test_a_study_finds_the_same_winner_with_dask(
    cluster: DaskCluster, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", searches.pretend)
    there, here = (
        optimize(searches.study(), Store(tmp_path / name), jobs=jobs, cluster=chosen).history
        for name, jobs, chosen in (("there", 0, cluster), ("here", 2, None))
    )
    assert there.candidates == here.candidates
    assert there.representative == here.representative is not None


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.mark.parametrize("listens", [False, True], ids=["nobody", "somebody else"])
def test_an_address_that_does_not_answer_is_one_message(
    tmp_path: Path, monkeypatch, capfd, listens: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.dask_connection.ANSWER_TIME", 1.0)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        port = silent.getsockname()[1] if listens else free_port()
        if listens:
            silent.listen()
        code = run_command_line(["run", str(sweeps.FILE), "--dask", f"tcp://127.0.0.1:{port}"])
    out, err = capfd.readouterr()
    assert (code, out) == (2, "")
    assert f"127.0.0.1:{port}" in err
    assert len(err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [
        ["--dask", "nowhere.json"],
        ["--dask", "slurm"],
        ["--dask", "tcp://nohost.invalid:1"],
        ["--dask", "foo://x:1"],
        ["--dask", ""],
        ["--dask", "."],
        ["--dask", "tcp://127.0.0.1:1", "-j", "2"],
        ["--dask", "local", "-j", "0"],
        ["--no-shared-store"],
    ],
)
def test_what_cannot_be_meant_is_refused_in_a_line(
    tmp_path: Path, monkeypatch, capfd, words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.dask_connection.ANSWER_TIME", 1.0)
    code = run_command_line(["run", str(sweeps.FILE), *words])
    out, err = capfd.readouterr()
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1, err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [["run", str(sweeps.FILE)], ["optimize", "eros_small"]])
def test_without_dask_it_is_said_how_to_get_it(monkeypatch, capfd, command: list[str]) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert run_command_line([*command, "--dask", "local"]) == 3
    assert "pip install 'gaitlab[cluster]'" in capfd.readouterr().err


GOOD = "workers: 4\nmemory: 8 GB\nwalltime: 01:00:00\n"


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("workers: 0\nmemory: 8 GB\nwalltime: 01:00:00\n", 1, 10),
        ("workers: 4\nmemory: much\nwalltime: 01:00:00\n", 2, 9),
        ("workers: 4\nmemory: 8 GB\nwalltime: 10\n", 3, 11),
        ("workers: 4\nmemory: 8 GB\nwalltime: an hour\n", 3, 11),
        ("workers: 4\nmemory: 8 GB\nwalltime: 00:00:30\n", 3, 11),
        (GOOD + "core: 2\n", 4, 1),
        (GOOD + "cores: two\n", 4, 8),
        (GOOD + "partition: a b\n", 4, 12),
        (GOOD + 'sbatch: ["--a\\n--b"]\n', 4, 10),
        (GOOD + "sbatch: --a\n", 4, 9),
        ("workers: 4\n", 1, 1),
    ],
)
def test_a_mistake_in_the_file_for_slurm_has_line_and_column(
    tmp_path: Path, text: str, line: int, column: int
) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text(text)
    with pytest.raises(FileError) as caught:
        DaskCluster(str(file))
    assert (caught.value.problems[0].line, caught.value.problems[0].column) == (line, column)


def test_workers_of_slurm_end_before_slurm_ends_them(tmp_path: Path) -> None:
    file = tmp_path / "lab.yaml"
    for walltime, seconds in (("01:00:00", 3600), ("1-12:00:00", 129600), ("02:00", 120)):
        file.write_text(GOOD.replace("01:00:00", f'"{walltime}"') + "cores: 3\n")
        asked = read_cluster_file(file)
        assert (asked.seconds, asked.jobs) == (seconds, 2)
        assert 0 < asked.margin < asked.seconds


def test_help_loads_no_dask() -> None:
    code = (
        "import sys; from gaitlab.cli import run_command_line; run_command_line(['run', '--help']);"
        "sys.exit(any(name.partition('.')[0] in ('dask', 'distributed') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, timeout=60).returncode == 0
