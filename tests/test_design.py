"""Designed sweeps: what their points amount to, and how each kind of mistake is answered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.cli import run_command_line
from gaitlab.errors import UsageError
from gaitlab.experiment import Design, Follower, SweptRange
from gaitlab.experiment.design import unit_points
from gaitlab.experiment.plan import plan
from gaitlab.experiment.study import Numbers
from tests.written import problems, read, write

SWEEP = """\
robot: eros
gait: {type: ./my_gait.py, step_length: 0.02}
surfaces: [grass_50mm, carpet_4mm]
design:
  type: sobol
  points: 16
  seed: 1
  box:
    robot.mass: {low: 3.0, high: 4.0}
    surface.vertical_scale: {low: 0.5, high: 2.0, log: true}
    robot.sole.height: {low: 0.032, high: 0.044, with: {robot.leg.thigh: [0.108, 0.102]}}
    gait.areas: {low: 2, high: 5}
zip:
  gait.heel_strike: [none, add]
  gait.sign: [1, -1]
seeds: 1
"""
HEIGHT, THIGH = "robot.sole.height", "robot.leg.thigh"
kinds = st.sampled_from(["sobol", "lhs"])


def replaced(old: str, new: str) -> str:
    assert old in SWEEP, old
    return SWEEP.replace(old, new, 1)


def box_of(*ranges: Numbers) -> tuple[SweptRange, ...]:
    return tuple(SweptRange(range=numbers) for numbers in ranges)


def test_a_design_is_one_axis_that_multiplies_with_the_others(tmp_path: Path) -> None:
    sweep, heel = read(tmp_path, SWEEP).axes
    assert sweep.paths == ("robot.mass", "surface.vertical_scale", HEIGHT, THIGH, "gait.areas")
    assert len(sweep.rows) == 16
    assert heel.rows == (("none", 1), ("add", -1))
    made = plan(read(tmp_path, SWEEP))
    assert made.size == len({p.trial.id for p in made.trials()}) == 16 * 2 * 2


BONDING = "surface.bonding"


def test_a_swept_number_of_some_grounds_moves_those_that_have_it(tmp_path: Path) -> None:
    line = f"    {BONDING}: {{low: 1.0, high: 16.0, log: true}}\n"
    experiment = read(tmp_path, replaced("zip:\n", f"{line}zip:\n"))
    assert experiment.parts.base_values(BONDING) == [
        experiment.parts.surfaces["grass_50mm"].bonding
    ]
    planned = list(plan(experiment).trials())
    grass = [p for p in planned if p.values["surface"] == "grass_50mm"]
    carpet = [p for p in planned if p.values["surface"] == "carpet_4mm"]
    assert len(grass) == len(carpet) == 32
    assert all(p.trial.surface.bonding == p.values[BONDING] for p in grass)
    assert len({p.trial.surface.bonding for p in grass}) == 16
    assert not any(hasattr(p.trial.surface, "bonding") for p in carpet)
    assert all(
        p.trial.surface.vertical_scale == p.values["surface.vertical_scale"] for p in planned
    )
    assert len({p.trial.id for p in planned}) == len(planned)


def test_a_ground_on_which_no_point_differs_is_refused(tmp_path: Path) -> None:
    start, end = SWEEP.index("    robot.mass"), SWEEP.index("zip:")
    (found,) = problems(
        tmp_path, f"{SWEEP[:start]}    {BONDING}: {{low: 1.0, high: 16.0}}\n{SWEEP[end:]}"
    )
    assert "carpet_4mm" in found.message
    assert BONDING in found.message


@pytest.mark.parametrize("path", ["surface.solidity", "surface.stiffness"])
def test_a_swept_number_that_no_ground_has_is_refused(tmp_path: Path, path: str) -> None:
    (found,) = problems(tmp_path, replaced("surface.vertical_scale", path))
    assert f"{path!r} is no parameter of" in found.message


def test_every_point_reaches_its_trials(tmp_path: Path) -> None:
    for planned in plan(read(tmp_path, SWEEP)).trials():
        robot, values = planned.trial.robot, planned.values
        assert (robot.mass, robot.sole.height) == (values["robot.mass"], values[HEIGHT])
        assert robot.leg.thigh == values[THIGH]
        assert planned.trial.surface.vertical_scale == values["surface.vertical_scale"]


def test_a_follower_moves_in_a_straight_line(tmp_path: Path) -> None:
    for planned in plan(read(tmp_path, SWEEP)).trials():
        share = (planned.values[HEIGHT] - 0.032) / 0.012
        assert planned.values[THIGH] == pytest.approx(0.108 - 0.006 * share, abs=1e-6)


def test_whole_numbers_stay_whole_and_each_gets_its_share(tmp_path: Path) -> None:
    areas = [row[4] for row in read(tmp_path, SWEEP).axes[0].rows]
    assert all(type(value) is int for value in areas)
    assert np.bincount(areas).tolist() == [0, 0, 4, 4, 4, 4]


def test_ratios_count_where_the_file_says_so(tmp_path: Path) -> None:
    scales = [row[1] for row in read(tmp_path, SWEEP).axes[0].rows]
    assert sum(value < 1.0 for value in scales) == 8


@given(
    kind=kinds, few=st.integers(2, 40), seed=st.integers(0, 99), low=st.floats(-5.0, 5.0),
    width=st.floats(0.1, 9.0),
)  # fmt: skip
def test_every_value_lies_in_its_range_and_is_short(kind, few, seed, low, width) -> None:
    numbers = Numbers(path="robot.mass", low=low, high=low + width)
    rows = Design(type=kind, points=few, seed=seed, box=box_of(numbers)).axis().rows
    for (value,) in rows:
        assert low <= value <= low + width
        assert value in (low, low + width) or float(f"{value:.6g}") == value


@given(few=st.integers(2, 60), more=st.integers(0, 60), seed=st.integers(0, 99))
def test_fewer_points_of_a_sequence_are_the_first_of_more(few, more, seed) -> None:
    longer = unit_points("sobol", few + more, 3, seed)
    np.testing.assert_array_equal(unit_points("sobol", few, 3, seed), longer[:few])


@given(kind=kinds, seed=st.integers(0, 99))
def test_each_quantity_is_spread_evenly_over_its_range(kind, seed) -> None:
    places = np.sort(unit_points(kind, 32, 5, seed), axis=0)
    cells = np.floor(places * 32.0).astype(int)
    np.testing.assert_array_equal(cells, np.tile(np.arange(32)[:, None], (1, 5)))


def test_a_seed_repeats_its_points_and_another_has_others() -> None:
    first, again, other = (unit_points("sobol", 8, 2, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.any(first == other)


@given(log=st.booleans(), place=st.floats(0.0, 0.999))
def test_the_place_of_a_value_is_where_it_came_from(log, place) -> None:
    quantity = SweptRange(
        range=Numbers(path="robot.mass", low=0.5, high=4.0, log=log),
        followers=(Follower(path="robot.sole.heel", low=2.0, high=1.0),),
    )
    value, other = quantity.values(place)
    assert quantity.place(value) == pytest.approx(place, abs=2e-5)
    assert 1.0 <= other <= 2.0


def test_the_first_of_more_points_are_the_same_trials(tmp_path: Path) -> None:
    few, many = (
        [p.trial.id for p in plan(read(tmp_path, SWEEP, f"design.points={n}")).trials()]
        for n in (6, 16)
    )
    assert few == many[: len(few)]


def test_a_setting_of_an_end_keeps_the_rest_of_the_range(tmp_path: Path) -> None:
    design = read(tmp_path, SWEEP, "design.box.robot.mass.high=3.2").design
    assert design is not None
    assert (design.box[0].range.low, design.box[0].range.high) == (3.0, 3.2)


@pytest.mark.parametrize("path", ["robot.mass", THIGH])
def test_a_setting_of_a_swept_path_would_change_nothing(tmp_path: Path, path: str) -> None:
    with pytest.raises(UsageError, match=r"sweeps .* under design"):
        read(tmp_path, SWEEP, f"{path}=0.1")


def test_a_parameter_that_only_the_design_gives_is_there(tmp_path: Path) -> None:
    text = replaced(", step_length: 0.02", "").replace(
        "gait.areas: {low: 2, high: 5}", "gait.step_length: {low: 0.0, high: 0.1}"
    )
    steps = {p.trial.gait.step_length for p in plan(read(tmp_path, text)).trials()}
    assert len(steps) == 16


def test_a_long_plan_says_the_range_and_not_the_points(tmp_path: Path, capsys) -> None:
    given = ["run", str(write(tmp_path, SWEEP)), "-n", "--store", str(tmp_path / "store")]
    assert run_command_line(given) == 0
    said = capsys.readouterr().out
    assert "16 Sobol' points, 0.5 to 2, by ratio" in said
    assert "0.108 to 0.102 with robot.sole.height" in said


MASS = "robot.mass: {low: 3.0, high: 4.0}"
MISTAKES = [
    ("robot.mass:", "robot.mas:", "9:5", "did you mean 'robot.mass'?"),
    ("robot.mass:", "mass:", "9:5", "no dotted path"),
    ("high: 4.0}", "high: 2.0}", "9:34", "the range from 3 to 2 is upside down"),
    ("high: 4.0}", "high: 400.0}", "9:34", "allowed is a number from 0.5 to 20 kg"),
    ("low: 3.0, ", "", "9:17", "`low:` is missing; expected {low: ..., high: ...}"),
    ("high: 4.0}", "hihg: 4.0}", "9:28", "unknown key 'hihg'; did you mean 'high'?"),
    ("high: 4.0}", "high: 4.0, step: 0.5}", "9:39", "unknown key 'step'"),
    (MASS, "robot.mass: [3.0, 4.0]", "9:17", "found a list; expected {low: ..., high: ...}"),
    (MASS, "robot.sole.kind: {low: 1, high: 2}", "9:5", "is no number; vary it under grid"),
    ("low: 0.5, high: 2.0, log", "low: 0.0, high: 2.0, log", "10:35", "from 0.1 to 10"),
    (MASS, "gait.step_length: {low: -0.1, high: 0.2, log: true}", "9:29", "it is above 0"),
    ("points: 16", "points: 1", "6:11", "allowed is a whole number from 2"),
    ("  points: 16\n", "", "5:3", "`points:` is missing"),
    ("type: sobol", "type: sobl", "5:9", "did you mean 'sobol'?"),
    ("seed: 1\n", "sed: 1\n", "7:3", "unknown key 'sed'; did you mean 'seed'?"),
    ("gait.sign: [1, -1]", "robot.mass: [3, 4]", "9:5", "under zip and design; keep one"),
    ("robot.leg.thigh:", "robot.mass:", "11:57", "under design and design; keep one"),
    ("[0.108, 0.102]", "[0.108]", "11:74", "found 1 values; expected two"),
    ("[0.108, 0.102]", "0.108", "11:74", "expected two, [at the low end, at the high end]"),
    ("0.108, 0.102", "108, 102", "11:75", "108 millimetres are written 0.108"),
    ("{robot.leg.thigh: [0.108, 0.102]}", "thigh", "11:56", "with: found the text 'thigh'"),
    (MASS, "gait.step_height: {low: 0.02, high: 0.2}\n    gait.hip_height: {low: 0.05, high: 0.1}",
     "9:5", "reaches the hip; lower it"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "place", "words"), MISTAKES)
def test_a_mistake_is_answered_at_its_place(tmp_path: Path, old, new, place, words) -> None:
    found = [str(problem) for problem in problems(tmp_path, replaced(old, new))]
    start = f"{tmp_path / 'walk.yaml'}:{place}: "
    assert any(line.startswith(start) and words in line for line in found), found


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    text = replaced("robot.mass", "robot.mas").replace("points: 16", "points: 1")
    found = problems(tmp_path, text.replace("high: 2.0", "high: 0.2").replace("[1, -1]", "[1, 7]"))
    assert [problem.line for problem in found] == [6, 9, 10, 15]


@pytest.mark.parametrize("box", ["", "  box: {}\n", "  box: [robot.mass]\n"])
def test_a_design_without_a_box_says_what_to_write(tmp_path: Path, box: str) -> None:
    head, _, rest = SWEEP.partition("  box:\n")
    (found,) = problems(tmp_path, head + box + rest[rest.index("zip:") :])
    assert "`robot.mass: {low: 3.0, high: 4.0}`" in found.message


def test_a_box_of_few_whole_numbers_holds_few_points(tmp_path: Path) -> None:
    head, _, rest = SWEEP.partition("    robot.mass:")
    text = f"{head}    gait.areas: {{low: 2, high: 5}}\n{rest[rest.index('zip:') :]}"
    (found,) = problems(tmp_path, text)
    assert "only 4 of the 16 points differ" in found.message


def test_a_study_takes_no_design(tmp_path: Path) -> None:
    text = SWEEP.partition("zip:")[0]
    found = problems(tmp_path, text + "study: {search: {}, objectives: []}\n")
    assert any("keep one of `study:` and `design:`" in problem.message for problem in found)
