"""A walk that a program writes: when it runs, what its walks are called, and how it fails."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, GaitlabError, WrongValue
from gaitlab.experiment import candidate, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.trajectory import Gait as Trajectory
from gaitlab.model.commands import feet_of
from gaitlab.plugins import label
from gaitlab.robots.eros import Robot
from gaitlab.search.batch import candidate_trials
from gaitlab.simulation.trial import Trial
from tests.forked import gaitlab

PROGRAM = """\
import math, os, sys
step, out = float(sys.argv[1]), sys.argv[2]
{extra}
with open(os.environ["RUNS"], "a") as runs:
    runs.write(f"{{step}}\\n")
joints = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
with open(out, "w") as file:
    print("time", *(f"{{s}}_{{j}}" for s in ("left", "right") for j in joints), sep=",", file=file)
    for k in range(60):
        row = []
        for shift in (0.0, 0.5):
            turn = 2.0 * math.pi * (k / 60.0 + shift)
            lift = 0.02 * max(0.0, math.sin(turn)) ** 2
            bend = math.acos((0.19 - lift) / 0.21)
            lean = 0.5 * step / 0.19 * math.cos(turn)
            row += [0.0, 0.0, lean - bend, 2.0 * bend, -bend - lean, 0.0]
        print(0.01 * k, *row, sep=",", file=file)
"""
EXPERIMENT = """\
name: ours
robot: eros
gait:
  type: program
  command: [{python}, ./my_walk.py, "{{step_length}}", "{{file}}"]
  period: 0.6
  timeout: 20
  parameters:
    step_length: {{low: -0.1, high: 0.1, unit: m, default: 0.01}}
surfaces: [hard_floor]
seeds: 2
horizon: {{cycles: 0.5}}
"""
GRID = "grid: {gait.step_length: [0.0, 0.01, 0.02]}\n"


@pytest.fixture
def runs(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the program notes each of its runs."""
    file = tmp_path_factory.mktemp("runs") / "runs"
    file.write_text("")
    monkeypatch.setenv("RUNS", str(file))
    return file


def written(folder: Path, more: str = "", extra: str = "") -> Path:
    (folder / "my_walk.py").write_text(PROGRAM.format(extra=extra))
    (folder / "ours.yaml").write_text(EXPERIMENT.format(python=sys.executable) + more)
    return folder / "ours.yaml"


def trials(file: Path, *settings: str) -> list[Trial]:
    return [item.trial for item in plan(load_experiment(file, settings)).trials()]


def count(runs: Path) -> int:
    return len(runs.read_text().splitlines())


def test_it_runs_once_for_each_combination_and_what_is_walked_is_what_it_wrote(
    tmp_path: Path, runs: Path
) -> None:
    file = written(tmp_path, GRID)
    assert plan(load_experiment(file), programs=False).size == 6
    assert count(runs) == 0, "reading and counting run nothing"
    walks = trials(file)
    assert runs.read_text().split() == ["0.0", "0.01", "0.02"]
    assert len({walk.id for walk in walks}) == 6
    assert {walk.gait.step_length for walk in walks} == {0.0, 0.01, 0.02}
    for walk in walks:
        assert isinstance(walk.gait, Trajectory)
        assert label(walk.gait_code.name) == "trajectory"
        assert Trial.from_dict(walk.to_dict()).id == walk.id
    assert trials(file, "surfaces=[carpet_4mm]")[0].gait == walks[0].gait
    assert count(runs) == 3, "what it wrote is kept"


def test_walks_are_told_apart_by_the_programs_files_and_not_by_their_place(
    tmp_path: Path, runs: Path
) -> None:
    (tmp_path / "a").mkdir()
    file = written(tmp_path / "a")
    ids = [walk.id for walk in trials(file)]
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    assert [walk.id for walk in trials(tmp_path / "b" / "ours.yaml")] == ids
    assert count(runs) == 1, "what it wrote goes with the folder"
    (tmp_path / "a" / "my_walk.py").write_text(PROGRAM.format(extra="# the same"))
    assert [walk.id for walk in trials(file)] == ids
    assert count(runs) == 2, "another text is asked again"
    (tmp_path / "a" / "my_walk.py").write_text(PROGRAM.format(extra="step += 0.001"))
    assert not {walk.id for walk in trials(file)} & set(ids)
    more = file.read_text().replace("  period", "  depends: [./walk.ini]\n  period")
    file.write_text(more)
    for number, text in enumerate(["a", "b", "b"]):
        (tmp_path / "a" / "walk.ini").write_text(text)
        trials(file)
        assert count(runs) == 4 + min(number, 1)


def test_its_parameters_are_searched_like_any_other(tmp_path: Path, runs: Path) -> None:
    experiment = load_experiment(written(tmp_path))
    found = candidate_trials(experiment, {"gait.step_length": 0.03})
    assert {walk.trial.gait.step_length for walk in found.of([0])} == {0.03}
    with pytest.raises(WrongValue, match="step_length"):
        candidate(experiment, {"gait.step_length": 0.3})
    file = written(tmp_path, extra="if step > 0.02: sys.exit('too far')")
    found = candidate_trials(load_experiment(file), {"gait.step_length": 0.03})
    assert not found.trials
    assert "too far" in found.refusal


def test_balance_controllers_work_on_top_of_it(tmp_path: Path, runs: Path) -> None:
    file = written(tmp_path, "balance: ankle_hip\n")
    (first, *_) = trials(file)
    assert first.balance is not None
    feet = feet_of(first.gait, Robot(), [0.0, 1.2])
    assert feet.swing.any()


FAILURES = {
    "an exit status": ("sys.exit(7)", ("exit status 7", "said nothing")),
    "its last words": ("print('no such joint'); sys.exit(1)", ("exit status 1", "no such joint")),
    "an exception": ("raise ValueError('off')", ("exit status 1", "ValueError: off")),
    "a signal": ("os.kill(os.getpid(), 9)", ("signal 9",)),
    "a hang": ("import time; time.sleep(60)", ("had not ended after 1 s", "timeout:")),
    "nothing written": ("sys.exit(0)", ("wrote nothing",)),
    "an empty file": ("open(out, 'w').close(); sys.exit(0)", ("wrote nothing",)),
    "no trajectory": (
        "open(out, 'w').write('time\\n0'); sys.exit(0)",
        ("no trajectory", "no column of a joint"),
    ),
    "a file beside": ("open(os.environ['BESIDE'] + '/log', 'w')", ("outside its folder", "log")),
    "its own file": ("open(os.environ['BESIDE'] + '/my_walk.py', 'a').write('#')", ("own files",)),
}


@pytest.mark.parametrize("case", FAILURES)
def test_a_program_that_fails_is_said_before_anything_runs(
    case: str, tmp_path: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    extra, told = FAILURES[case]
    monkeypatch.setenv("BESIDE", str(tmp_path))
    file = written(tmp_path, GRID, extra)
    file.write_text(
        file.read_text().replace("timeout: 20", f"timeout: {1 if 'hang' in case else 20}")
    )
    with pytest.raises(WrongValue) as caught:
        trials(file)
    assert caught.value.exit_code == 3
    for part in (*told, "step_length = 0.0"):
        assert part in str(caught.value)
    assert not [*(tmp_path / ".gaitlab").rglob("*.csv")], "nothing of it is kept"
    assert not [*(tmp_path / ".gaitlab").rglob(".run-*")]


def test_what_it_wrote_and_the_robot_cannot_do_is_said_before_anything_runs(
    tmp_path: Path, runs: Path
) -> None:
    file = written(tmp_path, extra="step = 0.9")
    with pytest.raises(WrongValue, match=r"hip_pitch.* limits") as caught:
        trials(file)
    assert "step_length = 0.01" in str(caught.value)


WRONG = {
    "no such name": ('"{step_length}"', '"{step_lenght}"', "did you mean 'step_length'"),
    "no file to write": (', "{file}"', "", "{file} is missing"),
    "a name of its own": ("    step_length:", "    timeout:", "no name for one"),
    "unused": (
        "    step_length:",
        "    lift: {low: 0, high: 1, default: 0}\n    step_length:",
        "lift",
    ),
    "a default outside": ("default: 0.01", "default: 0.2", "from low to high"),
    "low above high": ("low: -0.1", "low: 0.5", "low has to be below high"),
    "no mapping": ("{low: -0.1, high: 0.1, unit: m, default: 0.01}", "0.1", "expected {low"),
    "an unknown key": ("low: -0.1", "lowest: -0.1", "lowest"),
    "no file": ("  period", "  depends: [./walk.ini]\n  period", "walk.ini"),
    "not to be run": ("{python}", "./my_walk.py", "can be run"),
    "not installed": ("{python}", "no_such_program_here", "no_such_program_here"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_section_is_refused_at_its_place(case: str, tmp_path: Path, runs: Path) -> None:
    old, new, told = WRONG[case]
    file = written(tmp_path)
    old = old.replace("{python}", sys.executable)
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))
    with pytest.raises(FileError) as caught:
        load_experiment(file)
    assert told in str(caught.value)
    assert f"{file}:" in str(caught.value)
    assert count(runs) == 0


def test_a_dry_run_says_that_it_runs_code_and_runs_none(
    tmp_path: Path, runs: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = written(tmp_path, GRID)
    assert run_command_line(["run", str(file), "--dry-run"]) == 0
    said = capfd.readouterr().out
    assert "code of your own" in said
    assert "./my_walk.py" in said
    assert run_command_line(["show", str(file)]) == 0
    assert count(runs) == 0
    assert not (tmp_path / ".gaitlab").exists()


def test_killed_and_run_again_it_runs_no_program_twice_for_what_is_kept(
    tmp_path: Path, runs: Path
) -> None:
    slow = "import time\nend = time.monotonic() + 30.0\n"  # an orphan does not stay for ever
    slow += "while step > 0.01:\n    time.sleep(0.05)\n"
    slow += "    if os.getppid() == 1 or time.monotonic() > end: sys.exit(1)"
    file = written(tmp_path, GRID, slow)
    words = [sys.executable, "-m", "gaitlab", "run", str(file), "-j", "0", "--quiet"]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    started = subprocess.Popen(words, cwd=tmp_path, env=env, start_new_session=True)
    until = time.monotonic() + 120.0
    while len([*tmp_path.glob(".gaitlab/programs/*.csv")]) < 2 and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(started.pid, signal.SIGKILL)
    started.wait(30.0)
    assert count(runs) == 2
    assert not (tmp_path / "data" / "trials").exists()
    (tmp_path / "ours.yaml").write_text(file.read_text().replace(", 0.02]", "]"))
    done = gaitlab("run", "ours.yaml", "-j", "0", "--quiet", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert count(runs) == 2, "the program was not run again"
    shutil.rmtree(tmp_path / ".gaitlab")
    again = gaitlab("run", "ours.yaml", "-j", "0", "--quiet", folder=tmp_path)
    assert "4 cached" in again.stdout, "the same numbers are the same trials"
    assert count(runs) == 4


def test_a_choice_is_a_parameter_too(tmp_path: Path, runs: Path) -> None:
    file = written(tmp_path, "grid: {gait.style: [fast, slow]}\n")
    text = file.read_text().replace(', "{file}"]', ', "{file}", "{style}"]')
    file.write_text(
        text.replace("  parameters:", "  parameters:\n    style: {options: [fast, slow]}")
    )
    assert len(trials(file)) == 4
    assert count(runs) == 2
    file.write_text(file.read_text().replace("style: [fast, slow]", "style: [fast, sloww]"))
    with pytest.raises(GaitlabError):
        trials(file)
