import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.slanted_leg import SlantedLeg, geometric_angles
from gaitlab.kinematics.transforms import homogeneous, vector_rotation

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "nao.json").read_text())
SIDES = ("left", "right")
sides = pytest.mark.parametrize("side", SIDES)


def leg(side: str, tibia: float = 0.1029, ankle_height: float = 0.0) -> SlantedLeg:
    return SlantedLeg(thigh=0.1, tibia=tibia, ankle_height=ankle_height, side=side)


def random_joints(side: str, n: int) -> np.ndarray:
    """Within NAO's limits, away from the stretched knee."""
    roll = (-0.37, 0.78) if side == "left" else (-0.78, 0.37)
    ankle_roll = (-0.39, 0.76) if side == "left" else (-0.76, 0.39)
    limits = np.array([(-1.1, 0.7), roll, (-1.5, 0.48), (0.05, 2.1), (-1.18, 0.92), ankle_roll])
    return np.random.default_rng(7).uniform(*limits.T, size=(n, 6))


@pytest.mark.parametrize("case", GOLDEN["ik"])
def test_geometric_angles_equal_the_reference(case: dict[str, Any]) -> None:
    found = geometric_angles(np.array(case["r"], dtype=float), case["L_thigh"], case["L_tibia"])
    names = ("HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll", "A", "B", "D")
    np.testing.assert_allclose(found, [case[name] for name in names], atol=1e-8)


@sides
def test_inverse_kinematics_of_ten_thousand_poses_gives_the_pose_back(side: str) -> None:
    pose = leg(side, ankle_height=0.04519).sole_pose(random_joints(side, 10_000))
    # A sole that faces away from the hip is refused; NAO's limits allow few of them.
    facing = np.einsum("nji,nj->ni", pose[:, :3, :3], -pose[:, :3, 3])[:, 2] > 0.0462
    again = leg(side, ankle_height=0.04519)
    found = again.sole_pose(again.pose_joints(pose[facing]))
    assert facing.sum() > 9000
    np.testing.assert_allclose(found, pose[facing], atol=1e-9)


@sides
def test_slanted_leg_agrees_with_the_geometric_angles_for_a_level_foot(side: str) -> None:
    points = np.random.default_rng(8).uniform([-0.05, -0.05, -0.185], [0.05, 0.05, -0.15], (500, 3))
    pose = homogeneous(np.tile(np.eye(3), (500, 1, 1)), points)
    found = leg(side).pose_joints(pose)
    expected = np.stack(geometric_angles(points, 0.1, 0.1029)[:5], axis=-1)
    np.testing.assert_allclose(found[:, 1:], expected, atol=1e-9)
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-12)


@sides
def test_the_first_joint_turns_about_the_slanted_axis(side: str) -> None:
    angle = np.linspace(-1.0, 0.7, 9)
    joints = np.zeros((9, 6))
    joints[:, 0] = angle
    axis = (0.0, np.sqrt(0.5), -np.sqrt(0.5) if side == "left" else np.sqrt(0.5))
    turned = vector_rotation(axis, angle)
    found = leg(side).sole_pose(joints)
    np.testing.assert_allclose(found[:, :3, :3], turned, atol=1e-12)
    np.testing.assert_allclose(found[:, :3, 3], turned @ [0.0, 0.0, -0.2029], atol=1e-12)


def test_the_legs_mirror_each_other() -> None:
    joints = random_joints("left", 200)
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    there = leg("left").sole_pose(joints)
    back = leg("right").sole_pose(joints * [1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(back, mirror @ there @ mirror, atol=1e-12)


def test_a_foot_out_of_reach_is_refused_with_its_tick() -> None:
    pose = homogeneous(
        np.tile(np.eye(3), (3, 1, 1)), np.array([[0, 0, -0.18]] * 2 + [[0, 0, -0.3]])
    )
    with pytest.raises(Infeasible, match=r"0\.3000 m.*\[0\.0029, 0\.2029\]") as caught:
        leg("left").pose_joints(pose)
    assert (caught.value.limb, caught.value.tick) == ("left_leg", 2)
