"""Compiled functions are kept, and thrown away with the text that they were made of."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

MADE = """
from gaitlab.kinematics import compiled

@compiled.njit
def twice(x):
    return 2.0 * x

print(compiled.is_kept("made.twice"), twice(1.0), compiled.is_kept("made.twice"))
print(compiled.config.CACHE_DIR)
"""


def run(folder: Path, before: str = "", **environment: str) -> list[str]:
    """What a process prints that compiles a function, or finds it compiled."""
    (folder / "made.py").write_text(before + MADE)
    env = {**os.environ, "XDG_CACHE_HOME": str(folder / "caches"), **environment}
    env["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    if "NUMBA_CACHE_DIR" not in environment:
        env.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, str(folder / "made.py")], env=env, capture_output=True, text=True,
        check=True, timeout=120,
    )  # fmt: skip
    assert done.stderr == ""
    return done.stdout.split()


def test_what_is_compiled_once_is_kept_for_the_next_process(tmp_path: Path) -> None:
    first, second = run(tmp_path), run(tmp_path)
    assert first[:3] == ["False", "2.0", "True"]
    assert second[:3] == ["True", "2.0", "True"]
    assert first[3] == second[3]
    assert Path(first[3]).parent == tmp_path / "caches" / "gaitlab"


def test_a_folder_that_is_named_is_used_and_keeps_what_was_made_of_other_text_apart(
    tmp_path: Path,
) -> None:
    named = tmp_path / "named"
    first, second = (run(tmp_path, NUMBA_CACHE_DIR=str(named)) for _ in range(2))
    assert (first[2], second[0]) == ("True", "True")
    assert Path(first[3]).parent == named
    assert not (tmp_path / "caches").exists()


NOWHERE = "from gaitlab.kinematics import caches\ncaches.TEMPORARY = ()\n"
FULL = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"


def test_where_nothing_can_be_kept_it_is_compiled_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "caches").write_text("a file where the folder should be")
    nowhere = {"TMPDIR": str(tmp_path / "caches"), "NUMBA_CACHE_DIR": str(tmp_path / "caches")}
    for _ in range(2):
        assert run(tmp_path, NOWHERE, **nowhere)[:3] == ["False", "2.0", "False"]


def test_a_disk_that_is_full_costs_another_compiling(tmp_path: Path) -> None:
    """As the longest length of a file, which every system has, makes one."""
    for _ in range(2):
        assert run(tmp_path, FULL)[:3] == ["False", "2.0", "False"]
    assert run(tmp_path)[:3] == ["False", "2.0", "True"]
    assert run(tmp_path)[0] == "True"


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 100])
def test_what_is_torn_is_compiled_again_and_kept(tmp_path: Path, suffix: str, left: int) -> None:
    run(tmp_path)
    (file,) = (tmp_path / "caches").rglob(f"made.*.{suffix}")
    whole = file.stat().st_size
    os.truncate(file, left)
    assert run(tmp_path)[1] == "2.0"
    assert file.stat().st_size == whole
    assert run(tmp_path)[1] == "2.0"
