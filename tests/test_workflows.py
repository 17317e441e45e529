"""The workflows and the lab machine's files do what they say: their own lines are run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from gaitlab.cli.app import app
from gaitlab.experiment import load_experiment

pytestmark = pytest.mark.long

ROOT = Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
CONTRIB = ROOT / "contrib"
DATA = Path(__file__).parent / "data"
COMMANDS = {info.name or info.callback.__name__ for info in app.registered_commands}
MAKEFILE = (ROOT / "Makefile").read_text().replace("$(VENV)", ".venv")
TARGETS = set(re.findall(r"^([\w./-]+):", MAKEFILE, re.MULTILINE))


def read(workflow: Path) -> dict:
    return YAML(typ="safe").load(workflow)


def steps(workflow: Path) -> Iterator[dict]:
    for job in read(workflow)["jobs"].values():
        yield from job["steps"]


def step(name: str) -> str:
    """What a named step of the nightly workflow runs."""
    nightly = ROOT / ".github" / "workflows" / "nightly.yml"
    return next(each["run"] for each in steps(nightly) if each.get("name") == name)


def test_tests_lint_and_the_nightly_gate_have_a_workflow() -> None:
    assert [file.stem for file in WORKFLOWS] == ["lint", "nightly", "tests"]


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda file: file.stem)
def test_a_workflow_calls_what_exists_and_pins_the_actions_of_others(workflow: Path) -> None:
    for each in steps(workflow):
        assert re.fullmatch(r"actions/[\w/-]+@v\d+", each.get("uses", "actions/checkout@v4"))
        script = each.get("run", "")
        assert set(re.findall(r"^ *make (\S+)", script, re.MULTILINE)) <= TARGETS
        assert set(re.findall(r"^ *gaitlab (\w+)", script, re.MULTILINE)) <= COMMANDS


def test_the_nightly_gate_walks_every_night_what_the_repository_has() -> None:
    nightly = read(ROOT / ".github" / "workflows" / "nightly.yml")
    assert set(nightly["on"]) == {"schedule", "workflow_dispatch"}
    walked = nightly["env"]["EXPERIMENTS"].split()
    assert [load_experiment(str(ROOT / file)).name for file in walked] == ["nightly", "standing"]
    assert (ROOT / nightly["env"]["BASELINES"] / "nightly.json").is_file()
    kept = [
        each["with"]["path"] for each in steps(WORKFLOWS[1]) if "cache/" in each.get("uses", "")
    ]
    assert kept == [nightly["env"]["STORE"]] * 2, "brought back before, kept after"
    assert {"test", "lint", "types", ".venv/installed"} <= TARGETS


class Night:
    """A folder with a tiny experiment, in which the lines of the workflow are run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("stand.yaml", "stand.py"):
            shutil.copy(DATA / name, folder / name)
        (folder / "bin").mkdir()
        (folder / "bin" / "gaitlab").write_text(
            f'#!/bin/sh\nexec {sys.executable} -m gaitlab "$@"\n'
        )
        (folder / "bin" / "gaitlab").chmod(0o755)

    def environment(self, **more: str) -> Mapping[str, str]:
        files = {f"GITHUB_{name}": str(self.folder / name) for name in ("STEP_SUMMARY", "OUTPUT")}
        path = f"{self.folder / 'bin'}:{os.environ['PATH']}"
        names = {"EXPERIMENTS": "stand.yaml", "BASELINES": ".", "STORE": "store"}
        return {**os.environ, **files, **names, "PATH": path, **more}

    def bash(self, script: str, **more: str) -> subprocess.CompletedProcess[str]:
        """As a runner does it: bash -e with pipefail."""
        return subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script],
            cwd=self.folder, env=self.environment(**more), capture_output=True, text=True,
            check=False, timeout=300,
        )  # fmt: skip

    def check(self, **more: str) -> tuple[str, str, str]:
        """The step of the gate: its verdict, the page of the job, what it printed."""
        for name in ("STEP_SUMMARY", "OUTPUT"):
            (self.folder / name).unlink(missing_ok=True)
        done = self.bash(step("Walk and compare"), **more)
        assert done.returncode == 0, done.stderr
        verdict = (self.folder / "OUTPUT").read_text().strip().removeprefix("verdict=")
        return verdict, (self.folder / "STEP_SUMMARY").read_text(), done.stdout

    def copy(self, folder: Path) -> Night:
        shutil.copytree(self.folder, folder, dirs_exist_ok=True)
        copy = Night.__new__(Night)
        copy.folder = folder
        return copy


@pytest.fixture(scope="module")
def night(tmp_path_factory: pytest.TempPathFactory) -> Night:
    """A store and its baseline."""
    night = Night(tmp_path_factory.mktemp("night"))
    made = night.bash(
        "gaitlab run stand.yaml -j 1 --store store && "
        "gaitlab baseline stand.yaml --store store --output stand.json"
    )
    assert made.returncode == 0, made.stderr
    return night


@pytest.fixture
def tonight(night: Night, tmp_path: Path) -> Night:
    """A copy of it for one test."""
    return night.copy(tmp_path)


@pytest.fixture(scope="module")
def worse(night: Night, tmp_path_factory: pytest.TempPathFactory) -> Night:
    """A copy of it in which the feet were moved behind the trunk, and nothing walked since."""
    copy = night.copy(tmp_path_factory.mktemp("worse"))
    gait = copy.folder / "stand.py"
    gait.write_text(gait.read_text().replace("LEAN = 0.0", "LEAN = -0.09"))
    return copy


def test_an_unchanged_night_passes_both_gates_and_has_a_report(
    tonight: Night,
) -> None:
    verdict, page, printed = tonight.check()
    assert verdict == "0"
    assert "nothing changed" in page
    assert "::error" not in printed
    for gate in ("Fail if the robot walks worse", "Fail if nothing could be decided"):
        assert tonight.bash(step(gate), VERDICT=verdict).returncode == 0
    assert tonight.bash(step("Write the report")).returncode == 0
    assert (tonight.folder / "nightly-report" / "stand" / "index.html").is_file()


def test_a_worse_gait_fails_the_gate_of_its_name_with_exit_5(worse: Night) -> None:
    verdict, page, printed = worse.check()
    assert verdict == "5"
    assert "Worse: " in page
    assert "::error title=The robot walks worse" in printed
    assert worse.bash(step("Fail if the robot walks worse"), VERDICT=verdict).returncode == 5


def test_a_night_without_a_baseline_says_so_and_looks_different(tonight: Night) -> None:
    (tonight.folder / "stand.json").unlink()
    verdict, page, printed = tonight.check()
    assert verdict == "6"
    assert "could not decide" in page
    assert "::warning title=Nothing could be decided" in printed
    assert tonight.bash(step("Fail if nothing could be decided"), VERDICT=verdict).returncode == 6


@pytest.mark.parametrize("order", ["stand.yaml other.yaml", "other.yaml stand.yaml"])
def test_one_experiment_that_is_worse_outweighs_another_that_is_open(
    worse: Night, tmp_path: Path, order: str
) -> None:
    night = worse.copy(tmp_path)
    other = (night.folder / "stand.yaml").read_text().replace("name: stand", "name: other", 1)
    (night.folder / "other.yaml").write_text(other)  # and no baseline for it
    verdict, page, printed = night.check(EXPERIMENTS=order)
    assert verdict == "5"
    assert "could not decide" in page
    assert printed.index("::error") > 0 < printed.index("::warning")
    done = lab(night, EXPERIMENTS=order)
    assert done.returncode == 5
    assert done.stdout.count("Look closer: ") == 2


def test_a_mistake_fails_the_step_itself(tonight: Night) -> None:
    (tonight.folder / "stand.yaml").write_text("name: [")
    done = tonight.bash(step("Walk and compare"))
    assert done.returncode == 3


def test_each_verdict_has_its_gate(tmp_path: Path) -> None:
    jobs = read(ROOT / ".github" / "workflows" / "nightly.yml")["jobs"]
    assert "!= '6'" in jobs["walks-no-worse"]["if"], "exit 5 and 0"
    assert "!= '5'" in jobs["could-be-decided"]["if"], "exit 6 and 0"


def lab(tonight: Night, **more: str) -> subprocess.CompletedProcess[str]:
    """The script of the lab machine."""
    return tonight.bash(f"{CONTRIB / 'nightly.sh'} {tonight.folder}", **more)


def test_the_script_of_the_lab_machine_is_silent_when_nothing_changed(tonight: Night) -> None:
    done = lab(tonight)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_script_of_the_lab_machine_shows_one_page_when_the_robot_walks_worse(
    worse: Night,
) -> None:
    done = lab(worse)
    assert done.returncode == 5
    assert done.stdout.startswith("The robot walks worse.\n# stand: worse than the baseline")
    assert done.stdout.splitlines()[-1].startswith("Look closer: gaitlab report stand.yaml ")


def test_the_units_of_systemd_are_sound() -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd is not here")
    units = [CONTRIB / f"gaitlab-nightly.{kind}" for kind in ("service", "timer")]
    done = subprocess.run(
        ["systemd-analyze", "verify", *map(str, units)],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_the_page_on_the_gate_shows_the_files_as_they_are() -> None:
    page = (ROOT / "docs" / "nightly.md").read_text()
    for name in ("gaitlab-nightly.service", "gaitlab-nightly.timer", "crontab"):
        assert (CONTRIB / name).read_text() in page, name
