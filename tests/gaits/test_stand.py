"""Standing: nothing moves, and it is the pose in which the walks of the shipped robots start."""

from __future__ import annotations

from dataclasses import fields
from math import inf
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.eros import Gait as Walk
from gaitlab.gaits.stand import Gait
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import SHAPES, first_step
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
from tests.trials import trial

GROUNDS = "surfaces: [hard_floor]\nseeds: 1\nhorizon: {cycles: 1, time: 0.3}\n"
WALK = "robot: eros\ngait: {type: eros, hip_height: 0.22, com_offset: -0.01, trunk_pitch: 0.05}\n"


def first_trials(experiment: Experiment) -> dict[str, Trial]:
    found: dict[str, Trial] = {}
    for item in plan(experiment).trials():
        found.setdefault(str(item.values["robot"]), item.trial)
    return found


def standing(folder: Path, gait: str, base: str = WALK) -> Experiment:
    (folder / "base.yaml").write_text(base)
    file = folder / "standing.yaml"
    file.write_text(f"include: base.yaml\ngait: {gait}\n{GROUNDS}")
    return load_experiment(file)


def test_it_means_the_same_at_all_instants_and_never_a_step() -> None:
    feet = Gait(trunk_pitch=0.1, com_offset=0.01).feet(np.linspace(0.0, 20.0, 300))
    for name in SHAPES:
        array = getattr(feet, name)
        assert np.array_equal(array, np.broadcast_to(array[:1], array.shape), equal_nan=True)
    assert first_step(feet) == inf
    assert not feet.swing.any()


def test_every_robot_stands_in_the_pose_and_on_the_servos_of_its_walk() -> None:
    walks, stands = (first_trials(load_experiment(name)) for name in ("all_robots", "standing"))
    stands["biped_on_gantry"] = next(plan(load_experiment("standing_gantry")).trials()).trial
    assert walks.keys() == stands.keys()
    for name, walk in walks.items():
        stand = stands[name]
        same = ("robot", "servos", "engine", "spread", "surface")
        assert all(getattr(walk, part) == getattr(stand, part) for part in same), name
        feet = [each.gait.feet(np.zeros(1)) for each in (walk, stand)]
        assert np.abs(feet[0].position - feet[1].position).max() < 1e-11, name
        joints = [joint_commands(walk.robot, each) for each in feet]
        assert np.abs(joints[0] - joints[1]).max() < 1e-10, name


def test_it_takes_its_pose_from_the_walk_below_or_the_one_named(tmp_path: Path) -> None:
    wanted = {"hip_height": 0.22, "com_offset": -0.01, "trunk_pitch": 0.05}
    taken = standing(tmp_path, "stand").parts.gait
    assert {name: getattr(taken, name) for name in wanted} == wanted
    (tmp_path / "walk.yaml").write_text(WALK + GROUNDS)
    assert load_experiment(tmp_path / "walk.yaml", ["gait=stand"]).parts.gait == taken
    named = standing(tmp_path, "{type: stand, walk: flow, step_width: 0.1}").parts.gait
    assert (named.hip_height, named.step_width) == (0.487, 0.1)


def test_a_walk_that_starts_otherwise_is_refused_where_it_is_named(tmp_path: Path) -> None:
    text = "{type: stand, walk: {type: keyframes, motion: ./lunge.yaml}}"
    (tmp_path / "lunge.yaml").write_text("name: lunge\n")
    with pytest.raises(FileError):
        standing(tmp_path, text)
    with pytest.raises(FileError, match=r"standing\.yaml:2"):
        standing(tmp_path, "{type: stand, walk: trott}")


def test_pose_of_a_walk_is_recovered_to_the_last_digit_kept() -> None:
    walk = Walk(hip_height=0.231, step_width=0.08, com_offset=0.0123, trunk_pitch=0.31)
    pose = Gait.of(walk)
    assert pose.keys() <= {item.name for item in fields(Gait)}
    assert pose == {name: getattr(walk, name) for name in pose}


def test_its_log_knows_of_no_step_and_that_of_a_walk_of_the_first(tmp_path: Path) -> None:
    (stand,) = (item.trial for item in plan(standing(tmp_path, "stand")).trials())
    assert simulate(stand).header.first_step_time == inf
    walk = trial(cycles=0.1, stand_time=0.1, tick_increment=0.5)
    assert simulate(walk).header.first_step_time == pytest.approx(0.1)
