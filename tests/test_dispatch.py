"""Runs of real plans: idempotent, stoppable at any instant, and the same table in the end."""

from __future__ import annotations

import contextlib
import gc
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from multiprocessing import active_children
from multiprocessing.context import SpawnProcess
from pathlib import Path

import pytest

from gaitlab.cli.common import plan_object
from gaitlab.errors import StoreError
from gaitlab.experiment.plan import plan
from gaitlab.running import Ended, Progress, Summary, cost, dispatch, outlook
from gaitlab.store import Shard, Store
from tests.pretended import (
    experiment,
    pretend,
    pretend_falling,
    pretend_late,
    pretend_well,
)
from tests.reliability.drivers import line_of

ROOT = Path(__file__).parent.parent
CELLS = 24


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


@pytest.fixture
def well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)


def contents(store: Store) -> tuple[bytes, bytes, str]:
    """Everything that must not depend on how a run went."""
    folder = store.path / "experiments" / "pretended"
    index, trials = store.path / "index.jsonl", folder / "trials.jsonl"
    return index.read_bytes(), trials.read_bytes(), store.table("pretended").to_csv()


@pytest.mark.usefixtures("well")
def test_a_run_does_everything_once_and_then_nothing(store: Store) -> None:
    first = dispatch(experiment(), store, jobs=0)
    assert (first.planned, first.done, first.left) == (CELLS, CELLS, 0)
    before = contents(store)
    second = dispatch(experiment(), store, jobs=0)
    assert (second.planned, second.cached, second.done) == (CELLS, CELLS, 0)
    assert second.falls == first.falls > 0
    assert contents(store) == before


class Told(Progress):
    """Keeps the messages, each with the trials that had ended before it."""

    def __init__(self) -> None:
        self.ends, self.messages = 0, list[tuple[int, str]]()

    def update(self, summary: Summary) -> None:
        self.ends += 1

    def message(self, text: str) -> None:
        self.messages.append((self.ends, text))


def test_falls_in_standing_are_counted_and_told_of_as_soon_as_a_cell_is_sure(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_falling)
    told, seeds, carpets = Told(), 4, CELLS // 2
    first = dispatch(experiment(seeds=seeds), store, jobs=0, progress=told)
    assert (first.falls, first.fell_standing) == (carpets * seeds * 3 // 2, carpets * seeds)
    ((ends, text),) = told.messages  # after the third of four seeds of its cell
    assert 2 * CELLS < ends <= 3 * CELLS
    assert "carpet_4mm" in text
    second = dispatch(experiment(seeds=seeds), store, jobs=0)
    assert (second.cached, second.fell_standing) == (CELLS * seeds, first.fell_standing)
    table = store.table(f"pretended+seeds-{seeds}")
    assert table["fell_standing"].sum() == first.fell_standing
    answer = store.query("SELECT count(*) AS n FROM trials WHERE fell_standing AND fell")
    assert answer["n"][0] == first.fell_standing


@pytest.mark.usefixtures("well")
def test_workers_and_this_process_give_the_same_store(store: Store, tmp_path: Path) -> None:
    other = Store(tmp_path / "other")
    dispatch(experiment(), store, jobs=2)
    dispatch(experiment(), other, jobs=0)
    assert contents(store) == contents(other)


@pytest.mark.usefixtures("well")
def test_more_seeds_run_only_the_new_trials(store: Store) -> None:
    dispatch(experiment(seeds=1), store, jobs=0)
    summary = dispatch(experiment(seeds=2), store, jobs=0)
    assert (summary.cached, summary.done) == (CELLS, CELLS)


def test_every_trial_ends_in_one_state_and_failures_wait_to_be_asked_for(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend)
    first = dispatch(experiment(), store, jobs=2)
    assert (first.done, first.infeasible, first.failed, first.left) == (19, 4, 1, 0)
    failed = [key for key, state in store.states().items() if state == "FAILED"]
    assert "exit code 3" in store.record(failed[0]).reason
    assert outlook(experiment(), store).count("failed before") == 1
    second = dispatch(experiment(), store, jobs=2)
    assert (second.cached, second.failed, second.newly_failed) == (23, 1, 0)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    again = dispatch(experiment(), store, jobs=0, retry_failed=True)
    assert (again.cached, again.done, again.failed) == (23, 1, 0)


def test_a_trial_that_only_took_too_long_is_run_again_by_the_next_run(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever else a trial failed by waits to be asked for."""
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_late)
    monkeypatch.setattr("gaitlab.running.executor.TIMEOUT", 1.0)
    monkeypatch.setattr("gaitlab.running.executor.TIMEOUT_RATIO", 0.0)
    first = dispatch(experiment(), store, jobs=2)
    assert (first.done, first.failed, first.left) == (CELLS - 2, 2, 0)
    found = outlook(experiment(), store)
    assert (found.count("timed out before"), found.count("failed before")) == (1, 1)
    assert found.due(retry_failed=False) == {"timed out before": 1}
    due = plan_object(found, cost(plan(experiment()), 1, 1))["to_run"]
    assert due == {"new": 0, "file_damaged": 0, "failed_before": 1, "timed_out_before": 1}
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    second = dispatch(experiment(), store, jobs=0)
    assert (second.cached, second.done, second.failed, second.left) == (CELLS - 2, 1, 1, 0)
    assert dispatch(experiment(), store, jobs=0).done == 0


@pytest.mark.usefixtures("well")
def test_a_damaged_trial_is_done_again(store: Store) -> None:
    dispatch(experiment(), store, jobs=0)
    before = contents(store)
    path = store.file(next(iter(store.states())))
    path.write_bytes(path.read_bytes()[:-100])
    found = outlook(experiment(), store)
    assert (found.count("file damaged"), found.count("cached")) == (1, CELLS - 1)
    assert dispatch(experiment(), store, jobs=0).done == 1
    assert contents(store) == before


def test_an_outlook_says_what_is_new_and_writes_nothing(store: Store) -> None:
    found = outlook(experiment(seeds=3), store)
    assert found.count("new") == found.planned == plan(experiment(seeds=3)).size == 3 * CELLS
    assert not store.path.exists()


@pytest.mark.usefixtures("well")
def test_an_experiment_that_is_held_runs_nothing(store: Store) -> None:
    for held in (store.writing("pretended"), store.writing("pretended", Shard.of("2/3"))):
        with held, pytest.raises(StoreError, match=r"pretended is run .*--shard|2-of-3"):
            dispatch(experiment(), store, jobs=0)
    with store.alone(), pytest.raises(StoreError, match="as a whole"):
        dispatch(experiment(), store, jobs=0)
    assert store.states() == {}


class Replacing(Progress):
    """Puts another store into the place of the one that is running, after a few trials."""

    def __init__(self, store: Store, away: Path, after: int) -> None:
        self.store, self.away, self.left = store, away, after

    def ended(self, trial: Ended) -> None:
        self.left -= 1
        if self.left == 0:
            self.store.path.rename(self.away)
            shutil.copytree(self.away, self.store.path)


@pytest.mark.usefixtures("well")
def test_a_run_whose_store_is_replaced_stops_and_leaves_the_other_alone(
    store: Store, tmp_path: Path
) -> None:
    with pytest.raises(StoreError):
        dispatch(experiment(), store, jobs=0, progress=Replacing(store, tmp_path / "away", 3))
    assert len(Store(tmp_path / "away").states()) == 3
    assert 3 <= len(store.states()) <= 4, "what was running may still have ended there"
    index = (store.path / "index.jsonl").read_bytes()
    assert index == (tmp_path / "away" / "index.jsonl").read_bytes(), "and is in no list of it"
    assert dispatch(experiment(), store, jobs=0).left == 0


@pytest.mark.usefixtures("well")
def test_trials_are_discarded_only_from_the_store_that_is_held(
    store: Store, tmp_path: Path
) -> None:
    dispatch(experiment(), store, jobs=0)
    with store.alone() as held:
        store.path.rename(tmp_path / "away")
        shutil.copytree(tmp_path / "away", store.path)
        with pytest.raises(StoreError):
            store.discard(store.states(), held)
    assert len(store.states()) == CELLS


@pytest.mark.usefixtures("well")
def test_progress_counts_up_to_the_plan(store: Store) -> None:
    seen: list[Summary] = []

    class Watching(Progress):
        def update(self, summary: Summary) -> None:
            seen.append(summary)

    dispatch(experiment(), store, jobs=0, progress=Watching())
    assert [summary.left for summary in seen] == list(range(CELLS - 1, -1, -1))


@contextlib.contextmanager
def driver(store: Store, pause: float | Path = 0.1) -> Iterator[subprocess.Popen[str]]:
    """A run in a process of its own, its trials `pause` seconds long or until a file is gone.

    It is gone when the block ends, however it ends.
    """
    with subprocess.Popen(
        [sys.executable, "-m", "tests.pretended", str(store.path), str(pause)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert line_of(process.stdout) == "ready\n"
            yield process
        finally:
            process.kill()


def wait_for_trials(store: Store, count: int) -> None:
    end = time.monotonic() + 30.0
    while len(list((store.path / "trials").glob("*/*.parquet"))) < count:
        assert time.monotonic() < end, "the run does not come on"
        time.sleep(0.01)


def test_the_first_signal_finishes_the_running_trials(store: Store, tmp_path: Path) -> None:
    """SIGTERM too, see `tests/reliability/test_signals.py`."""
    hold = tmp_path / "hold"
    hold.touch()
    with driver(store, hold) as process:
        heard(process, "started")
        heard(process, "started")
        process.send_signal(signal.SIGINT)
        heard(process, "stopping")
        hold.unlink()
        out, err = process.communicate(timeout=30.0)
    planned, done, left, interrupted = out.splitlines()[-1].split()
    assert (process.returncode, int(planned), interrupted) == (0, CELLS, "True"), err
    assert int(done) == len(store.states()) == 2, "what was running, and no more"
    assert int(left) == CELLS - int(done)


def heard(process: subprocess.Popen[str], word: str) -> None:
    """Wait until a driver says something."""
    assert process.stdout is not None
    assert any(line.startswith(word) for line in process.stdout), "the driver has ended"


def test_the_second_ctrl_c_kills(store: Store) -> None:
    with driver(store, pause=60.0) as process:
        heard(process, "started")
        heard(process, "started")
        process.send_signal(signal.SIGINT)
        heard(process, "stopping")
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30.0)
    assert process.returncode != 0
    assert "KeyboardInterrupt" in err
    assert store.states() == {}


class Impatient(Progress):
    """Presses Ctrl-C again as soon as the first one is answered."""

    def message(self, text: str) -> None:
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.usefixtures("well")
@pytest.mark.parametrize("call", ["start", "kill"])
def test_no_worker_outlives_two_ctrl_c_at_its_birth_or_death(
    store: Store, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    whole = getattr(SpawnProcess, call)

    def struck(process: SpawnProcess) -> None:
        monkeypatch.undo()  # once
        whole(process)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(SpawnProcess, call, struck)
    with contextlib.suppress(KeyboardInterrupt):
        dispatch(experiment(), store, jobs=2, progress=Impatient())
    gc.collect()
    assert active_children() == []


LEFT = """
import weakref
weakref.finalize(weakref, int)  # from here on it is sure to come after multiprocessing at the end
from gaitlab.running.processes import Child
from gaitlab.running.worker import simulated
left = Child(simulated)
"""


def test_a_worker_that_nobody_ends_does_not_keep_python_from_ending(tmp_path: Path) -> None:
    """As a traceback keeps one that was being started when Ctrl-C struck."""
    ended = subprocess.run([sys.executable, "-c", LEFT], cwd=ROOT, timeout=60.0, check=False)
    assert ended.returncode == 0


BLOCKED = """
from multiprocessing import active_children
from pathlib import Path
from gaitlab.running.processes import Child
from gaitlab.running.worker import simulated
workers = [Child(simulated), Child(simulated)]
for process in active_children():
    status = Path(f"/proc/{process.pid}/status").read_text()
    print(status.split("SigBlk:")[1].split()[0])
"""


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="no /proc here")
def test_the_first_worker_is_as_deaf_as_all_others() -> None:
    """The process that multiprocessing starts before it makes the driver hear again."""
    command = [sys.executable, "-c", BLOCKED]
    told = subprocess.run(command, cwd=ROOT, timeout=60.0, check=True, capture_output=True)
    masks = [int(line, 16) for line in told.stdout.split()]
    assert len(masks) == 2
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        assert all(mask >> (number - 1) & 1 for mask in masks)


@pytest.mark.long
@pytest.mark.usefixtures("well")
def test_a_run_killed_again_and_again_ends_in_the_same_store(store: Store, tmp_path: Path) -> None:
    undisturbed = Store(tmp_path / "undisturbed")
    dispatch(experiment(), undisturbed, jobs=0)
    for committed in (1, 6, 13):
        with driver(store) as process:
            wait_for_trials(store, committed)
            process.kill()
    kept = store.states()
    summary = dispatch(experiment(), store, jobs=2)
    assert summary.cached == len(kept) >= 13
    assert summary.cached + summary.done == CELLS
    assert contents(store) == contents(undisturbed)
    assert list(store.path.rglob("*.tmp")) == []
