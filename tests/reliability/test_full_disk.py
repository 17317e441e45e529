"""Disks that fill up, become read-only or vanish; permissions that are not there.

Trials are pretended, with logs of about a megabyte. The file systems are real where mounting is
permitted (an ext4 of 30 MB in a file, a tmpfs of 30 MB), else those tests are skipped; the longest
length of a file, which every system has, is tried everywhere.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.store import Store
from tests.reliability import sweeps
from tests.reliability.drivers import ROOT, Drivers, drivers, until

pytestmark = pytest.mark.long

ROOM = 30  # MB of the small file systems
BALLAST = 14  # MB of them in use by something else


def mounted(*words: str) -> bool:
    """Whether mounting as told has worked."""
    sudo = [] if os.geteuid() == 0 else ["sudo", "-n"]
    try:
        return (
            subprocess.run(
                [*sudo, *words], capture_output=True, check=False, timeout=300
            ).returncode
            == 0
        )
    except OSError:
        return False


def tmpfs(place: Path, folder: Path) -> bool:
    return mounted("mount", "-t", "tmpfs", "-o", f"size={ROOM}m,mode=777", "tmpfs", str(place))


def loop(place: Path, folder: Path) -> bool:
    image = folder / "disk"
    image.write_bytes(b"")
    os.truncate(image, ROOM << 20)
    made = mounted("mkfs.ext4", "-q", "-m", "0", str(image))
    if not (made and mounted("mount", "-o", "loop", str(image), str(place))):
        return False
    return mounted("chmod", "777", str(place))


@pytest.fixture(params=[tmpfs, loop])
def disk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Path]:
    """A file system of 30 MB."""
    place = tmp_path / "disk-here"
    place.mkdir()
    if not request.param(place, tmp_path):
        pytest.skip("mounting is not permitted here")
    try:
        yield place
    finally:
        mounted("umount", str(place))


@pytest.fixture
def long_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.long)


@pytest.fixture(scope="module")
def gaitlab() -> Iterator[Drivers]:
    with drivers() as started:
        yield started


def command(store: Path, jobs: int = 2) -> tuple[str, ...]:
    return ("run", str(sweeps.FILE), "--store", str(store), "-j", str(jobs))


@pytest.mark.usefixtures("long_logs")
def test_a_disk_that_fills_up_costs_nothing_committed_and_the_same_command_completes(
    disk: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    ballast = disk / "ballast"
    ballast.write_bytes(b"\0" * (BALLAST << 20))
    store = Store(disk / "data")
    assert run_command_line(command(store.path)) == 7
    told = capfd.readouterr().err
    assert "the disk is full; free at least" in told
    assert "trials left need up to" in told
    assert "Traceback" not in told
    there = set(store.states())
    assert 0 < len(there) < 24
    assert all(store.log(trial_id) for trial_id in there), "what is committed is whole"
    ballast.unlink()
    assert run_command_line(command(store.path)) == 0
    assert there < set(store.states())
    assert len(store.states()) == 24
    assert sweeps.twice(store) == []
    assert list(store.path.rglob("*.tmp")) == []


def test_a_quota_on_the_length_of_files_is_a_full_disk_too(tmp_path: Path) -> None:
    """In a process of its own, which may not write files of more than 100 kB."""
    store = Store(tmp_path / "data")
    script = (
        "import sys, gaitlab.running.processes; from gaitlab.cli import run_command_line;"
        "from tests.reliability import sweeps;"
        "gaitlab.running.processes.simulated = sweeps.long;"
        "sys.exit(run_command_line(sys.argv[1:]))"
    )
    words = [sys.executable, "-c", script, *command(store.path, jobs=0)]
    done = subprocess.run(
        words,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)),
        timeout=300,
    )
    assert done.returncode == 7, done.stderr
    assert "`ulimit -f`" in done.stderr
    assert "24 trials left need up to" in done.stderr
    assert list(store.path.rglob("*.tmp")) == []
    assert sweeps.run(store).left == 0


def test_a_store_that_vanishes_ends_the_run_and_is_not_made_anew(
    gaitlab: Drivers, tmp_path: Path
) -> None:
    store, away = Store(tmp_path / "data"), tmp_path / "away"
    pid = gaitlab.start(*command(store.path), "--seeds", "4", errors=tmp_path / "errors")
    assert until(lambda: sweeps.committed(store) >= 3)
    store.path.rename(away)
    assert gaitlab.wait(pid) == 7
    told = (tmp_path / "errors").read_text()
    assert "vanished" in told
    assert "Traceback" not in told
    there = Store(away).states()
    assert len(there) >= 3
    assert all(Store(away).log(trial_id) for trial_id in there)
    shutil.rmtree(store.path, ignore_errors=True)
    away.rename(store.path)
    summary = sweeps.run(store, seeds=4)
    assert (summary.left, summary.cached >= 3) == (0, True)


def test_a_read_only_disk_can_be_read_and_refuses_runs(
    disk: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    store = Store(disk / "data")
    sweeps.run(store, *sweeps.SMALL)
    mine = sweeps.table(store)
    if not mounted("mount", "-o", "remount,ro", str(disk)):
        pytest.skip("remounting is not permitted here")
    assert sweeps.table(store) == mine
    for reading in (["status"], ["query", "SELECT count(*) FROM trials"]):
        assert run_command_line([*reading, "--store", str(store.path)]) == 0
    capfd.readouterr()
    assert run_command_line(command(store.path)) == 7
    assert "the file system is read-only; choose another folder" in capfd.readouterr().err


def without_privilege() -> list[str]:
    """Words before a command that take root's right to pass over permissions."""
    if os.geteuid() != 0:
        return []
    if not shutil.which("setpriv"):
        pytest.skip("root passes over all permissions")
    return ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]


def gaitlab_alone(*arguments: str) -> subprocess.CompletedProcess[str]:
    words = [*without_privilege(), sys.executable, "-m", "gaitlab", *arguments]
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)


def forbidden(path: Path, mode: int, check: Callable[[], None]) -> None:
    before = path.stat().st_mode
    path.chmod(mode)
    try:
        check()
    finally:
        path.chmod(before)


def test_a_store_without_permission_to_write_is_exit_7(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    sweeps.run(store, *sweeps.SMALL)
    (store.path / "lock").unlink()

    def check() -> None:
        done = gaitlab_alone(*command(store.path))
        assert (done.returncode, "Traceback" in done.stderr) == (7, False), done.stderr
        assert "Permission denied" in done.stderr
        assert "make it writable or choose another folder" in done.stderr

    forbidden(store.path, 0o555, check)
    assert sweeps.run(store, *sweeps.SMALL).cached == 8


def test_a_trial_without_permission_to_read_is_named_and_never_replaced(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    sweeps.run(store, *sweeps.SMALL)
    path = store.file(next(iter(store.states())))
    (store.path / "index.jsonl").unlink()
    before = path.read_bytes()
    words = [word for setting in sweeps.SMALL for word in ("--set", setting)]

    def check() -> None:
        done = gaitlab_alone("status", "--store", str(store.path))
        assert f"not counted: {path}: unreachable" in done.stderr
        done = gaitlab_alone(*command(store.path), *words)
        assert (done.returncode, "Traceback" in done.stderr) == (7, False), done.stderr

    forbidden(path, 0o000, check)
    assert path.read_bytes() == before
    assert sweeps.run(store, *sweeps.SMALL).cached == 8


def test_folders_without_permission_to_read_are_exit_7(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    sweeps.run(store, *sweeps.SMALL)

    def check() -> None:
        done = gaitlab_alone("status", "--store", str(store.path))
        assert (done.returncode, "Traceback" in done.stderr) == (7, False), done.stderr
        assert "cannot be read" in done.stderr

    forbidden(store.path / "trials", 0o000, check)
