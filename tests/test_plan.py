"""A plan is counted without being made, and made in the order of the file."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.experiment.plan import plan
from gaitlab.parameters import get_path
from tests.written import EXPERIMENT, changed, read


def test_the_size_is_the_number_of_trials(tmp_path: Path) -> None:
    made = plan(read(tmp_path))
    trials = list(made.trials())
    assert made.size == len(trials) == 3 * 2 * 2 * 2 * 4
    assert made.cell_count == len(list(made.cells())) == made.size // 4


def test_every_trial_of_a_plan_is_another(tmp_path: Path) -> None:
    trials = list(plan(read(tmp_path)).trials())
    assert len({planned.trial.id for planned in trials}) == len(trials)


def test_a_plan_is_the_same_every_time(tmp_path: Path) -> None:
    first, second = (
        [planned.trial.id for planned in plan(read(tmp_path)).trials()] for _ in range(2)
    )
    assert first == second


def test_rounds_are_the_same_trials_one_seed_of_every_cell_after_another(tmp_path: Path) -> None:
    made = plan(read(tmp_path))
    trials, rounds = list(made.trials()), list(made.rounds())
    assert sorted(place for place, _ in rounds) == list(range(made.size))
    assert all(planned.trial.id == trials[place].trial.id for place, planned in rounds)
    seeds = [planned.trial.seed for _, planned in rounds]
    assert seeds == sorted(seeds)


def test_cells_keep_the_order_of_the_file(tmp_path: Path) -> None:
    cells = [cell.values for cell in plan(read(tmp_path)).cells()]
    assert [cell["surface"] for cell in cells[:4]] == ["grass_50mm", "carpet_4mm"] * 2
    lengths = [cell["gait.step_length"] for cell in cells]
    assert lengths == sorted(lengths)
    strikes = [(cell["gait.heel_strike"], cell["gait.areas"]) for cell in cells]
    assert set(strikes) == {("none", 3), ("add", 4)}


@given(index=st.integers(0, 23))
def test_a_cell_found_by_its_index_is_the_one_counted_to(tmp_path_factory, index: int) -> None:
    made = plan(read(tmp_path_factory.getbasetemp()))
    (counted,) = islice(made.cells(), index, index + 1)
    assert made.cell(index) == counted


def test_a_trial_has_the_values_of_its_cell(tmp_path: Path) -> None:
    more = """seeds: 2
one_at_a_time:
  horizon.cycles: [3, 4]
  surface.toe_catch: [1.0, 5.0]
  spread.friction: [0.0]
  engine.dt: [0.001]
  servo.supply: [11.1]
"""
    made = plan(read(tmp_path, changed("seeds: 4\n", more)))
    for planned in islice(made.trials(), 0, None, 7):
        trial, cell = planned.trial, planned.values
        assert trial.names.surface == cell["surface"]
        assert made.cell(planned.cell_index).values == cell
        assert {servo.supply for servo in trial.servos} == {cell["servo.supply"]}
        for path in set(cell) - {"surface", "servo.supply"}:
            group, _, rest = path.partition(".")
            assert get_path(getattr(trial, group), rest) == cell[path]


def test_what_is_not_varied_stays_as_the_file_says(tmp_path: Path) -> None:
    experiment = read(tmp_path, EXPERIMENT + "horizon: {cycles: 4}\nservo: {torque_limit: 0.5}\n")
    trial = next(plan(experiment).trials()).trial
    assert (trial.gait.step_height, trial.gait.hip_height) == (0.02, 0.225)
    assert (trial.horizon.cycles, trial.horizon.time) == (4.0, 60.0)
    assert {servo.torque_limit for servo in trial.servos} == {0.5}


def test_each_joint_has_the_servo_of_the_robot_unless_the_experiment_chooses(tmp_path) -> None:
    trial = next(plan(read(tmp_path)).trials()).trial
    joints = trial.robot.tree.joints
    torque = {"mx_64": 6.0, "mx_28": 2.5}
    assert [servo.stall_torque for servo in trial.servos] == [torque[j.servo] for j in joints]
    other = next(plan(read(tmp_path, EXPERIMENT + "servo: ax_12\n")).trials()).trial
    assert {servo.stall_torque for servo in other.servos} == {1.5}


def test_servos_can_be_compared_by_name(tmp_path: Path) -> None:
    text = changed("robot.sole.kind: [flat, studs]", "servo.type: [mx_28, mx_64]")
    torques = [p.trial.servos[0].stall_torque for p in plan(read(tmp_path, text)).trials()]
    assert set(torques) == {2.5, 6.0}


def test_seeds_are_the_innermost_and_as_listed(tmp_path: Path) -> None:
    made = plan(read(tmp_path, changed("seeds: 4", "seeds: [7, 2]")))
    assert [planned.trial.seed for planned in islice(made.trials(), 6)] == [7, 2] * 3


def test_a_sweep_around_a_base_varies_one_thing_at_a_time(tmp_path: Path) -> None:
    text = (
        "robot: eros\ngait: {type: ./my_gait.py, step_length: 0.04}\nsurfaces: [hard_floor]\n"
        "one_at_a_time:\n  gait.step_length: [0.02, 0.04, 0.06]\n  gait.hip_height: [0.2, 0.21]\n"
        "seeds: 1\n"
    )
    cells = [cell.values for cell in plan(read(tmp_path, text)).cells()]
    base = {"gait.step_length": 0.04, "gait.hip_height": 0.225, "surface": "hard_floor"}
    assert cells[0] == base
    assert len(cells) == 5
    assert all(sum(cell[path] != base[path] for path in base) == 1 for cell in cells[1:])


def test_a_grid_of_a_thousand_million_is_counted_and_not_made(tmp_path: Path) -> None:
    values = list(range(10, 42))
    lines = "".join(
        f"  {path}: {[v * factor for v in values]}\n"
        for path, factor in [
            ("gait.step_length", 1e-3),
            ("gait.hip_height", 0.01),
            ("robot.mass", 0.1),
            ("horizon.cycles", 1),
            ("spread.friction", 0.01),
        ]
    )
    text = (
        "robot: eros\ngait: {type: ./my_gait.py, step_height: 0.02}\nsurfaces: [hard_floor]\n"
        f"grid:\n{lines}seeds: 30\n"
    )
    made = plan(read(tmp_path, text))
    assert made.size == 32**5 * 30 > 10**9
    assert made.seconds > 2.0
    assert made.cell(made.cell_count - 1).values["robot.mass"] == pytest.approx(4.1)
    assert len(list(islice(made.trials(), 100))) == 100


def test_ten_million_seeds_are_counted_and_not_made(tmp_path: Path) -> None:
    assert plan(read(tmp_path, EXPERIMENT, "seeds=10000000")).size == 24 * 10**7


@pytest.mark.parametrize(
    ("horizon", "seconds"),
    [
        ("{cycles: 9, distance: 6.0, time: 60.0}", 2.0 + 9.0),
        ("{cycles: 100, distance: 6.0, time: 5.0}", 2.0 + 5.0),
        ("{cycles: 1000, distance: 0.8, time: 600.0}", 2.0 + 0.8 / (2 * 0.04 / 1.0)),
    ],
)
def test_a_trial_is_expected_to_last_until_the_first_horizon(tmp_path, horizon, seconds) -> None:
    text = (
        "robot: eros\ngait: {type: ./my_gait.py, step_length: 0.04}\nsurfaces: [hard_floor]\n"
        f"horizon: {horizon}\n"
    )
    assert plan(read(tmp_path, text)).seconds == pytest.approx(seconds)


def test_shared_parts_are_made_once(tmp_path: Path) -> None:
    trials = [planned.trial for planned in plan(read(tmp_path)).trials()]
    assert len({id(trial.robot) for trial in trials}) == 2
    assert len({id(trial.surface) for trial in trials}) == 2
    assert len({id(trial.servos) for trial in trials}) == 2


def test_a_ground_of_another_name_gives_the_same_trials(tmp_path: Path) -> None:
    (tmp_path / "lawn.yaml").write_text("type: rigid\nfriction: 0.6\n")
    shipped, own = (
        [
            planned.trial.id
            for planned in plan(read(tmp_path, changed("[grass_50mm, carpet_4mm]", one))).trials()
        ]
        for one in ("[hard_floor]", "[./lawn.yaml]")
    )
    assert shipped == own
