"""`gaitlab new`: what it writes runs as it is, and it never replaces a file."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.cli.starting import NewKind
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.store import Store
from gaitlab.surfaces.files import load_surface

SHORT = ["--engine", "mujoco", "--set", "horizon={cycles: 0.5, time: 0.5}", "-j", "0", "--quiet"]
SUFFIX = {NewKind.gait: ".py"}


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def begun(kind: NewKind, name: str) -> str:
    assert run_command_line(["new", kind.value, name]) == 0
    return f"./{name}{SUFFIX.get(kind, '.yaml')}"


def counts(experiment: str) -> dict[str, int]:
    (listed,) = Store(Path("data")).lists().sound.values()
    states = Store(Path("data")).states()
    found = [states[trial.trial_id] for trial in listed.trials]
    assert experiment
    return {state: found.count(state) for state in set(found)}  # type: ignore[arg-type]


def test_a_new_experiment_runs_as_it_is_and_is_reported() -> None:
    file = begun(NewKind.experiment, "our_walk")
    loaded = load_experiment(file)
    assert loaded.name == "our_walk"
    assert plan(loaded).size < 100, "a first run is over in minutes"
    assert run_command_line(["run", file, "--seeds", "1", *SHORT]) == 0
    assert counts(file) == {"DONE": plan(loaded).cell_count}
    assert run_command_line(["report", file, "--seeds", "1", *SHORT[2:4], *ENGINE]) == 0


ENGINE = ["--set", "engine.name=mujoco"]


@pytest.mark.parametrize("kind", ["surface", "servo", "gait"])
def test_a_new_part_walks_in_a_new_experiment(kind: str) -> None:
    walk = begun(NewKind.experiment, "our_walk")
    part = begun(NewKind(kind), f"our_{kind}")
    setting = {"surface": f"surfaces=[{part}]", "servo": f"servo.type={part}"}
    chosen = setting.get(kind, f"gait={part}")
    one = ["--set", "grid={gait.step_length: [0.02]}"]
    assert run_command_line(["run", walk, "--seeds", "1", *SHORT, "--set", chosen, *one]) == 0
    assert set(counts(walk)) == {"DONE"}
    assert run_command_line(["show", part]) == 0


def test_a_new_gait_walks_ahead_with_its_feet_on_the_ground() -> None:
    import gaitlab

    begun(NewKind.experiment, "our_walk")
    begun(NewKind.gait, "march")
    settings = {
        "gait": "./march.py",
        "grid": {"gait.step_length": [0.0, 0.03]},
        "surfaces": ["hard_floor"],
        "engine.name": "mujoco",
        "horizon.cycles": 4,
    }
    loaded = gaitlab.load("./our_walk.yaml", set=settings)
    still, ahead = (loaded.simulate(cell).metrics["distance"] for cell in (0, 1))
    assert isinstance(still, float)
    assert isinstance(ahead, float)
    assert ahead > still + 0.05


def test_a_new_study_searches_as_it_is() -> None:
    file = begun(NewKind.study, "our_study")
    few = ["--trials", "2", "--set", "study.batch=2", "--set", "seeds=1", "--no-validation"]
    assert run_command_line(["optimize", file, "-n", *few]) == 0
    assert run_command_line(["optimize", file, *SHORT, *few]) == 0


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (NewKind.experiment, "eros_quick"),
        (NewKind.study, "eros_small"),
        (NewKind.surface, "grass_30mm"),
    ],
)
def test_a_copy_means_what_its_original_means_and_finds_its_schema(
    kind: NewKind, name: str, tmp_path: Path
) -> None:
    assert run_command_line(["new", kind.value, "deep/ours", "--from", name]) == 0
    copy = tmp_path / "deep" / "ours.yaml"
    first = copy.read_text().splitlines()[0]
    assert (copy.parent / first.partition("$schema=")[2]).is_file()
    assert copy.read_text().count("yaml-language-server") == 1
    if kind is NewKind.surface:
        assert load_surface(str(copy)) == load_surface(name)
        return
    original, copied = load_experiment(name), load_experiment(copy)
    assert copied.name == "ours"
    assert copied.study == original.study
    ids = [[t.trial.id for t in islice(plan(e).trials(), 3)] for e in (original, copied)]
    assert ids[0] == ids[1]


@pytest.mark.parametrize("kind", NewKind)
def test_a_file_that_is_there_is_left(kind: NewKind) -> None:
    path = Path(begun(kind, "mine"))
    for content in (path.read_text(), "mine\n"):
        path.write_text(content)
        assert run_command_line(["new", kind.value, "mine"]) == 2
        assert run_command_line(["new", kind.value, path.name]) == 2
        assert path.read_text() == content
    path.unlink()
    path.symlink_to("nowhere")
    assert run_command_line(["new", kind.value, "mine"]) == 2
    assert not Path("nowhere").exists()


@pytest.mark.parametrize("name", ["", "-", "a b", "../", "x" * 101, ".hidden", "-n"])
def test_a_name_that_results_could_not_have_is_refused(name: str, tmp_path: Path) -> None:
    assert run_command_line(["new", "experiment", "--", name]) == 2
    assert not list(tmp_path.iterdir())


def test_a_folder_may_stand_before_the_name_and_the_ending_behind() -> None:
    assert run_command_line(["new", "surface", "fields/ours.yaml"]) == 0
    assert Path("fields/ours.yaml").is_file()
    assert Path("fields/.gaitlab/surface.json").is_file()
