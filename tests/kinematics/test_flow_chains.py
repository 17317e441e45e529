"""Head, arm and leg of FLoW against reference vectors and against each other."""

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.dh import SIGNS, DhArm, DhHead, chain_pose, dh_transform
from gaitlab.kinematics.parallelogram import (
    dh_sole_pose,
    parallelogram_joints,
    plate_joints,
    serial_joints,
    sole_pose,
)
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation, homogeneous

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "flow.json").read_text())
TOLERANCE = 1e-9  # m and rad, digits of the reference vectors
ARM5 = DhArm(rise=0.05, upper_arm=0.17, forearm=0.22)
ARM7 = DhArm(rise=0.05, upper_arm=0.17, forearm=0.16, hand=0.06)


def lengths(case: dict[str, Any], limb: str) -> dict[str, float]:
    found: dict[str, float] = GOLDEN["geometry"][case["geometry"]][limb]
    return found


def head(case: dict[str, Any]) -> DhHead:
    found = lengths(case, "head")
    return DhHead(neck=found["d"], eyes=found["a"])


def arm(case: dict[str, Any]) -> DhArm:
    found = lengths(case, "arm")
    return DhArm(rise=found["d1"], upper_arm=found["d3"], forearm=found["d5"])


def leg(case: dict[str, Any]) -> Leg:
    found = lengths(case, "leg")
    geometry = LegLengths(
        hip_spacing=found["dy"], hip_drop=found["dz1"], thigh=found["l1"], shank=found["l2"]
    )
    side = "left" if case["sy"] == 1 else "right"
    return Leg(geometry=geometry, ankle_height=found["dz6"], side=side)


def random(low: float, high: float, n: int, k: int) -> np.ndarray:
    return np.random.default_rng(21).uniform(low, high, size=(n, k))


@pytest.mark.parametrize("case", GOLDEN["dh"])
def test_a_row_equals_the_reference(case: dict[str, Any]) -> None:
    found = dh_transform(np.array(case["theta"]), case["d"], case["a"], case["alpha"])
    np.testing.assert_allclose(found, case["A"], atol=TOLERANCE)


def test_a_row_is_turn_and_shift_along_z_then_shift_and_turn_along_x() -> None:
    theta, d, a, alpha = 0.7, 0.2, 0.3, -0.5
    along_z = homogeneous(axis_rotation("z", np.array(theta)), np.array([0.0, 0.0, d]))
    along_x = homogeneous(axis_rotation("x", np.array(alpha)), np.array([a, 0.0, 0.0]))
    found = dh_transform(np.array(theta), d, a, alpha)
    np.testing.assert_allclose(found, along_z @ along_x, atol=1e-15)


@pytest.mark.parametrize("case", GOLDEN["head_fk"])
def test_pose_of_the_head_equals_the_reference(case: dict[str, Any]) -> None:
    np.testing.assert_allclose(head(case).pose(np.array(case["q"])), case["T"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["head_ik"])
def test_pointing_of_the_head_equals_the_reference(case: dict[str, Any]) -> None:
    np.testing.assert_allclose(head(case).pointing(np.array(case["P"])), case["q"], atol=TOLERANCE)


def test_the_head_points_through_any_point_with_both_branches() -> None:
    one = DhHead(neck=0.05, eyes=0.07)
    points = random(-0.4, 0.4, 10_000, 3)
    found = one.pointing(points)
    for joints in (found, found * [1.0, -1.0] + [np.pi, 0.0]):
        from_tilt = one.pose(joints)[:, :3, 3] - [0.0, 0.0, one.neck]
        wanted = points - [0.0, 0.0, one.neck]
        wanted *= one.eyes / np.linalg.norm(wanted, axis=-1, keepdims=True)
        np.testing.assert_allclose(from_tilt, wanted, atol=1e-12)


@pytest.mark.parametrize("case", GOLDEN["arm5_fk"])
def test_pose_of_the_arm_equals_the_reference(case: dict[str, Any]) -> None:
    np.testing.assert_allclose(arm(case).pose(np.array(case["q"])), case["T"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["arm5_ik"])
def test_all_four_branches_of_the_arm_equal_the_reference(case: dict[str, Any]) -> None:
    found = arm(case).pose_joints(np.array(case["T"]))
    for branch in case["branches"]:
        signs = (branch["sgn_sin_theta2"], branch["sgn_sin_theta4"])
        np.testing.assert_allclose(found[SIGNS.index(signs)], branch["q"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["arm5_ik_position"])
def test_joints_of_a_point_equal_the_reference(case: dict[str, Any]) -> None:
    found = arm(case).point_joints(np.array(case["P"]), case["swivel"], case["theta5"])
    np.testing.assert_allclose(found[0], case["q"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["arm7_extension"]["cases"])
def test_the_arm_with_a_wrist_equals_the_reference(case: dict[str, Any]) -> None:
    found = case["geometry"]
    one = DhArm(rise=found["d1"], upper_arm=found["d3"], forearm=found["d5"], hand=found["d7"])
    pose = np.array(case["T"])
    np.testing.assert_allclose(one.pose(np.array(case["q_used_for_T"])), pose, atol=TOLERANCE)
    joints = one.wrist_joints(pose, case["swivel"])
    np.testing.assert_allclose(joints[0], case["q_ik"], atol=TOLERANCE)


def test_the_arms_pose_is_the_printed_one_after_its_three_repairs() -> None:
    """Equations (12) to (14), written out here once more."""
    q = random(-3.0, 3.0, 1000, 5)
    (c1, c2, c3, c4, _), (s1, s2, s3, s4, _) = np.cos(q).T, np.sin(q).T
    d1, d3, d5 = ARM5.rise, ARM5.upper_arm, ARM5.forearm
    x = d5 * (s4 * (s1 * s3 + c1 * c2 * c3) + c4 * c1 * s2) + d3 * c1 * s2
    y = d3 * s1 * s2 - d5 * (s4 * (c1 * s3 - s1 * c2 * c3) - c4 * s1 * s2)
    z = d1 - d5 * (c2 * c4 - c3 * s2 * s4) - d3 * c2
    np.testing.assert_allclose(ARM5.pose(q)[:, :3, 3], np.stack([x, y, z], axis=-1), atol=1e-14)


def test_only_one_set_of_right_angles_gives_that_pose() -> None:
    q = random(-3.0, 3.0, 20, 5)
    wanted, matching = ARM5.pose(q)[:, :3, 3], []
    for signs in product((1.0, -1.0), repeat=4):
        rows = [row._replace(alpha=s * np.pi / 2) for row, s in zip(ARM5.rows, signs, strict=False)]
        found = chain_pose([*rows, ARM5.rows[4]], q)[:, :3, 3]
        if np.allclose(found, wanted, atol=1e-9):
            matching.append(signs)
    assert matching == [(1.0, 1.0, -1.0, 1.0)]


def test_every_branch_of_the_arm_takes_the_pose() -> None:
    joints = random(-3.1, 3.1, 10_000, 5)
    pose = ARM5.pose(joints)
    found = ARM5.pose_joints(pose)
    np.testing.assert_allclose(
        ARM5.pose(found), np.broadcast_to(pose[:, None], (10_000, 4, 4, 4)), atol=1e-9
    )
    signs = np.sign(np.sin(found[..., [1, 3]]))
    np.testing.assert_array_equal(signs, np.broadcast_to(SIGNS, signs.shape))


def test_one_branch_of_the_arm_is_where_it_came_from() -> None:
    joints = random(-3.1, 3.1, 10_000, 5)
    apart = ARM5.pose_joints(ARM5.pose(joints)) - joints[:, None]
    apart = np.abs(np.angle(np.exp(1j * apart))).max(axis=-1).min(axis=-1)
    singular = np.abs(np.sin(joints[:, [1, 3]])).min(axis=-1) < 1e-3
    assert np.all(apart[~singular] < 1e-9)


@pytest.mark.parametrize("one", [ARM5, ARM7], ids=["five joints", "with a wrist"])
def test_every_branch_of_a_point_reaches_it(one: DhArm) -> None:
    directions = random(-1.0, 1.0, 10_000, 3)
    reach = np.random.default_rng(22).uniform(0.06, 0.38, size=(10_000, 1))
    points = [0.0, 0.0, one.rise] + reach * directions / np.linalg.norm(
        directions, axis=-1, keepdims=True
    )
    swivel = random(-3.0, 3.0, 10_000, 1)[:, 0]
    found = one.pose(one.point_joints(points, swivel))[..., :3, 3]
    np.testing.assert_allclose(found, np.repeat(points[:, None], 4, axis=1), atol=1e-9)


def test_at_no_swivel_no_elbow_is_lower() -> None:
    point = np.array([0.2, 0.1, 0.0])
    heights = [
        ARM5.pose(ARM5.point_joints(point, swivel)[0]) @ [0.0, 0.0, -ARM5.forearm, 1.0]
        for swivel in np.linspace(-3.0, 3.0, 13)
    ]
    assert min(height[2] for height in heights) == heights[6][2]


def test_the_wrist_takes_any_pose_within_reach() -> None:
    joints = random(-2.0, 2.0, 10_000, 7)
    pose = ARM7.pose(joints)
    found = ARM7.wrist_joints(pose, 0.7)
    np.testing.assert_allclose(
        ARM7.pose(found), np.broadcast_to(pose[:, None], (10_000, 4, 4, 4)), atol=1e-9
    )
    assert np.all(found[..., 5] >= 0.0)


def test_a_pose_that_five_joints_cannot_take_is_infeasible() -> None:
    pose = ARM5.pose(np.array([0.3, 0.6, -0.4, 0.9, 0.2]))
    pose[:3, :3] = np.eye(3)
    with pytest.raises(Infeasible, match="five joints take no such pose"):
        ARM5.pose_joints(pose)


def test_a_point_out_of_reach_names_reach_and_span() -> None:
    with pytest.raises(Infeasible, match=r"0\.5000 m, the arm spans \[0\.0500, 0\.3900\] m"):
        ARM5.point_joints(np.array([0.5, 0.0, ARM5.rise]))


@pytest.mark.parametrize("wrong", ["pose_joints", "wrist_joints"])
def test_an_arm_is_asked_for_the_joints_it_has(wrong: str) -> None:
    with pytest.raises(ValueError, match="joints; use"):
        getattr(ARM7 if wrong == "pose_joints" else ARM5, wrong)(np.eye(4))


@pytest.mark.parametrize("case", GOLDEN["leg_fk"])
def test_serial_and_denavit_hartenberg_leg_equal_the_reference(case: dict[str, Any]) -> None:
    joints = np.array(case["q"])
    np.testing.assert_allclose(leg(case).sole_pose(joints), case["T"], atol=TOLERANCE)
    np.testing.assert_allclose(dh_sole_pose(leg(case), joints), case["T"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["leg_ik_flat"])
def test_joints_and_parallelogram_of_a_level_sole_equal_the_reference(case: dict[str, Any]) -> None:
    joints = leg(case).flat_joints(np.array(case["P"]), np.array(case["heading"]))
    np.testing.assert_allclose(joints, case["q"], atol=TOLERANCE)
    np.testing.assert_allclose(
        parallelogram_joints(joints), case["u_parallelogram"], atol=TOLERANCE
    )


@pytest.mark.parametrize("case", GOLDEN["leg_ik_unreachable"])
def test_reference_targets_out_of_reach_are_infeasible(case: dict[str, Any]) -> None:
    with pytest.raises(Infeasible):
        leg(case).flat_joints(np.array(case["P"]), np.array(case["heading"]))


@pytest.mark.parametrize("case", GOLDEN["leg_parallelogram_fk"])
def test_the_leg_of_parallelograms_equals_the_reference(case: dict[str, Any]) -> None:
    angles = np.array(case["u"])
    np.testing.assert_allclose(sole_pose(leg(case), angles), case["T"], atol=TOLERANCE)
    np.testing.assert_allclose(serial_joints(angles), case["q_serial"], atol=TOLERANCE)


def test_three_models_of_the_leg_agree() -> None:
    one = leg({"geometry": "unequal", "sy": -1})
    angles = random(-1.3, 1.3, 10_000, 5)
    joints = serial_joints(angles)
    serial = one.sole_pose(joints)
    np.testing.assert_allclose(sole_pose(one, angles), serial, atol=1e-12)
    np.testing.assert_allclose(dh_sole_pose(one, joints), serial, atol=1e-12)
    np.testing.assert_allclose(parallelogram_joints(joints), angles, atol=1e-15)


def test_every_plate_stays_parallel_to_the_pelvis() -> None:
    thigh, knee_plate, shank, ankle_plate = plate_joints(random(-1.0, 1.0, 100, 5))[:, 2:6].T
    np.testing.assert_array_equal(thigh + knee_plate, 0.0)
    np.testing.assert_array_equal(shank + ankle_plate, 0.0)


def test_both_branches_of_a_leg_put_the_sole_there() -> None:
    one = leg({"geometry": "unequal", "sy": 1})
    spread = random(-1.0, 1.0, 10_000, 4) * [0.1, 0.08, 0.05, 0.6]
    position = spread[:, :3] + one.hip - [0.0, 0.0, 0.42]
    found = one.flat_branches(position, spread[:, 3])
    pose = one.sole_pose(found)
    level = axis_rotation("z", spread[:, 3])
    for branch, sign in ((0, 1.0), (1, -1.0)):
        np.testing.assert_allclose(pose[:, branch, :3, 3], position, atol=1e-9)
        np.testing.assert_allclose(pose[:, branch, :3, :3], level, atol=1e-9)
        assert np.all(sign * found[:, branch, 3] > 0.0)
