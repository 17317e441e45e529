"""The biped on belts: its tree, what it refuses, and how it stands and walks in real Bullet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.gaits.biped import Gait
from gaitlab.gaits.biped_bent_knee import Gait as BentKnee
from gaitlab.kinematics.belt_leg import ankle_position
from gaitlab.log import TrialLog
from gaitlab.metrics import lookup
from gaitlab.model import Joint, couplings_of, gantry_of
from gaitlab.model import Robot as RobotProtocol
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import Gait as GaitProtocol
from gaitlab.model.limbs import branches, end_pose
from gaitlab.model.settings import EngineSettings, Horizon
from gaitlab.parameters import get_path, parameters
from gaitlab.robots.biped import Robot
from gaitlab.servos.files import load_servo
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Names, Trial, plugin
from gaitlab.surfaces.files import load_surface
from tests.trials import STILL

ROBOT = Robot()
PROTOCOL: RobotProtocol = ROBOT
FREE = tuple(
    Joint(name=name, axis="-y", lower=-4.0, upper=4.0, servo=None) for name in ("hip", "knee")
)
QUICK = {"gait_period": 1.6, "stand_time": 0.2}  # s; keeps a walk in Bullet short


def planned(gait: GaitProtocol, robot: Robot | None = None, **engine: float) -> Trial:
    """Three quarters of a cycle on the hard floor."""
    robot, name = robot or Robot(), "biped_bent_knee" if isinstance(gait, BentKnee) else "biped"
    return Trial(
        robot=robot,
        gait=gait,
        surface=load_surface("hard_floor"),
        servos=(load_servo("biped_motor"),) * 4,
        engine=EngineSettings(**({"dt": 0.001} | engine)),
        horizon=Horizon(cycles=0.75),
        spread=STILL,
        seed=0,
        names=Names(robot="biped", gait=name, surface="hard_floor"),
        robot_code=plugin("robot", "biped"),
        gait_code=plugin("gait", name),
    )


def walk(gait: GaitProtocol, robot: Robot | None = None, **engine: float) -> TrialLog:
    """That walk, after a journey as plain data as to a worker."""
    return simulate(Trial.from_dict(planned(gait, robot, **engine).to_dict()))


@pytest.fixture(scope="module")
def straight() -> TrialLog:
    return walk(Gait(full_strides=1, **QUICK))


def figure(name: str, log: TrialLog) -> float:
    return float(lookup(name)(log))


def test_only_hips_and_knees_have_motors() -> None:
    joints = [joint.name for joint in ROBOT.tree.joints]
    driven = [name for name, motor in zip(joints, ROBOT.tree.driven, strict=True) if motor]
    assert driven == ["left_hip", "left_knee", "right_hip", "right_knee"]
    assert {c.follower for c in couplings_of(ROBOT)} == set(joints) - set(driven)
    assert gantry_of(ROBOT) == "level"
    assert ROBOT.tree.mass == pytest.approx(12.0, abs=1e-12)


def test_belts_make_the_knee_the_absolute_angle_and_keep_the_sole_level() -> None:
    random = np.random.default_rng(3)
    angles = random.uniform(-0.8, 0.8, (200, 2, 2))
    legs = [np.stack([a[:, 0], -a[:, 0], a[:, 1], -a[:, 1]], -1) for a in np.moveaxis(angles, 1, 0)]
    poses = ROBOT.tree.poses(
        np.zeros((200, 3)), np.tile(np.eye(3), (200, 1, 1)), np.concatenate(legs, axis=1)
    )
    for index, foot in enumerate(ROBOT.feet):
        link = ROBOT.tree.index(foot)
        level = np.tile(np.eye(3), (200, 1, 1))
        np.testing.assert_allclose(poses.rotation[:, link], level, atol=1e-14)
        ankle = ankle_position(angles[:, index], 0.3)
        np.testing.assert_allclose(poses.position[:, link][:, [0, 2]], ankle, atol=1e-14)


@pytest.mark.parametrize("gait", [Gait(), BentKnee(), Gait(step_length=0.35, step_height=0.08)])
def test_the_robot_takes_every_pose_of_its_gaits(gait: GaitProtocol) -> None:
    feet = gait.feet(np.linspace(0.0, 12.0, 3001))
    targets = joint_commands(ROBOT, feet)
    np.testing.assert_allclose(targets[:, 1::2], -targets[:, ::2], atol=1e-6)
    poses = ROBOT.tree.poses(np.zeros((3001, 3)), np.tile(np.eye(3), (3001, 1, 1)), targets)
    for index, foot in enumerate(ROBOT.feet):
        sole = poses.position[:, ROBOT.tree.index(foot)] - [0.0, 0.0, ROBOT.sole.height]
        np.testing.assert_allclose(sole, feet.position[:, index], atol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"segment": 0.25}, "out of|farther|other lengths"),
        ({"ankle_height": 0.02}, "gait.ankle_height to 0.05 m"),
        ({"step_width": 0.3}, "set gait.step_width to robot.hip_spacing"),
    ],
)
def test_a_gait_for_another_robot_is_refused_with_what_to_set(change: dict, words: str) -> None:
    with pytest.raises(Infeasible, match=words):
        joint_commands(ROBOT, replace(Gait(), **change).feet(np.linspace(0.0, 3.0, 301)))


@pytest.mark.parametrize("field", ["heading", "ankle_pitch", "trunk_pitch"])
def test_what_the_belts_cannot_do_is_refused(field: str) -> None:
    feet = Gait().feet(np.linspace(0.0, 3.0, 301))
    turned = getattr(feet, field).copy()
    turned[200] = 0.1
    with pytest.raises(Infeasible, match="keep the sole parallel to the trunk") as caught:
        ROBOT.joint_targets(replace(feet, **{field: turned}))
    assert caught.value.tick == 200


def test_hips_lower_than_the_knees_can_bend_are_refused() -> None:
    with pytest.raises(Infeasible, match="left_hip would have to turn"):
        joint_commands(ROBOT, BentKnee(hip_height=0.20).feet(np.zeros(1)))
    with pytest.raises(Infeasible, match=r"farther from the hip than 0\.6 m"):
        joint_commands(ROBOT, BentKnee(hip_height=0.66).feet(np.zeros(1)))


def test_the_published_walk_ends_upright_where_it_should_on_its_gantry(straight) -> None:
    assert straight.fall_index is None
    advance = straight["trunk_x"][-1] - straight["trunk_x"][0]
    assert advance == pytest.approx(0.4, abs=0.03)
    assert straight["trunk_z"][-1] == pytest.approx(0.65, abs=0.005)
    assert np.abs(straight["pitch"]).max() < np.radians(0.1)
    for column in ("roll", "yaw", "trunk_y"):
        assert np.abs(straight[column]).max() < 1e-6


def test_belts_give_way_by_less_than_a_fifth_of_a_degree_even_at_a_quick_pace(straight) -> None:
    assert figure("coupling_residual", straight) < np.radians(0.2)
    assert figure("sole_penetration", straight) < 2e-4


def test_the_motors_carry_no_more_than_they_have_and_the_idlers_nothing(straight) -> None:
    header = straight.header
    assert header.joints[-1] == "gantry_pitch"
    for name, limit in zip(header.joints[:-1], header.torque_limits[:-1], strict=True):
        assert np.abs(straight[f"{name}_torque"]).max() <= limit * 1.001 + 1e-6


def test_the_gantry_supplies_the_moment_that_the_ground_does_not(straight) -> None:
    """Moments about the centre of mass: load and friction at the soles, the rig."""
    friction = straight.per_foot("force_x").sum(axis=1)
    load = straight.per_foot("normal_force").sum(axis=1)
    missing = (straight["zmp_x"] - straight["com_x"]) * load + straight["com_z"] * friction
    supplied = straight["gantry_pitch_torque"]
    means = [q[: len(q) // 50 * 50].reshape(-1, 50).mean(axis=1) for q in (missing, supplied)]
    known = np.isfinite(means[0])
    assert known.sum() > 20
    # The legs' own swing is what the two differ by.
    assert np.corrcoef(means[0][known], means[1][known])[0, 1] > 0.95


@pytest.mark.long
def test_more_solver_iterations_change_the_work_by_less_than_five_percent(straight) -> None:
    finer = walk(Gait(full_strides=1, **QUICK), solver_iterations=200)
    assert figure("energy", finer) == pytest.approx(figure("energy", straight), rel=0.05)


@pytest.mark.long
def test_an_idler_that_never_turns_may_have_any_inertia(straight, monkeypatch) -> None:
    monkeypatch.setattr("gaitlab.robots.biped.IDLER_INERTIA", 2e-2)
    heavy = walk(Gait(full_strides=1, **QUICK))
    # Servos predict their speed as if belts were loose, so that the idler enters their lag: 5.6 %.
    assert figure("energy", heavy) == pytest.approx(figure("energy", straight), rel=0.08)


@pytest.mark.parametrize("gantry", ["planar", "none"])
def test_without_a_level_gantry_it_tips_over_its_toes(gantry: str) -> None:
    log = walk(Gait(full_strides=1, gait_period=4.0, stand_time=0.2), Robot(gantry=gantry))
    assert log.fall_index is not None
    assert log["pitch"][-1] > 0.4
    assert ("gantry_pitch_torque" in log.arrays) == (gantry == "planar")


def test_bent_knees_keep_the_hips_level_in_bullet() -> None:
    log = walk(BentKnee(**QUICK))
    assert log.fall_index is None
    assert np.ptp(log["trunk_z"][log.walking]) < 0.012
    assert figure("slip_ratio", log) == pytest.approx(1.0, abs=0.05)


def test_a_leg_reaches_a_point_with_its_knee_on_either_side() -> None:
    leg = ROBOT.limbs()["right_leg"]
    assert [joint.name for joint in leg.joints] == ["right_hip", "right_knee"]
    for target in np.random.default_rng(6).uniform([-0.2, 0.0, -0.6], [0.2, 0.0, -0.4], (50, 3)):
        ways = branches(leg, target)
        assert len(ways) == 2
        for way in ways:
            pose = end_pose(replace(leg, joints=FREE), way.joints)
            np.testing.assert_allclose(pose[:3, 3], target, atol=1e-9)
            np.testing.assert_array_equal(pose[:3, :3], np.eye(3))


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ((0.0, 0.0, -0.7), r"0\.6500 m from the hip, the leg reaches 0\.6000 m"),
        ((0.0, 0.1, -0.5), "moves in the plane y = 0"),
        ((0.0, float("nan"), -0.5), "target"),
    ],
)
def test_a_point_that_no_leg_reaches_is_refused_in_words(target: tuple, words: str) -> None:
    with pytest.raises(WrongValue, match=words):
        branches(ROBOT.limbs()["left_leg"], target)


def test_every_parameter_says_where_its_default_comes_from() -> None:
    for parameter in parameters(Robot):
        assert parameter.source.startswith("assumption"), parameter.name
        assert get_path(Robot(), parameter.name) == parameter.default


def test_the_gantry_is_part_of_what_makes_a_trial() -> None:
    ids = set()
    for gantry in ("level", "planar", "none"):
        trial = planned(Gait(), Robot(gantry=gantry))
        ids.add(trial.id)
        assert trial.to_dict()["robot"]["values"]["gantry"] == gantry
    assert len(ids) == 3
