"""A candidate of a study: ordinary trials, or a reason why it cannot walk."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.errors import WrongValue
from gaitlab.experiment import Experiment, candidate
from gaitlab.experiment.plan import plan
from tests.written import read

BASE = """\
robot: eros
gait: {type: ./my_gait.py, step_height: 0.02, step_length: 0.04}
surfaces: [grass_50mm, carpet_4mm]
seeds: 3
"""
VALUES = {"gait.step_length": 0.1, "gait.areas": 4, "robot.sole.kind": "studs"}
GRID = "grid: {gait.step_length: [0.1], gait.areas: [4], robot.sole.kind: [studs]}\n"


def ids(experiment: Experiment) -> list[tuple[str, str, int]]:
    trials = [planned.trial for planned in plan(experiment).trials()]
    return [(trial.id, trial.names.surface, trial.seed) for trial in trials]


def test_its_trials_are_those_of_a_grid_of_one_cell(tmp_path: Path) -> None:
    walked = candidate(read(tmp_path, BASE), VALUES)
    assert ids(walked) == ids(read(tmp_path, BASE + GRID))
    assert len(ids(walked)) == 2 * 3


def test_a_whole_number_for_a_length_is_the_same_trial(tmp_path: Path) -> None:
    base = read(tmp_path, BASE)
    assert ids(candidate(base, {"gait.step_length": 0})) == ids(
        candidate(base, {"gait.step_length": 0.0})
    )


def test_a_parameter_that_is_left_out_keeps_its_base(tmp_path: Path) -> None:
    base = read(tmp_path, BASE)
    assert ids(candidate(base, {})) == ids(base)
    assert ids(candidate(base, {"gait.step_length": 0.04})) == ids(base)


def test_other_values_are_another_experiment(tmp_path: Path) -> None:
    base = read(tmp_path, BASE)
    digests = {candidate(base, {"gait.step_length": x}).digest for x in (0.02, 0.03, 0.02)}
    assert len(digests) == 2
    assert candidate(base, {}).study is None


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"gait.step_height": 0.1, "gait.hip_height": 0.1}, "reaches the hip"),
        ({"gait.step_height": 0.9}, "allowed is a number from 0 to 0.2 m"),
        ({"gait.areas": 2.5}, "allowed is a whole number"),
        ({"gait.step_hight": 0.02}, "did you mean 'gait.step_height'"),
        ({"surface.toe_katch": 1.0}, "did you mean .surface.toe_catch"),
    ],
)
def test_what_cannot_walk_is_refused_with_its_reason(tmp_path, values, words) -> None:
    with pytest.raises(WrongValue, match=words):
        candidate(read(tmp_path, BASE), values)
