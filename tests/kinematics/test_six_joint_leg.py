import pickle
from typing import Any, Literal, get_args

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from tests.kinematics import golden

TOLERANCE = 1e-9  # m and rad, digits of the reference vectors
Side = Literal["left", "right"]
YawAxis = Literal["hip", "trunk"]
UNEQUAL = LegLengths(hip_spacing=0.04, hip_drop=0.03, thigh=0.11, shank=0.095)

every_side = pytest.mark.parametrize("side", get_args(Side))
every_leg = pytest.mark.parametrize("yaw_axis", get_args(YawAxis))


def leg(side: Side, yaw_axis: YawAxis = "hip", geometry: LegLengths = UNEQUAL) -> Leg:
    return Leg(geometry=geometry, ankle_height=0.04, side=side, yaw_axis=yaw_axis)


def random_joints(n: int = 10_000) -> np.ndarray:
    """Joints with a forward knee and a sole that faces away from the hip."""
    low = [-1.2, -0.6, -1.2, 0.05, -0.7, -0.6]
    high = [1.2, 0.6, 0.3, 1.6, 0.4, 0.6]
    return np.random.default_rng(5).uniform(low, high, size=(n, 6))


def flat_targets(n: int = 10_000) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(6)
    position = generator.uniform([-0.06, -0.05, -0.23], [0.06, 0.05, -0.14], size=(n, 3))
    return position, generator.uniform(-0.8, 0.8, size=n)


@pytest.mark.parametrize("case", golden.cases("leg_fk"))
def test_sole_pose_equals_the_reference(case: dict[str, Any]) -> None:
    pose = golden.leg(case).sole_pose(np.array(case["q"]))
    np.testing.assert_allclose(pose, case["T"], atol=TOLERANCE)


@pytest.mark.parametrize("case", golden.cases("leg_ik_flat"))
def test_flat_joints_equal_the_reference(case: dict[str, Any]) -> None:
    joints = golden.leg(case).flat_joints(np.array(case["P"]), np.array(case["heading"]))
    np.testing.assert_allclose(joints, case["q"], atol=TOLERANCE)


@pytest.mark.parametrize("case", golden.cases("leg_ik_pose"))
def test_pose_joints_equal_the_reference(case: dict[str, Any]) -> None:
    joints = golden.leg(case).pose_joints(np.array(case["T"]))
    np.testing.assert_allclose(joints, case["q"], atol=TOLERANCE)


@pytest.mark.parametrize("case", golden.cases("leg_ik_unreachable"))
def test_reference_targets_out_of_reach_are_infeasible(case: dict[str, Any]) -> None:
    with pytest.raises(Infeasible):
        golden.leg(case).flat_joints(np.array(case["P"]), np.array(case["heading"]))


@every_side
@every_leg
def test_fk_inverts_flat_ik_within_reach(side: Side, yaw_axis: YawAxis) -> None:
    one = leg(side, yaw_axis)
    position, heading = flat_targets()
    if yaw_axis == "hip":
        position = position + one.hip
    else:
        position = np.einsum("nij,nj->ni", axis_rotation("z", heading), position + one.hip)
    joints = one.flat_joints(position, heading)
    pose = one.sole_pose(joints)
    np.testing.assert_allclose(pose[:, :3, 3], position, atol=1e-9)
    np.testing.assert_allclose(pose[:, :3, :3], axis_rotation("z", heading), atol=1e-12)
    assert np.all(joints[:, 3] >= 0.0)


@every_side
def test_pose_ik_recovers_the_joints_of_any_pose(side: Side) -> None:
    joints = random_joints()
    pose = leg(side).sole_pose(joints)
    found = leg(side).pose_joints(pose)
    np.testing.assert_allclose(found, joints, atol=1e-9)
    np.testing.assert_allclose(leg(side).sole_pose(found), pose, atol=1e-9)


@every_side
def test_flat_ik_is_pose_ik_of_a_level_sole(side: Side) -> None:
    one = leg(side)
    position, heading = flat_targets()
    position = position + one.hip
    pose = homogeneous(axis_rotation("z", heading), position)
    np.testing.assert_allclose(
        one.pose_joints(pose), one.flat_joints(position, heading), atol=1e-12
    )


@every_leg
def test_legs_mirror_each_other_when_yaw_and_roll_do(yaw_axis: YawAxis) -> None:
    joints = random_joints(200)
    left = leg("left", yaw_axis).sole_pose(joints)
    right = leg("right", yaw_axis).sole_pose(joints * [-1, -1, 1, 1, 1, -1])
    mirror = np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(right[:, :3, 3], left[:, :3, 3] @ mirror, atol=1e-15)
    np.testing.assert_allclose(right[:, :3, :3], mirror @ left[:, :3, :3] @ mirror, atol=1e-15)


@every_side
def test_yaw_axes_differ_by_the_swing_of_the_hip_alone(side: Side) -> None:
    joints = random_joints(200)
    trunk, hip = leg(side, "trunk").sole_pose(joints), leg(side, "hip").sole_pose(joints)
    yaw, dy = joints[:, 0], leg(side).hip[1]
    swing = np.stack([-dy * np.sin(yaw), dy * (np.cos(yaw) - 1.0), np.zeros_like(yaw)], axis=-1)
    np.testing.assert_allclose(trunk[:, :3, 3] - hip[:, :3, 3], swing, atol=1e-15)
    np.testing.assert_allclose(trunk[:, :3, :3], hip[:, :3, :3], atol=1e-15)


def test_a_crouch_bends_hip_back_knee_forward_and_toe_up() -> None:
    """Equal links and an ankle 190 mm below the hip: -25.21, 50.42, -25.21 degrees."""
    lengths = LegLengths(hip_spacing=0.042, hip_drop=0.035, thigh=0.105, shank=0.105)
    one = Leg(geometry=lengths, ankle_height=0.038, side="left")
    joints = one.flat_joints(one.hip - [0.0, 0.0, 0.228], np.array(0.0))
    np.testing.assert_allclose(
        np.degrees(joints), [0.0, 0.0, -25.21, 50.42, -25.21, 0.0], atol=0.005
    )


def test_a_stretched_leg_forgives_rounding_and_nothing_more() -> None:
    one = leg("left")
    stretched = one.hip - [0.0, 0.0, 0.11 + 0.095 + 0.04]
    assert one.flat_joints(stretched - [0.0, 0.0, 5e-10], np.array(0.0))[3] == 0.0
    with pytest.raises(Infeasible):
        one.flat_joints(stretched - [0.0, 0.0, 2e-9], np.array(0.0))


def test_infeasible_names_limb_first_tick_reach_and_span() -> None:
    one = leg("right")
    position = np.tile(one.hip - [0.0, 0.0, 0.2], (5, 1))
    position[3:, 0] += [0.2, 0.3]
    with pytest.raises(Infeasible) as caught:
        one.flat_joints(position, np.zeros(5))
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 3)
    assert caught.value.reason == (
        "hip to ankle would have to be 0.2561 m, the leg spans [0.0150, 0.2050] m; "
        "shorten step_length or step_height, or change hip_height"
    )
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


@pytest.mark.parametrize("depth", [0.039, -0.1, np.nan])
def test_an_ankle_that_is_not_below_the_hip_is_infeasible(depth: float) -> None:
    one = leg("left")
    target = one.hip + np.array([0.1, 0.0, -depth])
    with pytest.raises(Infeasible, match="above the hip"):
        one.flat_joints(target, np.array(0.0))
    with pytest.raises(Infeasible, match="along the sole's normal"):
        one.pose_joints(homogeneous(np.eye(3), target))


def test_pose_ik_of_a_yaw_about_the_trunk_is_refused() -> None:
    with pytest.raises(ValueError, match="yaw_axis"):
        leg("left", "trunk").pose_joints(np.eye(4))
