"""gaitlab where nothing but the results can be written: installed for all, no home, full disks."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.reliability.drivers import ROOT

FEW = (
    "--seeds", "1", "--set", "surfaces=[carpet_4mm]", "--set", "grid.gait.step_length=[0.02]",
    "--set", "horizon.cycles=1",
)  # fmt: skip
NAMES = ("matplotlib", "fontconfig", "cannot cache", "traceback")

pytestmark = pytest.mark.long


def lonely(commands: Sequence[str]) -> bool:
    """Whether commands could be given where mounts are this process' own."""
    script = "\n".join(["set -e", *commands])
    try:
        done = subprocess.run(
            ["unshare", "-m", "bash", "-c", script], capture_output=True, check=False, timeout=30
        )
    except OSError:
        return False
    return done.returncode == 0


class Machine:
    """A machine on which commands of gaitlab are given, itself and its Python read-only.

    Args:
        folder: Where its results go, the only place that can be written.
        full: Places for temporary files, with no room.
        environment: Variables besides those that everybody has.
    """

    def __init__(self, folder: Path, full: Sequence[str] = (), **environment: str) -> None:
        self.folder, tree = folder, folder / "installed"
        tree.mkdir()
        self.python = moved(Path(sys.executable), tree)
        read_only = [(ROOT, tree), *((Path(place),) * 2 for place in (sys.prefix, sys.base_prefix))]
        self.before = [
            line
            for source, target in read_only
            for line in (
                f"mount --bind {shlex.quote(str(source))} {shlex.quote(str(target))}",
                f"mount -o remount,ro,bind {shlex.quote(str(target))}",
            )
        ]
        for place in full:
            self.before += [
                f"mount -t tmpfs -o size=16k tmpfs {shlex.quote(place)}",
                f"cat /dev/zero > {shlex.quote(place)}/ballast 2>/dev/null || true",
            ]
        self.environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(tree), **environment}
        if not lonely([*self.before, f"{shlex.quote(str(self.python))} -c 'import numpy'"]):
            pytest.skip("mounting in a namespace of one's own is not permitted here")

    def gaitlab(self, *arguments: str) -> str:
        """What a command says on stderr."""
        command = shlex.join([str(self.python), "-m", "gaitlab", *arguments])
        script = "\n".join(["set -e", *self.before, f"exec {command}"])
        done = subprocess.run(
            ["unshare", "-m", "bash", "-c", script], env=self.environment, cwd=self.folder,
            capture_output=True, text=True, timeout=400, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert not [name for name in NAMES if name in done.stderr.lower()], done.stderr
        return done.stderr


def moved(path: Path, tree: Path) -> Path:
    """Where a file of the tree under test is once that is mounted elsewhere."""
    return tree / path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def test_every_command_works_where_only_temporary_files_can_be_written(tmp_path: Path) -> None:
    """A run in every engine; what was compiled for one is found by all that follow."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    temporary.chmod(0o1777)
    machine = Machine(tmp_path, HOME="/proc/nohome", TMPDIR=str(temporary))
    kept = str(temporary / f"gaitlab-{os.geteuid()}")
    engines = {"bullet": "pybullet", "mujoco": "mujoco"}
    there = [engine for engine, package in engines.items() if find_spec(package)]
    assert there
    for engine in there:
        chosen = ("eros_quick", "--set", f"engine.name={engine}", *FEW)
        said = machine.gaitlab("run", *chosen, "-j", "1")
        assert said.count(kept) == 1, "said once"
    machine.gaitlab("report", *chosen)
    trial = min(trials(tmp_path))
    machine.gaitlab("replay", trial, "--output", "walk.gif", "--to", "0.2", "-j", "2")
    said = machine.gaitlab(
        "optimize", "eros_carpet", "--set", f"engine.name={engine}", "--trials", "1", "-j", "1",
        "--no-validation", "--set", "seeds=1", "--set", "horizon.cycles=1",
    )  # fmt: skip
    assert said.count(kept) == 1
    assert {path.name for path in temporary.iterdir()} == {Path(kept).name}, "nothing else is left"


def trials(folder: Path) -> set[str]:
    return {file.stem for file in (folder / "data" / "trials").rglob("*.parquet")}


@pytest.mark.bullet
@pytest.mark.parametrize("home", [True, False])
def test_a_run_needs_no_temporary_file(tmp_path: Path, home: bool) -> None:
    """Where they would lie is full, and HOME unset; or it cannot be written either."""
    place = tmp_path / "temporary"
    place.mkdir()
    caches = {"XDG_CACHE_HOME": str(tmp_path / "caches")} if home else {"HOME": "/proc/nohome"}
    full = ("/tmp", "/var/tmp", str(place))
    machine = Machine(tmp_path, full, TMPDIR=str(place), **caches)
    for name in ("stand.yaml", "stand.py"):
        shutil.copy(ROOT / "tests" / "data" / name, tmp_path)
    said = machine.gaitlab("run", "stand.yaml", "--seeds", "1", "-j", "1")
    assert ("NUMBA_CACHE_DIR" in said) is not home
    assert (tmp_path / "caches").exists() is home
    if not home:
        machine.gaitlab("report", "stand.yaml", "--seeds", "1")
