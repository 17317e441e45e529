"""`gaitlab submit` without a cluster: what its script does, and what is refused."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.running.slurm import LONGEST, SHORTEST, ArrayJob, division, limit_seconds
from gaitlab.store import Store
from tests import pretended
from tests.reliability.drivers import until

FILE = str(pretended.FILE)
DATA = pretended.FILE.parent
NAMES = ("plain", "a blank", "it's", 'quo"te', "ha#sh", "100%A", "$HOME", "ümläut", "semi;co", "-x")
SAY = "import json, os, sys; print(json.dumps([os.getcwd(), sys.argv[1:]]))"


class Folder:
    """An empty folder in which commands are typed; trials are pretended."""

    def __init__(self, path: Path, capfd: pytest.CaptureFixture[str]) -> None:
        self.path, self._capfd = path, capfd

    def gaitlab(self, *arguments: str) -> tuple[int, str, str]:
        code = run_command_line(arguments)
        return code, *self._capfd.readouterr()

    def script(self, *arguments: str) -> str:
        code, out, err = self.gaitlab("submit", *arguments, "--dry-run")
        assert code == 0, err
        return out


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretended.pretend_well)
    return Folder(tmp_path, capfd)


def option(script: str, name: str) -> str:
    """What a script gives for an option of sbatch."""
    return re.findall(rf"^#SBATCH --{name}=(.*)$", script, re.MULTILINE)[0]


def job(folder: Path, *program: str, arguments: str = "walk.yaml") -> ArrayJob:
    return ArrayJob(
        name="walk", summary="walk", cwd=folder, program=program, arguments=arguments, shards=3,
        tasks=(1, 2, 3), folder=folder / "slurm", output="%A_%a.out", cpus=2, limit="10",
    )  # fmt: skip


def start(script: str, task: int) -> subprocess.Popen[str]:
    """A task of the script, as a node of a cluster starts it."""
    given = {"SLURM_ARRAY_TASK_ID": str(task), "SLURM_CPUS_PER_TASK": "1"}
    return subprocess.Popen(
        ["bash", "-c", script], env={**os.environ, **given}, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, cwd="/",
    )  # fmt: skip


def run(script: str, task: int) -> tuple[int, str]:
    with start(script, task) as process:
        try:
            out, err = process.communicate(timeout=300)
        finally:
            process.kill()
    return process.returncode, out + err


@pytest.mark.long
def test_the_tasks_in_any_order_and_then_task_0_are_the_whole_run(folder: Folder) -> None:
    for name in ("stand.yaml", "stand.py"):
        shutil.copy(DATA / name, folder.path / name)
    script = folder.script("stand.yaml", "--seeds", "4", "--shards", "2", "--store", "my data")
    assert option(script, "array") == "1-2"
    for task in (2, 0):  # the first has died, say
        code, told = run(script, task)
        assert code == 0, told
    assert len(Store(folder.path / "my data").states()) == 4
    assert (folder.path / "reports" / "stand+seeds-4" / "README.md").is_file()


@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_folder_is_called_the_command_is_the_one_that_was_typed(
    tmp_path: Path, name: str
) -> None:
    cwd = tmp_path / name
    cwd.mkdir()
    typed = ["walk.yaml", "--set", f"name={name}", "--store", name]
    script = job(cwd, sys.executable, "-c", SAY, arguments=shlex.join(typed)).script()
    done = subprocess.run(["bash", "-n"], input=script, text=True, check=False, timeout=300)
    assert done.returncode == 0
    for task in (0, 3):
        code, out = run(script, task)
        assert code == 0, out
        where, given = json.loads(out.splitlines()[1])
        assert Path(where) == cwd
        shard = ["--shard", "3/3"] if task else []
        assert given == ["run", *typed, "--yes", "-j", "1", *shard]
    report = json.loads(run(script, 0)[1].splitlines()[2])[1]
    assert report == ["report", *typed]


@pytest.mark.skipif(shutil.which("shellcheck") is None, reason="shellcheck is not installed")
def test_shellcheck_has_nothing_to_say_about_a_script(folder: Folder) -> None:
    script = folder.script(FILE, "--shards", "3", "--mem", "2G", "--sbatch=--exclusive")
    done = subprocess.run(
        ["shellcheck", "-"],
        input=script,
        text=True,
        capture_output=True,
        check=False,
        timeout=300,
    )
    assert done.stdout == ""


@pytest.mark.parametrize(("code", "task_code"), [(0, 0), (4, 0), (2, 2), (7, 7), (130, 130)])
def test_a_task_fails_when_something_is_wrong_and_not_when_a_trial_is(
    tmp_path: Path, code: int, task_code: int
) -> None:
    script = job(tmp_path, "bash", "-c", f"[[ $0 != run ]] || exit {code}").script()
    assert [run(script, task)[0] for task in (1, 0)] == [task_code, task_code]


def test_a_task_that_is_told_to_end_waits_for_the_trials_that_run(tmp_path: Path) -> None:
    program = (
        "trap 'sleep 0.3; touch drained; exit 130' TERM; touch begun; while :; do sleep 0.01; done"
    )
    with start(job(tmp_path, "bash", "-c", program).script(), 1) as shell:
        assert until((tmp_path / "begun").exists)
        children = Path(f"/proc/{shell.pid}/task/{shell.pid}/children").read_text().split()
        for pid in (*children, shell.pid):  # as SLURM does it: every process of the task
            os.kill(int(pid), signal.SIGTERM)
        assert shell.wait(30.0) == 130
    assert (tmp_path / "drained").exists()


@pytest.mark.parametrize("seeds", [1, 7, 40, 200])
@pytest.mark.parametrize("cpus", [1, 4])
def test_a_shard_takes_10_to_30_minutes_if_there_is_a_choice(
    tmp_path: Path, seeds: int, cpus: int
) -> None:
    trials = 24 * seeds
    store, experiment = Store(tmp_path / "data"), pretended.experiment(seeds)
    divided = division([experiment], store, wanted=None, cpus=cpus)
    assert divided.planned == divided.due == trials
    assert divided.tasks == tuple(range(1, divided.count + 1))
    assert divided.each.seconds <= LONGEST
    assert divided.count == 1 or divided.each.seconds >= SHORTEST
    assert not store.path.exists()


def test_there_are_never_more_shards_than_trials(folder: Folder) -> None:
    assert option(folder.script(FILE, "--shards", "25"), "array") == "1-24"
    assert option(folder.script(FILE, "--shards", "24"), "array") == "1-24"
    assert option(folder.script(FILE, "--shards", "1"), "array") == "1"


def test_given_again_it_submits_the_shards_with_something_left(folder: Folder) -> None:
    for shard in ("1/5", "3/5", "4/5"):
        assert folder.gaitlab("run", FILE, "-j", "0", "-q", "--shard", shard)[0] == 0
    assert option(folder.script(FILE), "array") == "2,5", "as it is shared out already"
    assert option(folder.script(FILE, "--shards", "5"), "array") == "2,5"
    assert option(folder.script(FILE, "--shards", "4"), "array") == "1-4"
    assert option(folder.script(FILE, "--seeds", "2"), "array") == "1", "another list of trials"
    assert folder.gaitlab("run", FILE, "-j", "0", "-q")[0] == 0
    code, out, err = folder.gaitlab("submit", FILE)
    assert (code, out) == (0, ""), "nothing is left"
    assert "gaitlab report" in err


def test_a_limit_of_time_is_three_times_what_is_expected_or_the_users(folder: Folder) -> None:
    limits = {
        shards: limit_seconds(option(folder.script(FILE, "--shards", shards), "time"))
        for shards in ("1", "24")
    }
    needed = {
        count: division(
            [pretended.experiment()], Store(folder.path), wanted=int(count), cpus=1
        ).each.seconds
        for count in limits
    }
    assert all(limits[count] >= 3 * needed[count] for count in limits)
    assert option(folder.script(FILE, "--time", "1-12"), "time") == "1-12"


def test_an_option_of_sbatch_comes_through(folder: Folder) -> None:
    given = ["--partition", "short", "--account", "a b", "--mem", "4G", "--cpus", "3"]
    script = folder.script(FILE, *given, "--sbatch=--exclusive", "--sbatch", '--comment="a b"')
    lines = set(script.splitlines())
    assert lines >= {
        *("#SBATCH --partition=short", '#SBATCH --account="a b"', "#SBATCH --mem=4G"),
        *("#SBATCH --cpus-per-task=3", "#SBATCH --exclusive", '#SBATCH --comment="a b"'),
    }
    assert {"#SBATCH --requeue", "#SBATCH --open-mode=append"} <= lines


def test_the_members_of_a_reproduction_share_an_array(folder: Folder) -> None:
    script = folder.script("eros_reproduction", "--quick", "--shards", "3")
    assert option(script, "array") == "1-3"
    assert "run eros_reproduction --quick --yes" in script


def test_a_dry_run_needs_no_slurm_and_writes_nothing(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    assert folder.script(FILE).startswith("#!/bin/bash\n")
    assert list(folder.path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "code", "named"),
    [
        (["--shards", "0"], 2, "--shards 0"),
        (["--shards", "-1"], 2, "--shards -1"),
        (["--shards", "100000"], 2, "--shards 100000"),
        (["--cpus", "0"], 2, "--cpus 0"),
        (["--time", "soon"], 2, "--time soon"),
        (["--time", "0"], 2, "--time 0"),
        (["--time", "1:2:3:4"], 2, "--time 1:2:3:4"),
        (["--time", ""], 2, "--time"),
        (["--mem", "much"], 2, "--mem much"),
        (["--mem", "-1"], 2, "--mem -1"),
        (["--partition", ""], 2, "--partition"),
        (["--partition", "a\nb"], 2, "--partition"),
        (["--sbatch", "exclusive"], 2, "--sbatch"),
        (["--sbatch=--exclusive\nrm -rf"], 2, "--sbatch"),
        (["--store", "back\\slash"], 2, "--store"),
        (["--store", "two\nlines"], 2, "--store"),
        (["--quick"], 2, "--quick"),
        (["--seeds", "1000000"], 2, "--yes"),
        (["--set", "gait.step_height=9"], 3, "step_height"),
    ],
)
def test_bad_input_is_one_message_before_anything_is_written(
    folder: Folder, words: list[str], code: int, named: str
) -> None:
    for more in ([], ["--dry-run"]):
        found, out, err = folder.gaitlab("submit", FILE, *words, *more)
        assert (found, out) == (code, ""), err
        assert named in err or shutil.which("sbatch") is None
        assert "Traceback" not in err
        assert list(folder.path.iterdir()) == []


def test_a_study_is_told_how_several_machines_search(folder: Folder) -> None:
    code, out, err = folder.gaitlab("submit", str(DATA / "pretended_study.yaml"), "--dry-run")
    assert (code, out) == (2, "")
    assert "optimize" in err
    assert "--storage" in err


def test_without_sbatch_it_says_so_and_submits_nothing(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    code, out, err = folder.gaitlab("submit", FILE)
    assert (code, out) == (2, "")
    assert "sbatch" in err
    assert "--dry-run" in err
    assert list(folder.path.iterdir()) == []
