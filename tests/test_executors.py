"""Executors against real processes that exit, crash, hang and are killed."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.errors import StoreError
from gaitlab.running.executor import TIMED_OUT, Executor, Job, Outcome, Serial
from gaitlab.running.processes import Processes
from gaitlab.store import TrialRecord
from tests import limited, recorded


def behave(trial_id: str, trial: Mapping[str, Any], folder: Path | None = None) -> TrialRecord:
    """A trial that does what it says, noting each attempt in a folder."""
    if folder is not None:
        with (folder / trial_id).open("a") as attempts:
            attempts.write(f"{os.getpid()}\n")
    DEEDS[trial["do"]]()
    if trial["do"] == "die, then hang" and folder is not None and len(pids(folder, trial_id)) == 2:
        hang()
    if trial["do"].startswith("die") and folder is not None and len(pids(folder, trial_id)) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return recorded.record(trial["number"])


def pids(folder: Path, trial_id: str) -> list[str]:
    return (folder / trial_id).read_text().split()


def full_disk() -> None:
    raise StoreError("the disk is full")


def bug() -> None:
    raise ZeroDivisionError("of gaitlab itself")


def hang() -> None:
    while True:
        time.sleep(1.0)


def spin() -> None:
    while True:
        pass


def work_hard() -> None:
    """For half a second of a processor, however long that takes."""
    end = time.process_time() + 0.5
    while time.process_time() < end:
        pass


def eat() -> None:
    eaten = []
    while True:
        eaten.append(np.empty(64 << 20, dtype=np.uint8))


DEEDS = {
    "eat": eat,
    "work": lambda: None,
    "die once": lambda: None,
    "die, then hang": lambda: None,
    "leave": lambda: os._exit(0),
    "exit": lambda: sys.exit(3),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "segfault": lambda: ctypes.string_at(0),
    "hang": hang,
    "spin": spin,
    "stop": lambda: os.kill(os.getpid(), signal.SIGSTOP),
    "work hard": work_hard,
    "full disk": full_disk,
    "bug": bug,
    "chat": lambda: print("printed by the physics engine"),
}


def jobs(*deeds: str) -> list[Job]:
    return [
        Job(
            trial_id=recorded.trial_id(number),
            trial={"do": deed, "number": number},
            timeout=60.0,
        )
        for number, deed in enumerate(deeds)
    ]


def outcomes(executor: Executor, *deeds: str) -> dict[str, Outcome]:
    found = list(executor.run(jobs(*deeds)))
    assert len(found) == len(deeds)
    return {outcome.job.trial["do"]: outcome for outcome in found}


@pytest.mark.parametrize("executor", [Serial(behave), Processes(behave, 2)])
def test_every_job_has_its_own_outcome(executor: Executor) -> None:
    found = list(executor.run(jobs(*["work"] * 5)))
    assert sorted(outcome.job.trial["number"] for outcome in found) == list(range(5))
    assert all(o.record == recorded.record(o.job.trial["number"]) for o in found)


def test_dead_workers_cost_their_own_trials_and_say_how_they_died(tmp_path: Path) -> None:
    executor = Processes(partial(behave, folder=tmp_path), 2)
    found = outcomes(executor, "work", "leave", "exit", "kill", "segfault", "die once", "chat")
    lost = {deed: found[deed].reason for deed in ("leave", "exit", "kill", "segfault")}
    assert "exit code 0" in lost["leave"]
    assert "exit code 3" in lost["exit"]
    assert "SIGKILL" in lost["kill"]
    assert "SIGSEGV" in lost["segfault"]
    assert "string_at" in lost["segfault"], "the stack of the crash"
    for deed in lost:
        assert found[deed].record is None
        assert len(pids(tmp_path, found[deed].job.trial_id)) == 2, "retried once"
    for deed in ("work", "chat", "die once"):
        assert found[deed].record is not None
    assert executor.running == 0


@pytest.mark.parametrize("deed", ["hang", "spin", "stop"])
def test_a_trial_without_end_is_ended_and_the_next_one_runs(deed: str, tmp_path: Path) -> None:
    endless, working = jobs(deed, "work")
    task = partial(behave, folder=tmp_path)
    outcomes = list(Processes(task, 1).run([replace(endless, timeout=1.0), working]))
    reasons = {outcome.job.trial["do"]: outcome.reason for outcome in outcomes}
    assert reasons[deed].startswith(TIMED_OUT)
    assert reasons["work"] == ""
    assert len(pids(tmp_path, endless.trial_id)) == 2, "retried once"


def test_what_else_ended_a_trial_is_told_rather_than_its_time_out(tmp_path: Path) -> None:
    """Whoever timed out may have had bad luck with the machine; whoever crashed has not."""
    (job,) = jobs("die, then hang")
    task = partial(behave, folder=tmp_path)
    (outcome,) = Processes(task, 1).run([replace(job, timeout=1.0)])
    assert len(pids(tmp_path, job.trial_id)) == 2
    assert "SIGKILL" in outcome.reason
    assert not outcome.reason.startswith(TIMED_OUT)


def test_where_trials_take_long_they_may_take_longer() -> None:
    """The first takes most of its time, so the others are not held to theirs."""
    first, second = (replace(job, timeout=limit) for job, limit in zip(
        jobs("work hard", "work hard"), (0.7, 0.1), strict=True
    ))  # fmt: skip
    assert [bool(o.record) for o in Processes(behave, 1).run([first, second])] == [True, True]
    assert [bool(o.record) for o in Processes(behave, 1).run([second, first])] == [False, True]


STARVED = """
from dataclasses import replace
import gaitlab.running.processes as processes
from tests.test_executors import behave, jobs
processes.START_TIME = 5.0  # s of work; a start takes about one
if __name__ == "__main__":
    deeds = [replace(job, timeout=2.0) for job in jobs(*["work hard"] * 3)]
    lost = [o.reason for o in processes.Processes(behave, 3).run(deeds) if o.record is None]
    print(lost)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what others do")
def test_a_starved_machine_is_slow_and_never_wrong(tmp_path: Path) -> None:
    """Three workers on two fifths of a processor: starts and trials take longer than they may."""
    root, script = Path(__file__).parent.parent, tmp_path / "starved.py"
    script.write_text(STARVED)
    environment = {**os.environ, "PYTHONPATH": str(root)}
    with limited.group(0.4) as group:
        done = subprocess.run(
            [sys.executable, str(script)], env=environment, cwd=root, capture_output=True,
            text=True, check=True, timeout=300, preexec_fn=limited.entering(group),
        )  # fmt: skip
    assert done.stdout == "[]\n"


PAUSED = """
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from gaitlab.running import cpu, processes
from tests.test_executors import behave, jobs
cpu.LOOK = processes.LOOK = 0.1
if __name__ == "__main__":
    task = partial(behave, folder=Path(sys.argv[1]))
    deeds = [replace(job, timeout=2.0) for job in jobs("work hard", "work hard")]
    print([o.reason for o in processes.Processes(task, 2).run(deeds) if o.record is None])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what others do")
def test_a_run_that_is_stopped_for_a_while_loses_nothing(tmp_path: Path) -> None:
    """Ctrl-Z stops the driver and its workers, for longer than a trial may do nothing."""
    root, script, notes = Path(__file__).parent.parent, tmp_path / "paused.py", tmp_path / "notes"
    script.write_text(PAUSED)
    notes.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(root)}
    command = [sys.executable, str(script), str(notes)]
    with subprocess.Popen(
        command, env=environment, cwd=root, stdout=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as driver:  # fmt: skip
        try:
            assert until(lambda: len(list(notes.iterdir())) == 2, seconds=120.0)
            os.killpg(driver.pid, signal.SIGSTOP)
            time.sleep(3.0)
            os.killpg(driver.pid, signal.SIGCONT)
            out, _ = driver.communicate(timeout=120.0)
        finally:
            driver.kill()
    assert out == "[]\n"


def test_memory_that_a_trial_eats_costs_that_trial_alone(tmp_path: Path) -> None:
    executor = Processes(partial(behave, folder=tmp_path), 1, memory=2 << 30)
    found = outcomes(executor, "eat", "work")
    assert found["eat"].reason.startswith("out of memory\n")
    assert "in eat" in found["eat"].reason, "where it was eaten"
    assert len(pids(tmp_path, found["eat"].job.trial_id)) == 2, "retried once"
    assert found["work"].record is not None


def test_a_worker_that_does_not_start_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitlab.running.processes.START_TIME", 0.0)
    found = list(Processes(behave, 1).run(jobs("work")))
    assert found[0].reason.startswith(TIMED_OUT)


def test_an_idle_worker_that_is_killed_costs_nothing(tmp_path: Path) -> None:
    executor = Processes(partial(behave, folder=tmp_path), 1)

    def killing() -> Iterator[Job]:
        first, second = jobs("work", "work")
        yield first
        os.kill(int(pids(tmp_path, first.trial_id)[0]), signal.SIGKILL)
        yield second

    assert [outcome.reason for outcome in executor.run(killing())] == ["", ""]


def test_workers_are_replaced_after_their_share(tmp_path: Path) -> None:
    executor = Processes(partial(behave, folder=tmp_path), 1, max_trials=2)
    list(executor.run(jobs(*["work"] * 3)))
    assert len({pids(tmp_path, recorded.trial_id(n))[0] for n in range(3)}) == 2


def test_a_store_that_cannot_be_written_stops_the_run_as_itself() -> None:
    with pytest.raises(StoreError, match="the disk is full"):
        list(Processes(behave, 1).run(jobs("full disk", "work")))


def test_a_bug_in_a_worker_comes_with_its_traceback() -> None:
    with pytest.raises(RuntimeError, match="ZeroDivisionError: of gaitlab itself"):
        list(Processes(behave, 1).run(jobs("bug")))


@pytest.mark.parametrize("executor", [Serial(behave), Processes(behave, 1)])
def test_draining_finishes_what_runs_and_takes_no_more(executor: Executor) -> None:
    taken: list[Job] = []

    def many() -> Iterator[Job]:
        for job in jobs(*["work"] * 50):
            taken.append(job)
            yield job

    found = []
    for outcome in executor.run(many()):
        found.append(outcome)
        executor.drain()
    assert 1 <= len(found) == len(taken) <= 2


def test_jobs_are_taken_only_when_a_worker_is_free() -> None:
    taken = 0

    def endless() -> Iterator[Job]:
        nonlocal taken
        while True:
            taken += 1
            yield jobs("work")[0]

    running = Processes(behave, 1).run(endless())
    next(running)
    running.close()
    assert taken <= 2


DRIVER = """
import sys
from functools import partial
from pathlib import Path
from gaitlab.running.processes import Processes
from tests.test_executors import behave, jobs
sys.platform = "PLATFORM"  # in the workers too, which import this file
if __name__ == "__main__":
    executor = Processes(partial(behave, folder=Path(sys.argv[1])), 2)
    list(executor.run(jobs("hang", "hang")))
"""


def is_running(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("platform", ["linux", "darwin"])  # the kernel tells, or a thread looks
def test_no_worker_outlives_a_killed_driver(tmp_path: Path, platform: str) -> None:
    script = tmp_path / "driver.py"
    script.write_text(DRIVER.replace("PLATFORM", platform))
    root = Path(__file__).parent.parent
    notes = tmp_path / "notes"
    notes.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(root)}
    driver = subprocess.Popen([sys.executable, str(script), str(notes)], env=environment, cwd=root)
    try:
        assert until(lambda: len(list(notes.iterdir())) == 2, seconds=120.0)
    finally:
        driver.kill()
        driver.wait(30.0)
    workers = [int(pid) for note in notes.iterdir() for pid in note.read_text().split()]
    assert until(lambda: not any(is_running(pid) for pid in workers), seconds=5.0)


def until(condition: Any, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return bool(condition())
