from typing import Any

import numpy as np
import pytest

from gaitlab.kinematics.arm import ArmGeometry, hand_pose
from gaitlab.kinematics.head import HeadGeometry, camera_pose, pointing_joints
from gaitlab.kinematics.transforms import axis_rotation
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
