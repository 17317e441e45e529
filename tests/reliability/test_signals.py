"""Signals to a real driver: it drains, it survives a hang-up, it says how to go on.

Trials are pretended; drivers, workers and terminals are real.
"""

from __future__ import annotations

import os
import pty
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from gaitlab.store import Store
from tests.reliability import sweeps
from tests.reliability.drivers import ROOT, Drivers, drivers, runs, until

TRIALS = 24
JOBS = 2


@pytest.fixture(scope="module")
def gaitlab() -> Iterator[Drivers]:
    with drivers() as started:
        yield started


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def command(store: Store, jobs: int = JOBS) -> tuple[str, ...]:
    return ("run", str(sweeps.FILE), "--store", str(store.path), "-j", str(jobs))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_run_drains_and_goes_on_where_it_was(
    gaitlab: Drivers, store: Store, tmp_path: Path, number: signal.Signals
) -> None:
    pid = gaitlab.start(*command(store), task="held", errors=tmp_path / "errors")
    assert until(lambda: sweeps.committed(store) >= 2)
    os.kill(pid, number)
    assert until(lambda: "finished first" in (tmp_path / "errors").read_text())
    (tmp_path / "go").touch()
    assert gaitlab.wait(pid) == 130
    done = sweeps.committed(store)
    assert 2 <= done <= 2 + 2 * JOBS < TRIALS, "what ran, and what it had been given"
    told = (tmp_path / "errors").read_text()
    assert "Traceback" not in told
    assert list(store.path.rglob("*.tmp")) == []
    assert sweeps.run(store).cached == done


def test_the_second_ctrl_c_ends_the_run_at_once_and_loses_nothing(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    pid = gaitlab.start(*command(store), errors=tmp_path / "errors")
    assert until(lambda: sweeps.committed(store) >= 2)
    while runs(pid):
        os.kill(pid, signal.SIGINT)
        until(lambda: not runs(pid), seconds=0.02)
    assert gaitlab.wait(pid) == 130
    sweeps.run(store)
    assert sweeps.table(store) == sweeps.table(undisturbed(tmp_path))


def test_the_first_ctrl_c_waits_for_a_trial_that_never_ends_and_the_second_does_not(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    pid = gaitlab.start(*command(store), task="stuck", errors=tmp_path / "errors")
    assert until(lambda: len(stuck(store)) == 2)
    os.kill(pid, signal.SIGINT)
    assert until(lambda: "finished first" in (tmp_path / "errors").read_text())
    assert not until(lambda: not runs(pid), seconds=0.5), "it waits for what runs"
    os.kill(pid, signal.SIGINT)
    assert until(lambda: not runs(pid))
    assert gaitlab.wait(pid) == 130
    assert until(lambda: not any(map(runs, stuck(store)))), "no worker is left behind"
    assert sweeps.run(store).done == TRIALS


def stuck(store: Store) -> list[int]:
    """Processes in which a trial of the task `stuck` has begun."""
    return [int(note.name.removeprefix("stuck-")) for note in store.path.glob("stuck-*")]


def undisturbed(folder: Path) -> Store:
    whole = Store(folder / "whole")
    sweeps.run(whole)
    return whole


def test_a_run_whose_terminal_goes_away_ends_as_if_it_had_not(store: Store, tmp_path: Path) -> None:
    """In a terminal of its own, whose closing sends SIGHUP to the driver and to its workers."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(ROOT)
        os.execv(sys.executable, [sys.executable, "-m", "tests.reliability.alone", *command(store)])
    reading = threading.Thread(target=_drain, args=(terminal,), daemon=True)
    reading.start()
    assert until(lambda: sweeps.committed(store) >= 2, seconds=60.0)
    there = sweeps.committed(store)
    hang_up(terminal)
    reading.join(60.0)
    assert there < TRIALS
    assert until(lambda: not runs(pid), seconds=60.0)
    _, status = os.waitpid(pid, 0)
    assert not os.WIFSIGNALED(status), "SIGHUP did not kill it"
    assert sweeps.content(store) == sweeps.content(undisturbed(tmp_path))
    assert sweeps.twice(store) == []


_stop = threading.Event()


def _drain(terminal: int) -> None:
    with suppress(OSError):
        while not _stop.is_set() and os.read(terminal, 1 << 12):
            continue
    os.close(terminal)


def hang_up(terminal: int) -> None:
    """Close the terminal; its reader does, at the next thing that is written to it."""
    _stop.set()
    del terminal


def test_a_reader_that_goes_away_stops_no_run(store: Store) -> None:
    """`gaitlab run ... 2>&1 | head -1`: every line after the first finds a broken pipe."""
    import subprocess

    words = [sys.executable, "-m", "tests.reliability.alone", *command(store, jobs=1)]
    with subprocess.Popen(words, cwd=ROOT, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        process.stderr.close()
        try:
            process.wait(120.0)
        finally:
            process.kill()
    assert sweeps.committed(store) == TRIALS
