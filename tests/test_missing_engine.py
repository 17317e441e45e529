"""An engine that is not installed, or another version than is known: who takes its place, and what
a user is told. No trial is ever to blame for it."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from gaitlab.cli import common, run_command_line
from gaitlab.errors import NoEngine, UnknownName
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.run_trial import run_trial
from gaitlab.simulation import engines
from gaitlab.simulation.engines import ENGINES, default_engine, require_engine
from gaitlab.store import Store
from tests.pretended import FILE, pretend_well

PACKAGES = {name: kind.package for name, kind in ENGINES.items()}


@pytest.fixture
def only(monkeypatch: pytest.MonkeyPatch):
    """Let these engines be installed and no others, as far as Python's imports know."""

    def leave(*names: str) -> None:
        common.tell_engine.cache_clear()
        for name, package in PACKAGES.items():
            if name not in names:
                monkeypatch.setitem(sys.modules, package, None)
            elif find_spec(package) is None:
                pytest.skip(f"{package} is not installed")

    return leave


@pytest.mark.parametrize("name", PACKAGES)
def test_a_missing_engine_is_named_with_the_way_to_get_it(only, name: str) -> None:
    only()
    with pytest.raises(NoEngine, match="pip install") as caught:
        require_engine(name)
    assert PACKAGES[name] in str(caught.value)
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("found", ["3.9.1", "4.1.0", "40.0.1"])
def test_another_mujoco_is_refused_and_the_right_one_named(monkeypatch, only, found: str) -> None:
    only("mujoco")
    monkeypatch.setattr(engines, "_version", lambda package: found)
    with pytest.raises(NoEngine, match=r"4\.0\..*found " + found):
        require_engine("mujoco")


@pytest.mark.parametrize(
    ("settings", "without_bullet"),
    [
        ((), "mujoco"),
        (("engine.dt=0.001",), "mujoco"),
        (("engine.name=bullet",), "bullet"),
        (("engine.name=mujoco",), "mujoco"),
        (("engine.solver_iterations=60",), "bullet"),
        (("grid.engine.solver_iterations=[50, 60]",), "bullet"),
    ],
)
def test_mujoco_stands_in_only_where_a_file_does_not_say_which(
    only, settings: tuple[str, ...], without_bullet: str
) -> None:
    usual = load_experiment(FILE, settings).parts.engine
    only("mujoco")
    assert load_experiment(FILE, settings).parts.engine.name == without_bullet
    if without_bullet == "bullet":
        assert load_experiment(FILE, settings).parts.engine == usual


def test_where_no_engine_is_the_reference_is_asked_for(only) -> None:
    only()
    assert default_engine() == "bullet"
    assert load_experiment(FILE).parts.engine.name == "bullet"


def test_a_trial_without_its_engine_stays_undone_and_has_not_failed(only, tmp_path: Path) -> None:
    only("mujoco")
    wanted = next(plan(load_experiment(FILE, ["engine.name=bullet"])).trials()).trial
    with pytest.raises(NoEngine):
        run_trial(wanted.id, wanted.to_dict(), tmp_path)
    with pytest.raises(UnknownName):
        Store(tmp_path).record(wanted.id)


@pytest.mark.parametrize("jobs", ["0", "1"])
@pytest.mark.parametrize("name", PACKAGES)
def test_a_run_in_a_missing_engine_ends_before_it_begins(
    only, tmp_path: Path, monkeypatch, capfd, name: str, jobs: str
) -> None:
    only()
    monkeypatch.chdir(tmp_path)
    code = run_command_line(["run", str(FILE), "--engine", name, "-j", jobs])
    out, err = capfd.readouterr()
    assert (code, out) == (3, "")
    assert "pip install" in err
    assert "Traceback" not in err
    assert not list(tmp_path.rglob("*.parquet"))


def test_what_stands_in_is_said_once(only, tmp_path: Path, monkeypatch, capfd) -> None:
    only("mujoco")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    said = []
    for seeds in ("1", "2"):
        assert run_command_line(["run", str(FILE), "--seeds", seeds, "-j", "0", "--quiet"]) == 0
        said += [line for line in capfd.readouterr().err.splitlines() if "mujoco" in line]
    assert len(said) == 1
