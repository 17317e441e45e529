"""What the shell completes: names and trials that go on from what is typed, and nothing else."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.plugins import names
from gaitlab.store import Store

ROOT = Path(__file__).parent.parent


def completed(line: str, folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """What bash is told when Tab is pressed at the end of a line."""
    words = line.split(" ")
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "_GAITLAB_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    command = [sys.executable, *options, "-m", "gaitlab"]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("gaitlab run eros_table", {"eros_table7", "eros_table8"}),
        ("gaitlab optimize eros_sm", {"eros_small"}),
        ("gaitlab report eros_quick eros_sm", {"eros_small"}),
        ("gaitlab show grass_3", {"grass_30mm"}),
        ("gaitlab show ankle", {"ankle_hip"}),
        ("gaitlab ik e", {"eros"}),
        ("gaitlab list sur", {"surfaces"}),
        ("gaitlab new s", {"study", "surface", "servo"}),
        ("gaitlab run no_such", set()),
        ("gaitlab replay no_such/", set()),
    ],
)
def test_names_go_on_from_what_is_typed(line: str, expected: set[str], tmp_path: Path) -> None:
    done = completed(line, tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert set(done.stdout.split()) == expected


def test_trials_are_completed_by_id_and_by_place(swept_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(swept_folder / "data", tmp_path / "data")
    store = Store(tmp_path / "data")
    ids = sorted(store.states())
    line, answers = "", {"pretended/"}
    for word in ("pret", "pretended/", "pretended/carpet_4mm/", "pretended/carpet_4mm/0.04/"):
        found = completed(f"gaitlab replay {word}", tmp_path)
        assert (found.returncode, found.stderr) == (0, "")
        answers, line = set(found.stdout.split()), word
        assert all(answer.startswith(word) for answer in answers), answers
        assert answers, word
    assert {f"{line}{end}" for end in ("worst", "best", "0.01")} <= answers
    begun = completed(f"gaitlab export {ids[0][:4]}", tmp_path)
    assert set(begun.stdout.split()) == {name for name in ids if name.startswith(ids[0][:4])}


def test_whatever_lies_around_makes_no_noise(swept_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(swept_folder / "data", tmp_path / "data")
    (tmp_path / "data" / "index.jsonl").write_bytes(b"\xff not an index\n")
    for name in ("experiments", "surfaces"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "broken.yaml").write_bytes(b"\xff: [\n")
    (tmp_path / "data" / "experiments" / "pretended" / "trials.jsonl").write_text("no list\n")
    for line in ("gaitlab replay pret", "gaitlab show bro", "gaitlab run bro", "gaitlab replay x/"):
        done = completed(line, tmp_path)
        assert (done.returncode, done.stderr) == (0, ""), line
        assert set(done.stdout.split()) <= {"broken"}


def test_a_name_is_completed_without_the_libraries_that_simulate(tmp_path: Path) -> None:
    done = completed("gaitlab run eros_q", tmp_path, "-X", "importtime")
    assert done.stdout.split() == ["eros_quick"]
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert not loaded & {"numpy", "pandas", "pyarrow", "numba", "optuna", "matplotlib", "mujoco"}
    assert "eros_quick" in names("experiment")
