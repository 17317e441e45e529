"""FLoW as a tree of links: its size, its agreement with the closed forms and with Bullet."""

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
import pybullet
import pytest
from pybullet_utils.bullet_client import BulletClient

from gaitlab.errors import Infeasible
from gaitlab.kinematics.parallelogram import parallelogram_joints
from gaitlab.kinematics.transforms import axis_rotation, rotation_of
from gaitlab.model import Robot as RobotProtocol
from gaitlab.model.gait import FeetPoses
from gaitlab.model.urdf import urdf
from gaitlab.parameters import parameters
from gaitlab.robots.flow import Robot
from gaitlab.servos.files import load_servo

POSITION = 1e-6  # m and -, Bullet's joint angles are exact, its poses nearly so
SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")
ROBOT: RobotProtocol = Robot()
EVERY_MODEL = [
    Robot(),
    Robot(parallelogram="geared"),
    Robot(arm_joints=6),
    Robot(arm_joints=7, parallelogram="geared"),
]
every_model = pytest.mark.parametrize("robot", EVERY_MODEL, ids=["25", "27", "27 wrist", "31"])


def feet_poses(n: int, **changes: np.ndarray) -> FeetPoses:
    """Soles level near their place 490 mm below the hips, unless changed."""
    spread = np.random.default_rng(31).uniform(-0.04, 0.04, size=(n, 2, 3))
    still = FeetPoses(
        position=np.array([[0.0, 0.085, -0.47], [0.0, -0.085, -0.47]]) + spread,
        heading=np.zeros((n, 2)),
        trunk_pitch=np.zeros(n),
        ankle_pitch=np.zeros((n, 2)),
        knee_only=np.zeros((n, 2)),
        swing=np.zeros((n, 2), dtype=bool),
        phase=np.full(n, np.nan),
        step_index=np.full(n, -1),
    )
    return dataclasses.replace(still, **changes)


def upright(n: int) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))


@pytest.fixture
def client() -> Iterator[BulletClient]:
    client = BulletClient(pybullet.DIRECT)
    yield client
    client.disconnect()


def test_it_has_25_joints_of_which_23_are_independent() -> None:
    assert len(Robot().tree.joints) == 25
    geared = Robot(parallelogram="geared")
    assert sum(geared.tree.driven) == 23
    assert len(geared.couplings) == len(geared.tree.joints) - 23
    assert [len(Robot(arm_joints=count).tree.joints) for count in (6, 7)] == [27, 29]


@every_model
def test_it_stands_1100_mm_tall_and_weighs_what_is_published(robot: Robot) -> None:
    straight = np.zeros((1, len(robot.tree.joints)))
    poses = robot.tree.poses(*upright(1), straight)
    head, foot = (poses.position[0, robot.tree.index(name), 2] for name in ("head", "left_foot"))
    top = head + robot.torso.eyes + robot.torso.crown
    assert top - (foot - robot.sole.height) == pytest.approx(1.100, abs=1e-12)
    assert robot.tree.mass == pytest.approx(12.5, abs=1e-12)


@every_model
def test_every_servo_is_known(robot: Robot) -> None:
    for joint in robot.tree.joints:
        assert joint.servo is None or load_servo(joint.servo).stall_torque > 1.0


def test_the_rods_follow_as_fast_and_as_late_as_the_servos_above_them() -> None:
    pair, rods = load_servo("mx_106_pair"), load_servo("parallelogram_rods")
    for name in ("no_load_speed", "position_gain", "latency", "supply", "voltage"):
        assert getattr(pair, name) == getattr(rods, name), name


@every_model
def test_limbs_end_where_the_tree_ends(robot: Robot) -> None:
    tree, n = robot.tree, 100
    chosen = np.random.default_rng(32).uniform(-1.2, 1.2, size=(n, len(tree.joints)))
    column = {joint.name: k for k, joint in enumerate(tree.joints)}
    for side in SIDES:  # plates have no freedom of their own
        for plate, upper in (("knee_plate", "hip_pitch"), ("ankle_pitch", "shank_pitch")):
            if f"{side}_knee_plate" in column:
                chosen[:, column[f"{side}_{plate}"]] = -chosen[:, column[f"{side}_{upper}"]]
    chosen[:, column["waist_yaw"]] = 0.0
    poses, limbs = tree.poses(*upright(n), chosen), robot.limbs()
    torso, shoulder = robot.torso, robot.torso.waist_height + robot.torso.shoulder_height
    last = {5: ("hand", robot.arm.forearm), 6: ("wrist", 0.06), 7: ("palm", 0.06)}
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        name, length = last[robot.arm_joints]
        ends = {
            f"{side}_leg": (f"{side}_foot", robot.sole.height, [0.0, 0.0, 0.0]),
            f"{side}_arm": (f"{side}_{name}", length, [0.0, sign * robot.arm.spacing, shoulder]),
            "head": ("head", -torso.eyes, [0.0, 0.0, shoulder + torso.neck_height]),
        }
        for limb, (link, drop, base) in ends.items():
            at = tree.index(link)
            end = poses.position[:, at] - drop * poses.rotation[:, at, :, 2]
            for row in range(n):
                joints = _angles(robot, limbs[limb].joints, chosen[row], column)
                found = limbs[limb].forward(joints)[:3, 3] + base
                np.testing.assert_allclose(found, end[row], atol=1e-12)


def _angles(robot: Robot, joints: tuple, row: np.ndarray, column: dict[str, int]) -> np.ndarray:
    """Joints of a limb; a geared leg's knee is the shank's angle from the thigh's."""
    values = []
    for joint in joints:
        if joint.name in column:
            values.append(row[column[joint.name]])
        else:
            side = joint.name.partition("_")[0]
            thigh, shank = (row[column[f"{side}_{name}"]] for name in ("hip_pitch", "shank_pitch"))
            values.append(shank - thigh)
    return np.array(values)


@every_model
def test_links_in_bullet_are_where_the_tree_has_them(
    robot: Robot, client: BulletClient, tmp_path: Path
) -> None:
    file = tmp_path / "flow.urdf"
    file.write_text(urdf(robot.tree, robot.sole, robot.feet))
    body = client.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE, useFixedBase=True)
    info = [client.getJointInfo(body, k) for k in range(client.getNumJoints(body))]
    angles = np.random.default_rng(33).uniform(-1.5, 1.5, size=len(robot.tree.joints))
    wanted = dict(zip((joint.name for joint in robot.tree.joints), angles, strict=True))
    for k, row in enumerate(info):
        client.resetJointState(body, k, wanted[row[1].decode()])
    poses = robot.tree.poses(*upright(1), angles[None])
    for k, row in enumerate(info):
        position, quaternion = client.getLinkState(body, k, computeForwardKinematics=True)[4:6]
        at = robot.tree.index(row[12].decode())
        np.testing.assert_allclose(position, poses.position[0, at], atol=POSITION)
        np.testing.assert_allclose(
            rotation_of(np.array(quaternion)), poses.rotation[0, at], atol=POSITION
        )


@every_model
def test_feet_go_where_they_are_told_level_with_the_pelvis(robot: Robot) -> None:
    heading = np.random.default_rng(34).uniform(-0.3, 0.3, size=(500, 2))
    feet = feet_poses(500, heading=heading)
    poses = robot.tree.poses(*upright(500), robot.joint_targets(feet))
    for k, name in enumerate(robot.feet):
        at = robot.tree.index(name)
        np.testing.assert_allclose(
            poses.rotation[:, at], axis_rotation("z", heading[:, k]), atol=1e-9
        )
        sole = poses.position[:, at] - [0.0, 0.0, robot.sole.height]
        wanted = feet.position[:, k] - [0.0, 0.0, robot.hip_offset()]
        np.testing.assert_allclose(sole, wanted, atol=1e-9)


def test_serial_and_geared_legs_are_sent_the_same_angles() -> None:
    feet = feet_poses(50)
    serial, geared = (
        Robot(parallelogram=model).joint_targets(feet)[:, : 6 + extra]
        for model, extra in (("serial", 0), ("geared", 1))
    )
    free = parallelogram_joints(serial)
    np.testing.assert_allclose(geared[:, [0, 1, 2, 4, 6]], free, atol=1e-12)
    np.testing.assert_allclose(geared[:, [3, 5]], -free[:, 2:4], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("trunk_pitch", np.array([0.0, 0.1])),
        ("ankle_pitch", np.array([[0.0, 0.0], [0.0, -0.1]])),
        ("knee_only", np.array([[0.0, 0.0], [0.5, 0.0]])),
    ],
)
def test_a_sole_pitched_against_the_pelvis_is_infeasible(name: str, value: np.ndarray) -> None:
    with pytest.raises(Infeasible, match="parallelograms keep the sole parallel") as caught:
        ROBOT.joint_targets(feet_poses(2, **{name: value}))
    assert caught.value.tick == 1
    assert name in caught.value.reason


def test_a_foot_out_of_reach_is_infeasible() -> None:
    feet = feet_poses(3)
    feet.position[1:, 1, 2] = -0.6
    with pytest.raises(Infeasible, match="the leg spans") as caught:
        ROBOT.joint_targets(feet)
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 1)


def test_every_parameter_says_where_its_default_comes_from() -> None:
    for item in parameters(Robot):
        assert item.source.startswith(("assumption", "published", "reconstruction")), item.name
