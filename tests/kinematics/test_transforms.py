import numpy as np
import pytest

from gaitlab.kinematics.transforms import (
    axis_rotation,
    homogeneous,
    quaternion_of,
    roll_pitch_yaw,
    rotation_of,
    turned,
)


@pytest.fixture
def quaternions() -> np.ndarray:
    q = np.random.default_rng(1).normal(size=(1000, 4))
    q[:4] = np.eye(4)  # half turns and no turn, where naive formulas lose digits
    q *= np.where(q[:, 3:] < 0.0, -1.0, 1.0)
    return q / np.linalg.norm(q, axis=1, keepdims=True)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turning_back_undoes_a_turn(axis: str) -> None:
    angle = np.linspace(-7.0, 7.0, 31)
    product = axis_rotation(axis, angle) @ axis_rotation(axis, -angle)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), atol=1e-15)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turned_rotations_are_their_product_with_a_turn(axis: str, quaternions: np.ndarray) -> None:
    rotation, angle = rotation_of(quaternions), np.linspace(-7.0, 7.0, len(quaternions))
    product = rotation @ axis_rotation(axis, angle)
    np.testing.assert_allclose(turned(rotation, axis, angle), product, atol=1e-15)


@pytest.mark.parametrize(("axis", "start", "end"), [("x", 1, 2), ("y", 2, 0), ("z", 0, 1)])
def test_a_quarter_turn_carries_each_axis_to_the_next(axis: str, start: int, end: int) -> None:
    turned = axis_rotation(axis, np.array(np.pi / 2)) @ np.eye(3)[start]
    np.testing.assert_allclose(turned, np.eye(3)[end], atol=1e-15)


def test_rotation_and_quaternion_invert_each_other(quaternions: np.ndarray) -> None:
    np.testing.assert_allclose(quaternion_of(rotation_of(quaternions)), quaternions, atol=1e-12)


def test_rotation_of_a_quaternion_is_orthogonal_and_right_handed(quaternions: np.ndarray) -> None:
    rotation = rotation_of(quaternions)
    identity = np.broadcast_to(np.eye(3), rotation.shape)
    np.testing.assert_allclose(rotation @ np.swapaxes(rotation, 1, 2), identity, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0, atol=1e-14)


def test_roll_pitch_and_yaw_compose_the_rotation_they_were_read_from(
    quaternions: np.ndarray,
) -> None:
    rotation = rotation_of(quaternions)
    roll, pitch, yaw = roll_pitch_yaw(rotation).T
    product = axis_rotation("z", yaw) @ axis_rotation("y", pitch) @ axis_rotation("x", roll)
    np.testing.assert_allclose(product, rotation, atol=1e-12)


def test_leaning_forward_is_positive_pitch_and_turning_left_positive_yaw() -> None:
    nose_down = axis_rotation("y", np.array(0.3))
    assert (nose_down @ [1.0, 0.0, 0.0])[2] < 0.0
    np.testing.assert_allclose(roll_pitch_yaw(nose_down), [0.0, 0.3, 0.0], atol=1e-15)
    left = axis_rotation("z", np.array(0.3))
    assert (left @ [1.0, 0.0, 0.0])[1] > 0.0
    np.testing.assert_allclose(roll_pitch_yaw(left), [0.0, 0.0, 0.3], atol=1e-15)


def test_leading_axes_are_kept() -> None:
    angle = np.zeros((4, 5))
    rotation = axis_rotation("x", angle)
    assert rotation.shape == (4, 5, 3, 3)
    assert quaternion_of(rotation).shape == (4, 5, 4)
    assert roll_pitch_yaw(rotation).shape == (4, 5, 3)
    assert homogeneous(rotation, np.zeros((4, 5, 3))).shape == (4, 5, 4, 4)
