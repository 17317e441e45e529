"""The driver dies by SIGKILL at any instant, and the store ends as if it never had.

Trials are pretended (see `sweeps`): what is proven is the bookkeeping. One test at the end does the
same with real, short simulations.
"""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gaitlab.experiment import load_experiment
from gaitlab.store import Store
from tests.reliability import sweeps
from tests.reliability.drivers import Drivers, children, drivers, runs, until

KILLS = 50
FORM = "pretended+seeds-6"  # what the store calls the experiment with so many seeds
SEEDS = 6  # 144 trials: no killed driver gets to the end before most of the kills are spent
TWO_TRIALS = ("grid.gait.step_length=[0.0]", "grid.gait.lateral_sway=[0.01]")


@pytest.fixture(scope="module")
def gaitlab() -> Iterator[Drivers]:
    with drivers() as started:
        yield started


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def command(store: Store, *more: str, jobs: int = 2) -> tuple[str, ...]:
    return ("run", str(sweeps.FILE), "--store", str(store.path), "-j", str(jobs), *more)


def wait_for(store: Store, pid: int, trials: int) -> None:
    assert until(lambda: sweeps.committed(store) >= trials or not runs(pid))


@pytest.mark.long
def test_fifty_kills_at_random_instants_leave_no_trace(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    undisturbed = Store(tmp_path / "undisturbed" / "data")
    assert gaitlab.run(*command(undisturbed, "--seeds", str(SEEDS))) == 0
    wanted, chance, kills = sweeps.content(undisturbed, FORM), random.Random(4), 0
    assert f"experiments/{FORM}/trials.jsonl" in wanted
    while kills < KILLS:
        words = command(store, "--seeds", str(SEEDS), jobs=chance.choice((1, 1, 2)))
        pid = gaitlab.start(*words, errors=tmp_path / "errors")
        more = chance.choice((0, 0, 0, 0, 1, 3))
        time.sleep(0.0 if more else chance.uniform(0.0, 0.6))
        wait_for(store, pid, sweeps.committed(store) + more)
        time.sleep(chance.uniform(0.0, 0.05))
        os.kill(pid, signal.SIGKILL)
        if gaitlab.wait(pid) == -signal.SIGKILL:
            kills += 1
    assert gaitlab.run(*command(store, "--seeds", str(SEEDS))) == 0
    assert sweeps.content(store, FORM) == wanted
    assert sweeps.twice(store) == []
    assert list(store.path.rglob("*.tmp")) == []


@pytest.mark.long
def test_a_kill_before_every_single_file_system_step_leaves_no_trace(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    options = [word for setting in TWO_TRIALS for word in ("--set", setting)]
    form = load_experiment(sweeps.FILE, settings=TWO_TRIALS).listed_as

    def run(place: Store, kill_at: int = 0) -> int:
        words = command(place, *options, jobs=0)
        return gaitlab.run(*words, task="pretend", kill_at=kill_at)

    whole = Store(tmp_path / "whole" / "data")
    assert run(whole) == 0
    wanted, step = sweeps.content(whole, form), 0
    assert f"experiments/{form}/trials.jsonl" in wanted
    while True:
        step += 1
        place = Store(tmp_path / str(step) / "data")
        code = run(place, kill_at=step)
        assert run(place) == 0
        assert sweeps.content(place, form) == wanted, step
        assert sweeps.twice(place) == [], step
        assert list(place.path.rglob("*.tmp")) == [], step
        if code == 0:
            break
    assert step > 30, "there are that many steps in a run"


def test_no_worker_outlives_a_killed_driver_by_five_seconds(gaitlab: Drivers, store: Store) -> None:
    """Not even in the middle of a trial that never ends."""
    pid = gaitlab.start(*command(store), task="stuck")
    assert until(lambda: len(list(store.path.glob("stuck-*"))) == 2)
    workers = children(pid)
    assert {f"stuck-{worker}" for worker in workers} >= {f.name for f in store.path.glob("stuck-*")}
    os.kill(pid, signal.SIGKILL)
    gaitlab.wait(pid)
    assert until(lambda: not any(runs(worker) for worker in workers), seconds=5.0)


@pytest.mark.long
def test_real_trials_of_a_killed_run_have_the_bits_of_an_undisturbed_one(
    gaitlab: Drivers, tmp_path: Path
) -> None:
    """Four real simulations of the shortest walk on the hard floor, killed after one and three."""
    short = ("horizon.cycles=0.5", "horizon.time=0.1", "gait.stand_time=0.1")
    settings = (*short, "surfaces=[hard_floor]", "grid.gait.lateral_sway=[0.01]")
    grid = ("grid.gait.step_length=[0.0, 0.02, 0.04, 0.06]",)
    options = [word for setting in (*settings, *grid) for word in ("--set", setting)]
    killed, whole = Store(tmp_path / "killed"), Store(tmp_path / "whole")
    for count in (1, 3):
        pid = gaitlab.start(*command(killed, *options, jobs=1), task="simulated")
        wait_for(killed, pid, count)
        os.kill(pid, signal.SIGKILL)
        gaitlab.wait(pid)
    for place in (killed, whole):
        assert gaitlab.run(*command(place, *options, jobs=1), task="simulated") == 0
    assert len(whole.states()) == 4
    assert sweeps.logs(killed) == sweeps.logs(whole)
    index = [(place.path / "index.jsonl").read_bytes() for place in (killed, whole)]
    assert index[0] == index[1]
