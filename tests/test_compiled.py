"""Compiled functions are kept, and thrown away with the text that they were made of."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

MADE = """
from gaitlab.kinematics import compiled

@compiled.njit
def twice(x):
    return 2.0 * x

print(compiled.is_kept("made.twice"), twice(1.0), compiled.is_kept("made.twice"))
print(compiled.config.CACHE_DIR)
"""


def run(folder: Path) -> list[str]:
    """What a process prints that compiles a function, or finds it compiled."""
    (folder / "made.py").write_text(MADE)
    env = {**os.environ, "XDG_CACHE_HOME": str(folder / "caches")}
    env["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    env.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, str(folder / "made.py")], env=env, capture_output=True, text=True,
        check=True, timeout=120,
    )  # fmt: skip
    return done.stdout.split()


def test_what_is_compiled_once_is_kept_for_the_next_process(tmp_path: Path) -> None:
    first, second = run(tmp_path), run(tmp_path)
    assert first[:3] == ["False", "2.0", "True"]
    assert second[:3] == ["True", "2.0", "True"]
    assert first[3] == second[3]
    assert Path(first[3]).parent == tmp_path / "caches" / "gaitlab"


def test_where_nothing_can_be_kept_it_is_compiled_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "caches").write_text("a file where the folder should be")
    assert run(tmp_path)[1] == "2.0"
