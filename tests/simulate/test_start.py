"""Every robot on every ground begins as it is commanded: soles level, weight on them, no jump."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import GRAVITY
from gaitlab.model import Start, gantry_of
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import FeetPoses
from gaitlab.model.randomness import randomness
from gaitlab.model.settings import Spread
from gaitlab.servos.law import stiffness
from gaitlab.simulation.simulate import engine_for, start_of
from gaitlab.simulation.trial import Trial
from tests.driven import drive
from tests.trials import trial as eros

TRIALS = {
    f"{planned.trial.robot.name} on {planned.trial.names.surface}": planned.trial
    for planned in plan(load_experiment("all_robots", ["seeds=1"])).trials()
}


def feet_of(trial: Trial, ticks: int = 1) -> FeetPoses:
    return trial.gait.feet(np.arange(ticks) * trial.engine.dt)


def sole_tilts(trial: Trial, joints: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """Tilt of each sole against the ground, in [rad]. Shape (2,)."""
    tree = trial.robot.tree
    turn = rotation_of(np.asarray(quaternion))[None]
    poses = tree.poses(np.zeros((1, 3)), turn, joints[None])
    up = poses.rotation[0, [tree.index(foot) for foot in trial.robot.feet], 2, 2]
    return np.arccos(np.clip(up, -1.0, 1.0))


@pytest.mark.parametrize("name", TRIALS)
def test_soles_begin_level_and_no_force_jumps(name: str) -> None:
    trial = replace(TRIALS[name], spread=Spread(tilt=0.0))
    feet = feet_of(trial, 50)  # 0.1 s; a soft layer rocks on for longer
    targets = joint_commands(trial.robot, feet)
    with engine_for(trial, feet) as engine:
        begin = start_of(trial, feet)
        tilts = sole_tilts(trial, begin.joints, engine.trunk[3:7])
        tape = drive(engine, targets, gantry=gantry_of(trial.robot) != "none")
    contacts = tape.contacts
    loads = contacts.total(contacts.force[:, 2], len(targets))
    assert not tape.body_touches.any()  # nothing but soles, no shell
    assert np.degrees(tilts).max() < 0.1
    assert max(loads) < 1.2 * trial.robot.tree.mass * GRAVITY
    assert max(loads) > 0.5 * trial.robot.tree.mass * GRAVITY


@pytest.mark.parametrize("lean", [-0.1, 0.0, 0.0658, 0.2])
def test_a_commanded_lean_is_where_the_trunk_begins(lean: float) -> None:
    trial = eros("grass_50mm", trunk_pitch=lean, spread=Spread(tilt=0.0))
    with engine_for(trial, feet_of(trial)) as engine:
        x, y, z, w = engine.trunk[3:7]
    assert 2.0 * np.arctan2(y, w) == pytest.approx(lean, abs=1e-6)
    assert abs(x) < 1e-9
    assert abs(z) < 1e-9


@pytest.mark.parametrize("name", TRIALS)
@pytest.mark.parametrize("seed", range(5))
def test_a_replicate_leans_its_legs_and_turns_neither_trunk_nor_soles(name: str, seed: int) -> None:
    trial = replace(TRIALS[name], seed=seed)
    level = start_of(replace(trial, spread=Spread(tilt=0.0)), feet_of(trial))
    begin = start_of(replace(trial, spread=Spread(tilt=0.02)), feet_of(trial))
    assert np.degrees(sole_tilts(trial, begin.joints, begin.quaternion)).max() < 0.01
    np.testing.assert_allclose(begin.quaternion, level.quaternion, atol=1e-6)
    trunk, feet = moved_by(trial, level, begin)
    leg = trial.gait.hip_height - trial.robot.sole.height
    assert np.abs(feet - feet[0]).max() < 2e-4  # m, both feet go together
    assert np.hypot(*(trunk - feet)[0, :2]) <= 1.05 * np.hypot(0.02, 0.02) * leg


def test_a_lean_moves_the_trunk_by_the_leg_times_the_angle() -> None:
    trial = TRIALS["eros on hard_floor"]
    spread = Spread(tilt=0.01, position=0.0)
    level = start_of(replace(trial, spread=replace(spread, tilt=0.0)), feet_of(trial))
    begin = start_of(replace(trial, spread=spread), feet_of(trial))
    trunk, feet = moved_by(trial, level, begin)
    roll, pitch = 0.01 * randomness(trial.seed).pose.uniform(-1.0, 1.0, 2)
    leg = trial.gait.hip_height - trial.robot.sole.height
    expected = leg * np.array([pitch, -roll])
    np.testing.assert_allclose((trunk - feet)[0, :2], expected, rtol=0.02, atol=1e-6)


def moved_by(trial: Trial, first: Start, second: Start) -> tuple[np.ndarray, np.ndarray]:
    """By how much the trunk (3,) and each foot (2, 3) stand elsewhere, in [m]."""
    places = []
    for begin in (first, second):
        turn = rotation_of(begin.quaternion)[None]
        poses = trial.robot.tree.poses(begin.position[None], turn, begin.joints[None])
        feet = [trial.robot.tree.index(foot) for foot in trial.robot.feet]
        places.append((begin.position, poses.position[0, feet]))
    return places[1][0] - places[0][0], places[1][1] - places[0][1]


@pytest.mark.parametrize("name", [name for name in TRIALS if "hard_floor" in name])
def test_servos_begin_with_the_errors_that_carry_the_robot(name: str) -> None:
    """The virtual work of their torques on a robot that sinks is its weight's."""
    trial = replace(TRIALS[name], spread=Spread(tilt=0.0))
    robot, feet = trial.robot, feet_of(trial)
    if gantry_of(robot) != "none":
        return
    begin = start_of(trial, feet)
    springs = np.array([stiffness(servo) for servo in trial.servos])
    torques = springs * (begin.targets - begin.joints)
    sunk = robot.joint_targets(feet.moved(np.array([0.0, 0.0, 1e-4])))[0]
    work = -torques @ (sunk - robot.joint_targets(feet)[0]) / 1e-4
    assert work == pytest.approx(robot.tree.mass * GRAVITY, rel=0.1)
