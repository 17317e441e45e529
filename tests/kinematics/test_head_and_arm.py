from typing import Any, Literal

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.arm import hand_branches, hand_pose
from gaitlab.kinematics.head import camera_pose, pointing_joints
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.robots.eros import ArmGeometry, HeadGeometry
from tests.kinematics import golden

TOLERANCE = 1e-9  # m and -, digits of the reference vectors


@pytest.mark.parametrize("case", golden.cases("head_fk"))
def test_camera_pose_equals_the_reference(case: dict[str, Any]) -> None:
    pose = camera_pose(golden.head(case), np.array(case["q"], dtype=float))
    np.testing.assert_allclose(pose, case["T"], atol=TOLERANCE)


@pytest.mark.parametrize("case", golden.cases("head_ik"))
def test_pointing_joints_equal_the_reference(case: dict[str, Any]) -> None:
    joints = pointing_joints(golden.head(case), np.array(case["P"]))
    np.testing.assert_allclose(joints, case["q"], atol=TOLERANCE)


@pytest.mark.parametrize("case", golden.cases("arm_fk"))
def test_hand_pose_equals_the_reference(case: dict[str, Any]) -> None:
    pose = hand_pose(golden.arm(case), np.array(case["q"]), golden.SIDES[case["sy"]])
    np.testing.assert_allclose(pose, case["T"], atol=TOLERANCE)


def test_looking_at_a_point_puts_it_on_the_cameras_up_axis() -> None:
    geometry = HeadGeometry()
    point = np.random.default_rng(2).normal(size=(500, 3))
    pose = camera_pose(geometry, pointing_joints(geometry, point))
    sight = point - [0.0, 0.0, geometry.neck]
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    np.testing.assert_allclose(pose[:, :3, 2], sight, atol=1e-12)


def test_arm_is_the_product_of_its_chain() -> None:
    geometry = ArmGeometry()
    joints = np.random.default_rng(3).uniform(-3.0, 3.0, size=(500, 3))
    pitch, roll, elbow = (
        axis_rotation(axis, angle) for axis, angle in zip("yxy", joints.T, strict=True)
    )
    shoulder = np.array([0.0, geometry.shoulder_spacing, -geometry.shoulder_drop])
    hand = (
        pitch @ shoulder
        + (pitch @ roll) @ [0.0, 0.0, -geometry.upper_arm]
        + (pitch @ roll @ elbow) @ [0.0, 0.0, -geometry.forearm]
    )
    pose = hand_pose(geometry, joints, "left")
    np.testing.assert_allclose(pose[:, :3, :3], pitch @ roll @ elbow, atol=1e-14)
    np.testing.assert_allclose(pose[:, :3, 3], hand, atol=1e-15)


def test_arms_mirror_each_other_when_the_roll_does() -> None:
    joints = np.random.default_rng(4).uniform(-3.0, 3.0, size=(100, 3))
    left = hand_pose(ArmGeometry(), joints, "left")[:, :3, 3]
    right = hand_pose(ArmGeometry(), joints * [1.0, -1.0, 1.0], "right")[:, :3, 3]
    np.testing.assert_allclose(right, left * [1.0, -1.0, 1.0], atol=1e-15)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    "geometry",
    [ArmGeometry(), ArmGeometry(upper_arm=0.018), ArmGeometry(upper_arm=0.12, forearm=0.08)],
    ids=["eros", "equal drop and upper arm", "long upper arm"],
)
def test_every_branch_puts_the_hand_back_and_one_has_the_joints_it_came_from(
    geometry: ArmGeometry, side: Literal["left", "right"]
) -> None:
    joints = np.random.default_rng(51).uniform([-3.1, -1.5, -2.4], [3.1, 1.5, 2.4], (10_000, 3))
    point = hand_pose(geometry, joints, side)[:, :3, 3]
    found = hand_branches(geometry, point, side)
    there = np.isfinite(found).all(axis=-1)
    again = hand_pose(geometry, np.nan_to_num(found), side)[..., :3, 3]
    assert np.abs(again - point[:, None])[there].max() < 1e-9
    apart = np.abs(np.angle(np.exp(1j * (found - joints[:, None])))).max(axis=-1)
    nearest = np.where(there, apart, np.inf).min(axis=-1)
    assert nearest.max() < 1e-5  # rad; near a double root digits are lost
    assert np.median(nearest) < 1e-12


def test_a_hand_out_of_reach_is_infeasible() -> None:
    with pytest.raises(Infeasible, match=r"would have to be 0\.5000 m; the arm is 0\.2130 m"):
        hand_branches(ArmGeometry(), np.array([0.5, 0.09, 0.0]), "left")
