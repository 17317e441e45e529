"""Workers of Dask in jobs of a real SLURM, which may end before the run does."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from gaitlab.errors import UsageError
from gaitlab.running import Ended, Progress, dispatch
from gaitlab.store import Store
from tests.reliability import sweeps
from tests.reliability.drivers import ROOT

pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not installed")

from gaitlab.running.dask_cluster import DaskCluster

loopback = pytest.importorskip("tests.cluster.loopback_slurm", reason="no SLURM on loopback")

FILE = """\
workers: 3
cores: 2
memory: 1 GB
walltime: 00:10:00
partition: main
"""


@pytest.fixture
def slurm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Any]:
    monkeypatch.chdir(tmp_path)
    with tempfile.TemporaryDirectory(prefix="slurm-") as folder:
        try:
            with loopback.loopback_slurm(Path(folder), cpus=4) as started:
                monkeypatch.setenv("SLURM_CONF", str(started.configuration))
                monkeypatch.setenv("PYTHONPATH", str(ROOT))
                yield started
        except loopback.NoSlurm as error:
            pytest.skip(str(error))


class Cancelling(Progress):
    """Ends a job after some trials, as its walltime would."""

    def __init__(self, slurm: Any, after: int) -> None:
        self.slurm, self.left, self.jobs = slurm, after, set[str]()

    def ended(self, trial: Ended) -> None:
        self.left -= 1
        running = [line.split()[0] for line in self.slurm.queue("RUNNING")]
        self.jobs.update(running)
        if self.left == 0:
            self.slurm.run("scancel", running[0])


@pytest.mark.long
def test_a_job_that_ends_is_replaced_and_the_table_is_that_of_one_machine(
    slurm: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = partial(sweeps.pretend, pause=0.3)
    monkeypatch.setattr("gaitlab.running.processes.simulated", task)
    monkeypatch.setattr("gaitlab.running.dask_connection.REFILL_PERIOD", 3.0)
    (tmp_path / "cluster.yaml").write_text(FILE)
    there, here = Store(tmp_path / "there"), Store(tmp_path / "here")
    progress, wanted = Cancelling(slurm, after=10), sweeps.experiment(seeds=6)
    with DaskCluster("slurm") as cluster:
        assert cluster.workers == 3
        summary = dispatch(wanted, there, jobs=0, cluster=cluster, progress=progress)
    assert (summary.left, summary.failed) == (0, 0)
    assert len(progress.jobs) == 3, "two, and one in the place of the first"
    sweeps.run(here, seeds=6)
    assert sweeps.content(there) == sweeps.content(here)
    slurm.wait_until_empty(60.0)


@pytest.mark.long
def test_what_slurm_refuses_is_one_message(slurm: Any, tmp_path: Path) -> None:
    del slurm
    file = tmp_path / "lab.yaml"
    file.write_text(FILE.replace("main", "nowhere"))
    store = Store(tmp_path / "data")
    with DaskCluster(str(file)) as cluster, pytest.raises(UsageError, match="partition") as caught:
        dispatch(sweeps.experiment(), store, jobs=0, cluster=cluster)
    assert len(str(caught.value).splitlines()) == 1
    assert not list(store.path.rglob("*.parquet"))


def test_where_nothing_submits_jobs_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "lab.yaml"
    file.write_text(FILE)
    with DaskCluster(str(file)) as cluster, pytest.raises(UsageError, match="sbatch"):
        dispatch(sweeps.experiment(), Store(tmp_path / "data"), jobs=0, cluster=cluster)
