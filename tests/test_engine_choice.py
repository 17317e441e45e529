"""Which engine simulates: chosen in a file or on the command line, compared, confirmed, refused."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.search import Candidate, History
from gaitlab.search.final import final_experiment
from gaitlab.search.fresh import default_experiment, searched_experiment, winner_experiment
from gaitlab.search.margins import Around
from gaitlab.simulation.engines import ENGINES, require_engine
from gaitlab.store import Store
from tests.search import searches

BULLET = load_experiment("eros_quick", ["seeds=2"])


def engines_of(experiment) -> set[str]:
    return {planned.trial.engine.name for planned in plan(experiment).trials()}


@pytest.mark.bullet
def test_a_trial_of_the_default_engine_keeps_its_name_and_another_engine_has_another() -> None:
    named = load_experiment("eros_quick", ["seeds=2", "engine.name=bullet"])
    other = load_experiment("eros_quick", ["seeds=2", "engine.name=mujoco"])
    ids = [{planned.trial.id for planned in plan(e).trials()} for e in (BULLET, named, other)]
    assert ids[0] == ids[1]
    assert not ids[0] & ids[2]
    assert len(ids[2]) == len(ids[0])


def test_one_experiment_walks_in_both_engines_under_the_names_of_each_alone() -> None:
    both = load_experiment("eros_quick", ["seeds=2", "grid.engine.name=[bullet, mujoco]"])
    assert both.engines == engines_of(both) == {"bullet", "mujoco"}
    ids = {planned.trial.id for planned in plan(both).trials()}
    for name in both.engines:
        alone = load_experiment("eros_quick", ["seeds=2", f"engine.name={name}"])
        assert alone.engines == engines_of(alone) == {name}
        assert {planned.trial.id for planned in plan(alone).trials()} < ids


def test_every_robot_of_an_experiment_takes_the_chosen_engine() -> None:
    assert engines_of(load_experiment("all_robots", ["seeds=1", "engine.name=mujoco"])) == {
        "mujoco"
    }


@pytest.mark.parametrize("setting", ["engine.name=ode", "engine.name=3", "engine.name="])
def test_an_engine_that_there_is_not_is_refused_with_those_that_there_are(setting: str) -> None:
    with pytest.raises(FileError, match="bullet, mujoco"):
        load_experiment("eros_quick", [setting])


def test_options_of_the_other_engine_are_refused() -> None:
    with pytest.raises(FileError, match="solver_iterations"):
        load_experiment("eros_quick", ["engine.name=mujoco", "engine.solver_iterations=80"])
    assert load_experiment("eros_quick", ["engine.solver_iterations=80"])


@pytest.mark.parametrize("name", ENGINES)
def test_an_engine_that_is_not_installed_is_refused_before_anything_runs(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    package = ENGINES[name].package
    monkeypatch.setitem(sys.modules, package, None)  # what Python does for a missing one
    with pytest.raises(WrongValue, match="pip install"):
        require_engine(name)
    monkeypatch.chdir(tmp_path)
    for command in ("run eros_quick", "optimize eros_small"):
        code = run_command_line([*command.split(), "--engine", name, "-j", "0", "--store", "s"])
        said = capfd.readouterr().err
        assert code == 3
        assert package in said
        assert "Traceback" not in said
        assert not Store(Path("s")).states()


def study(*settings: str):
    return searches.study("engine.name=mujoco", *settings)


def history(experiment) -> History:
    values = {"gait.step_height": 0.03, "gait.lateral_sway": 0.02, "gait.heel_strike": "none"}
    found = Candidate(
        number=0, values=values, state="done", objectives=(0.1,), violations=(), feasible=True,
        seeds=2, trial_ids=(), batch=0, simulated=1.0,
    )  # fmt: skip
    return History(experiment=experiment, candidates=(found,))


def test_a_study_is_searched_in_one_engine_and_confirmed_in_another(tmp_path: Path) -> None:
    searched = history(study("study.confirm=bullet"))
    (chosen,) = searched.candidates
    assert engines_of(final_experiment(searched.experiment, chosen)) == {"bullet"}
    assert engines_of(winner_experiment(searched, chosen)) == {"bullet"}
    assert engines_of(default_experiment(searched.experiment)) == {"bullet"}
    around: list[set[str]] = []
    Around(
        searched, chosen, Store(tmp_path), lambda e: bool(around.append(engines_of(e)))
    ).margins()
    assert around
    assert set.union(*around) == {"bullet"}
    again = searched_experiment(searched, chosen)
    assert again is not None
    assert engines_of(again) == {"mujoco"}
    assert again.name != winner_experiment(searched, chosen).name


@pytest.mark.parametrize("settings", [(), ("study.confirm=mujoco",)])
def test_a_study_that_names_no_other_engine_stays_in_its_own(settings: tuple[str, ...]) -> None:
    searched = history(study(*settings))
    (chosen,) = searched.candidates
    assert searched_experiment(searched, chosen) is None
    assert engines_of(winner_experiment(searched, chosen)) == {"mujoco"}


def test_a_study_that_confirms_elsewhere_is_another_study_and_one_that_does_not_is_the_same() -> (
    None
):
    plain = searches.study()
    assert searches.study("study.confirm=bullet").digest != plain.digest
    assert searches.study().digest == plain.digest


def test_what_was_run_with_an_engine_is_shown_with_the_same_option(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["eros_quick", "--engine", "mujoco", "--seeds", "1", "--set", "horizon.cycles=1",
             "--set", "surfaces=[carpet_4mm]", "--set", "grid.gait.step_length=[0.02]"]  # fmt: skip
    assert run_command_line(["run", *asked, "-j", "0", "--quiet"]) == 0
    folders = set()
    for command in (["report", *asked], ["view", *asked, "--no-open"]):
        assert run_command_line(command) == 0
        page = Path(capfd.readouterr().out.splitlines()[-1])
        assert page.is_file()
        folders.add(page.parent)
    assert len(folders) == 1
