from pathlib import Path

import pytest

from gaitlab.errors import FileError
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.basis import basis
from gaitlab.simulation.trial import Trial

WALKERS = """\
walkers:
  - {robot: eros, gait: {type: eros, step_length: 0.02}}
  - {include: base.yaml, servo: {supply: 11.5}}
  - {include: base.yaml, gait: {stand_time: 0.5}, name: patient}
"""
REST = "surfaces: [hard_floor, carpet_4mm]\nseeds: 2\n"
BASE = "robot: bioloid\ngait: {type: bioloid, coupling: spatial}\nservo: {supply: 11.1}\n"


def experiment(folder: Path, text: str = WALKERS + REST) -> Experiment:
    (folder / "base.yaml").write_text(BASE + "surfaces: [grass_50mm]\nseeds: 99\n")
    file = folder / "all.yaml"
    file.write_text(text)
    return load_experiment(file)


def problems(folder: Path, text: str) -> list[str]:
    with pytest.raises(FileError) as caught:
        experiment(folder, text)
    return [str(problem).removeprefix(f"{folder}/all.yaml:") for problem in caught.value.problems]


def test_walkers_multiply_with_grounds_and_seeds_under_the_column_robot(tmp_path: Path) -> None:
    planned = plan(experiment(tmp_path))
    cells = [(cell.values["robot"], cell.values["surface"]) for cell in planned.cells()]
    robots, grounds = ("eros", "bioloid", "patient"), ("hard_floor", "carpet_4mm")
    assert cells == [(robot, ground) for robot in robots for ground in grounds]
    assert [planned.cell(cell.index) for cell in planned.cells()] == list(planned.cells())
    assert planned.size == len(list(planned.trials())) == 12


def test_each_walker_has_its_own_robot_gait_and_servos(tmp_path: Path) -> None:
    trials = {item.trial.names.robot: item.trial for item in plan(experiment(tmp_path)).trials()}
    eros, bioloid, patient = (trials[name] for name in ("eros", "bioloid", "patient"))
    assert (eros.robot.name, bioloid.robot.name, patient.robot.name) == (
        "eros",
        "bioloid",
        "bioloid",
    )
    assert (eros.gait.step_length, bioloid.gait.coupling) == (0.02, "spatial")
    assert (bioloid.gait.stand_time, patient.gait.stand_time) == (1.0, 0.5)
    assert [len(trial.servos) for trial in (eros, bioloid)] == [20, 23]
    supplies = [trial.servos[0].supply for trial in (eros, bioloid, patient)]
    assert supplies == [12.0, 11.5, 11.1]


def test_a_base_hands_down_the_walker_alone(tmp_path: Path) -> None:
    found = experiment(tmp_path)
    assert list(found.parts.surfaces) == ["hard_floor", "carpet_4mm"]
    assert len(found.seeds) == 2


def test_a_walker_s_trials_are_those_of_its_own_experiment(tmp_path: Path) -> None:
    alone = "robot: eros\ngait: {type: eros, step_length: 0.02}\n" + REST
    own = [item.trial.id for item in plan(experiment(tmp_path, alone)).trials()]
    together = [item.trial.id for item in plan(experiment(tmp_path)).trials()]
    assert together[:4] == own


def test_a_planned_trial_survives_the_way_to_a_worker(tmp_path: Path) -> None:
    for item in plan(experiment(tmp_path)).trials():
        assert Trial.from_dict(item.trial.to_dict()) == item.trial


def test_a_grid_holds_for_every_walker(tmp_path: Path) -> None:
    grid = "grid:\n  gait.step_length: [0.01, 0.02]\n"
    assert plan(experiment(tmp_path, WALKERS + REST + grid)).cell_count == 12
    only_eros = "grid:\n  gait.heel_strike: [none, add]\n"
    (message,) = problems(tmp_path, WALKERS + REST + only_eros)
    assert message.startswith("8:3:")
    assert "gait.heel_strike" in message


def test_a_walker_brings_its_own_time_step(tmp_path: Path) -> None:
    walkers = WALKERS.replace("name: patient", "name: patient, engine: {dt: 0.001}")
    trials = [item.trial for item in plan(experiment(tmp_path, walkers + REST)).trials()]
    assert {t.engine.dt for t in trials if t.names.robot == "patient"} == {0.001}
    assert {t.engine.dt for t in trials if t.names.robot != "patient"} == {0.002}


def test_digest_and_basis_follow_every_walker(tmp_path: Path) -> None:
    one = experiment(tmp_path)
    other = experiment(tmp_path, (WALKERS + REST).replace("0.5}", "0.6}"))
    assert one.digest != other.digest
    different = {name for name, digest in basis(one).items() if basis(other)[name] != digest}
    assert different == {"gait"}


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("walkers:", "robot: eros\nwalkers:", "1:1", "the walkers have their own"),
        ("{robot: eros, gait: {type: eros, step_length: 0.02}}", "eros", "2:5", "found the text"),
        ("name: patient", "nam: patient", "4:51", "did you mean 'name'"),
        (", name: patient", "", "4:5", "'bioloid' is there already"),
        ("{robot: eros, ", "{", "2:5", "has a `robot` and a `gait`"),
        ("{robot: eros, ", "{robot: erso, ", "2:13", "did you mean 'eros'"),
        ("include: base.yaml, s", "include: bace.yaml, s", "3:15", "there is no file"),
        ("stand_time: 0.5", "stand_tim: 0.5", "4:33", "did you mean 'stand_time'"),
    ],
)
def test_a_mistake_is_answered_at_its_place(
    tmp_path: Path, old: str, new: str, place: str, words: str
) -> None:
    assert old in WALKERS
    found = problems(tmp_path, WALKERS.replace(old, new) + REST)
    assert any(line.startswith(f"{place}:") and words in line for line in found), found


def test_what_all_walkers_share_is_answered_once(tmp_path: Path) -> None:
    found = problems(tmp_path, WALKERS + REST.replace("carpet_4mm", "carpet_5mm"))
    assert len(found) == 1


def test_the_shipped_matrix_holds_every_walking_robot_on_every_ground() -> None:
    matrix = load_experiment("all_robots")
    names = {parts.robot.name for parts in matrix.walkers.values()}
    assert {"eros", "flow", "nao", "bioloid", "biped"} == names
    assert len(matrix.parts.surfaces) == 6
    assert len(matrix.seeds) == 10
    assert matrix.report.rows == "robot"
