from typing import Literal, get_args

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.planar_leg import FiveJointLeg, angles_of, ankle_position
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation

Side = Literal["left", "right"]
GEOMETRY = LegLengths(hip_spacing=0.04, hip_drop=0.03, thigh=0.08, shank=0.07)
every_side = pytest.mark.parametrize("side", get_args(Side))


def leg(side: Side) -> FiveJointLeg:
    return FiveJointLeg(geometry=GEOMETRY, ankle_height=0.03, side=side)


def positions(side: Side, n: int = 10_000) -> np.ndarray:
    low, high = [-0.04, -0.04, -0.15], [0.04, 0.04, -0.10]
    return leg(side).hip + np.random.default_rng(7).uniform(low, high, size=(n, 3))


def leans(n: int = 10_000) -> np.ndarray:
    return np.random.default_rng(8).uniform(-0.3, 0.4, size=n)


@every_side
def test_the_sole_is_where_it_was_asked_and_level_under_a_leaning_trunk(side: Side) -> None:
    pose = leg(side).sole_pose(leg(side).level_joints(positions(side), leans()))
    np.testing.assert_allclose(pose[:, :3, 3], positions(side), atol=1e-12)
    level = axis_rotation("y", leans()) @ pose[:, :3, :3]
    np.testing.assert_allclose(level[:, 2, 2], 1.0, atol=1e-12)


@every_side
def test_an_upright_trunk_gives_the_six_joint_leg_without_yaw(side: Side) -> None:
    joints = leg(side).level_joints(positions(side), 0.0)
    six = Leg(geometry=GEOMETRY, ankle_height=0.03, side=side)
    expected = six.flat_joints(positions(side), np.zeros(10_000))
    np.testing.assert_allclose(joints, expected[:, 1:], atol=1e-9)


@every_side
def test_the_foot_turns_by_about_lean_times_roll(side: Side) -> None:
    joints = leg(side).level_joints(positions(side), leans())
    level = axis_rotation("y", leans()) @ leg(side).sole_pose(joints)[:, :3, :3]
    turn = np.arctan2(level[:, 1, 0], level[:, 0, 0])
    product = leans() * joints[:, 0]
    assert np.max(np.abs(np.abs(turn) - np.abs(product))) < 0.02
    assert np.max(np.abs(turn)) > 0.05


@every_side
def test_the_paper_s_spatial_forward_kinematics_is_the_same_leg(side: Side) -> None:
    joints = leg(side).level_joints(positions(side), leans())
    x, y, z = ankle_position(angles_of(joints), thigh=0.08, shank=0.07, coupling="spatial").T
    up = axis_rotation("y", -leans())[:, :, 2]
    ankle = positions(side) + 0.03 * up - leg(side).hip
    np.testing.assert_allclose(np.stack([x, -z, -y], axis=-1), ankle, atol=1e-12)


def test_a_sole_out_of_reach_is_infeasible() -> None:
    with pytest.raises(Infeasible, match="shorten") as caught:
        leg("left").level_joints(np.array([[0.0, 0.04, -0.15], [0.0, 0.04, -0.25]]), 0.0)
    assert (caught.value.limb, caught.value.tick) == ("left_leg", 1)
