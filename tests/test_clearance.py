"""Two lower legs never pass through each other: the gap, what is commanded, and what is walked."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.errors import FileError, Infeasible, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import GRAVITY
from gaitlab.metrics import measure
from gaitlab.model import LinkPoses
from gaitlab.model.clearance import (
    _commanded_gaps,
    _separation,
    _smallest_gap,
    legs_beside,
    legs_gap,
    links_apart,
    lower_legs,
    require_apart,
    require_own_space,
    shape_of,
)
from gaitlab.model.commands import joint_commands
from gaitlab.model.settings import EngineName, Spread
from gaitlab.plugins import locate, names
from gaitlab.robots.eros import Robot
from gaitlab.running.run_trial import run_trial
from gaitlab.simulation.simulate import engine_for, simulate
from tests.driven import each_engine, hold
from tests.trials import trial as eros


def _gap(apart: np.ndarray, ra: np.ndarray, a: np.ndarray, rb: np.ndarray, b: np.ndarray) -> float:
    """Gap of two boxes, looked for to the end."""
    return float(_separation(apart, ra, a, rb, b, np.inf, np.empty((3, 3))))


lengths = st.floats(0.01, 0.3)
halves = st.tuples(lengths, lengths, lengths)
places = st.tuples(*[st.floats(-0.8, 0.8)] * 3)
turns = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


def is_experiment(name: str) -> bool:
    """Whether a file of the experiments lists trials: no study, no reproduction."""
    text = locate("experiment", name).read_text()
    return "\nstudy:" not in text and "\nreproduction:" not in text


ROBOTS = {
    planned.trial.robot.name: planned.trial
    for planned in plan(load_experiment("all_robots", ["seeds=1"])).trials()
}


def turned(q: tuple[float, ...]) -> np.ndarray:
    return np.ascontiguousarray(rotation_of(np.array(q) / np.linalg.norm(q)))


@given(places, turns, halves, turns, halves, turns)
def test_a_gap_is_the_same_from_both_sides_and_from_anywhere(
    apart: tuple[float, ...],
    qa: tuple[float, ...],
    a: tuple[float, ...],
    qb: tuple[float, ...],
    b: tuple[float, ...],
    q: tuple[float, ...],
) -> None:
    ra, rb, moved, d = turned(qa), turned(qb), turned(q), np.array(apart)
    half_a, half_b = np.array(a), np.array(b)
    gap = _gap(d, ra, half_a, rb, half_b)
    assert gap == pytest.approx(_gap(-d, rb, half_b, ra, half_a), abs=1e-9)
    assert gap == pytest.approx(_gap(moved @ d, moved @ ra, half_a, moved @ rb, half_b), abs=1e-7)


@settings(deadline=None)
@given(places, turns, halves, turns, halves, st.integers(0, 1000))
def test_a_gap_never_exceeds_the_distance_of_any_two_points(
    apart: tuple[float, ...],
    qa: tuple[float, ...],
    a: tuple[float, ...],
    qb: tuple[float, ...],
    b: tuple[float, ...],
    seed: int,
) -> None:
    rng, ra, rb = np.random.default_rng(seed), turned(qa), turned(qb)
    half_a, half_b, d = np.array(a), np.array(b), np.array(apart)
    first = rng.uniform(-1.0, 1.0, (200, 3)) * half_a @ ra.T
    second = d + rng.uniform(-1.0, 1.0, (200, 3)) * half_b @ rb.T
    nearest = np.linalg.norm(first[:, None] - second, axis=-1).min()
    assert _gap(d, ra, half_a, rb, half_b) <= nearest + 1e-12


@given(st.floats(-0.5, 0.5), halves, halves)
def test_faces_that_lie_opposite_are_as_far_apart_as_they_are(
    y: float, a: tuple[float, ...], b: tuple[float, ...]
) -> None:
    level = np.eye(3)
    gap = _gap(np.array([0.0, y, 0.0]), level, np.array(a), level, np.array(b))
    others = -min(a[0] + b[0], a[2] + b[2])
    assert gap == pytest.approx(max(abs(y) - a[1] - b[1], others))


@pytest.mark.parametrize("name", ROBOTS)
def test_links_and_gaps_are_the_same_when_no_more_than_is_needed_is_looked_at(name: str) -> None:
    """Links that carry none of the wanted ones are left out, and gaps of `most` and more."""
    robot, n, most = ROBOTS[name].robot, 300, 0.02
    left, right = lower_legs(robot)
    joints = np.random.default_rng(3).normal(size=(n, len(robot.tree.joints))) * 0.3
    upright = np.zeros((n, 3)), np.broadcast_to(np.eye(3), (n, 3, 3)), joints
    every, few = robot.tree.poses(*upright), robot.tree.poses(*upright, wanted=left + right)
    for whole, part in zip(every, few, strict=True):
        np.testing.assert_array_equal(whole[:, left + right], part[:, left + right])
    gaps = legs_gap(robot, every)
    assert np.any(gaps < 0.0) or name == "biped"
    np.testing.assert_array_equal(gaps, legs_gap(robot, few))
    below = _smallest_gap(robot, few, left, right, most)
    np.testing.assert_array_equal(below < -1e-6, gaps < -1e-6)
    np.testing.assert_array_equal(below[below < 0.0], gaps[below < 0.0])
    assert np.all(below <= most)


@pytest.mark.parametrize("name", ROBOTS)
def test_lower_legs_mirror_each_other_and_end_in_the_feet(name: str) -> None:
    robot = ROBOTS[name].robot
    left, right = lower_legs(robot)
    assert len(left) == len(right) >= 2
    named = [{robot.tree.links[k].name for k in leg} for leg in (left, right)]
    assert {name.replace("left", "right") for name in named[0]} == named[1]
    assert robot.feet[0] in named[0]
    assert robot.feet[1] in named[1]


@pytest.mark.parametrize("name", names("robot"))
def test_every_shipped_robot_stands_with_its_legs_apart(name: str) -> None:
    require_own_space(ROBOTS[name].robot)


def test_a_robot_whose_feet_overlap_is_refused_with_the_depth() -> None:
    robot = Robot()
    wide = replace(robot, sole=replace(robot.sole, width=0.120, outward=0.0))
    with pytest.raises(WrongValue, match=r"36\.0 mm"):
        require_own_space(wide)


def test_the_file_of_such_a_robot_is_refused_before_anything_runs(tmp_path: Path) -> None:
    file = tmp_path / "wide.yaml"
    file.write_text(
        "name: wide\nrobot: {type: eros, sole: {width: 0.12, outward: 0.0}}\ngait: eros\n"
        "surfaces: [hard_floor]\nseeds: 1\n"
    )
    with pytest.raises(FileError, match=r"36\.0 mm") as refused:
        load_experiment(str(file))
    assert refused.value.problems[0].line == 2


@pytest.mark.parametrize(("width", "fits"), [(0.084, True), (0.0551, True), (0.0540, False)])
def test_a_narrow_step_is_infeasible_where_soles_would_overlap(width: float, fits: bool) -> None:
    """Soles are 80 mm wide and 12.5 mm outside: they meet at 55 mm between the ankles."""
    trial = eros("hard_floor", step_width=width)
    targets = joint_commands(trial.robot, trial.gait.feet(np.arange(1000) * 0.002))
    if fits:
        require_apart(trial.robot, targets, 0.002)
        return
    with pytest.raises(Infeasible, match=r"1\.0 mm") as refused:
        require_apart(trial.robot, targets, 0.002)
    assert refused.value.tick == 0
    assert "step_width" in refused.value.reason


def test_such_a_trial_ends_infeasible_and_nothing_is_simulated(tmp_path: Path) -> None:
    trial = eros("hard_floor", step_width=0.05)
    record = run_trial(trial.id, trial.to_dict(), tmp_path)
    assert record.state == "INFEASIBLE"
    assert "overlap" in record.reason


@each_engine
def test_legs_that_are_pressed_together_touch_and_do_not_pass(engine: EngineName) -> None:
    trial = eros("hard_floor", spread=Spread(tilt=0.0), engine={"name": engine})
    feet = trial.gait.feet(np.zeros(1))
    target = joint_commands(trial.robot, feet)[0]
    names_of = [joint.name for joint in trial.robot.tree.joints]
    target[names_of.index("left_hip_roll")], target[names_of.index("right_hip_roll")] = -0.3, 0.3
    with engine_for(trial, feet) as made:
        made.pull((0.0, 0.0, 1.01 * GRAVITY * trial.robot.tree.mass))  # hung up
        tape = hold(made, target, 300)
    assert tape.contacts.tick.max(initial=0) < 299  # legs that touch are not on the ground
    flat = np.zeros((300, 3)), np.tile(np.eye(3), (300, 1, 1))
    gaps = legs_gap(trial.robot, trial.robot.tree.poses(*flat, tape.joints[:, 0]))
    wanted = trial.robot.tree.poses(np.zeros((1, 3)), np.eye(3)[None], target[None])
    assert legs_gap(trial.robot, wanted)[0] < -0.02  # m, where the servos pull to
    assert min(gaps) > -5e-3  # m, the way of two ticks at the speed of the blow
    assert -1e-3 < gaps[-1] < 5e-4


@each_engine
def test_with_self_collision_a_robot_stands_as_it_did_without(engine: EngineName) -> None:
    """No two links that belong together push each other away."""
    logs = []
    for every in (False, True):
        still = Spread(tilt=0.0)
        trial = eros("hard_floor", stand_time=0.3, spread=still, engine={"name": engine})
        trial = replace(trial, robot=replace(trial.robot, self_collision=every))
        logs.append(simulate(replace(trial, horizon=replace(trial.horizon, time=0.1))))
    np.testing.assert_allclose(logs[0]["trunk_z"], logs[1]["trunk_z"], atol=2e-3)


@each_engine
def test_only_with_self_collision_an_arm_does_not_pass_through_the_body(engine: EngineName) -> None:
    deepest = []
    for every in (False, True):
        trial = eros("hard_floor", spread=Spread(tilt=0.0), engine={"name": engine})
        robot = replace(trial.robot, self_collision=every)
        feet = trial.gait.feet(np.zeros(1))
        target = joint_commands(robot, feet)[0]
        joints = [joint.name for joint in robot.tree.joints]
        target[joints.index("left_shoulder_pitch")] = 0.0
        target[joints.index("left_shoulder_roll")] = -0.26
        target[joints.index("left_elbow")] = 0.0
        with engine_for(replace(trial, robot=robot), feet) as made:
            now = hold(made, target, 300).joints[-1:, 0]
        poses = robot.tree.poses(np.zeros((1, 3)), np.eye(3)[None], now)
        arms = [k for k, link in enumerate(robot.tree.links) if link.name.startswith("left_fore")]
        deepest.append(
            min(
                gap_of(robot, poses, a, b)
                for a, b in links_apart(robot, np.zeros(len(robot.tree.joints)))
                if a in arms or b in arms
            )
        )
    assert deepest[0] < -5e-3
    assert deepest[1] > -2e-3


def gap_of(robot: Robot, poses: LinkPoses, first: int, second: int) -> float:
    """Gap of two links of a robot at the first instant, in [m]."""
    places = []
    for k in (first, second):
        box, turn = shape_of(robot, k), np.ascontiguousarray(poses.rotation[0, k])
        places.append((poses.position[0, k] + turn @ np.array(box.centre), turn, box.size))
    (pa, ra, a), (pb, rb, b) = places
    return float(_gap(pb - pa, ra, 0.5 * np.array(a), rb, 0.5 * np.array(b)))


SHIPPED = [name for name in names("experiment") if is_experiment(name)]
AS_PRINTED = "bioloid_poses"  # a paper's poses; its soles would overlap by 11 mm
MOST = 40  # walks looked at of an experiment; those of a sweep are alike


@pytest.mark.parametrize("name", SHIPPED)
def test_no_shipped_experiment_commands_an_overlap(name: str) -> None:
    """What is out of reach is commanded nothing."""
    made = plan(load_experiment(name))
    every = max(1, made.size // MOST)
    for planned in islice(made.trials(), 0, None, every):
        trial = planned.trial
        instants = np.arange(0.0, trial.gait.startup_time + trial.gait.gait_period, 0.01)
        try:
            targets = joint_commands(trial.robot, trial.gait.feet(instants))
        except Infeasible:
            continue
        if name == AS_PRINTED:
            with pytest.raises(Infeasible, match="overlap"):
                require_apart(trial.robot, targets, 0.01)
            continue
        require_apart(trial.robot, targets, 0.01)


@pytest.mark.long
@pytest.mark.parametrize("surface", ["carpet_4mm", "grass_30mm"])
def test_no_walk_of_the_quick_experiment_reaches_an_overlap(surface: str) -> None:
    experiment = load_experiment(
        "eros_quick", ["seeds=1", f"surfaces=[{surface}]", "horizon.cycles=1"]
    )
    for planned in plan(experiment).trials():
        assert measure(simulate(planned.trial))["feet_gap"] > 0.0


@pytest.mark.long
@pytest.mark.parametrize("name", ROBOTS)
def test_every_shipped_robot_walks_with_its_legs_apart(name: str) -> None:
    trial = replace(ROBOTS[name], horizon=replace(ROBOTS[name].horizon, cycles=1.0))
    assert measure(simulate(trial))["feet_gap"] > -5e-4


@settings(max_examples=60)
@given(
    pose=st.lists(st.floats(-0.4, 0.4), min_size=40, max_size=40),
    name=st.sampled_from(list(ROBOTS)),
)
def test_legs_that_a_plane_parts_do_not_overlap(pose: list[float], name: str) -> None:
    robot = ROBOTS[name].robot
    joints = np.resize(np.array(pose), len(robot.tree.joints))
    if legs_beside(robot, joints):
        assert _commanded_gaps(robot, joints[None])[0] >= 0.0
