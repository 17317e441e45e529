import dataclasses

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Robot as RobotProtocol
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import get_path, parameters, set_path
from gaitlab.robots.bioloid import MIRRORED, Robot
from gaitlab.servos.counts import ax_counts
from gaitlab.servos.files import load_servo

ROBOT = Robot()
PROTOCOL: RobotProtocol = ROBOT
SINGLE = ("trunk", "waist_turn", "waist", "chest", "neck", "head")


def feet_poses(n: int, **changes: np.ndarray) -> FeetPoses:
    """Both feet level below the hips, 145 mm down, unless changed."""
    still = FeetPoses(
        position=np.tile([[0.0, 0.0385, -0.145], [0.0, -0.0385, -0.145]], (n, 1, 1)),
        heading=np.zeros((n, 2)),
        trunk_pitch=np.zeros(n),
        ankle_pitch=np.zeros((n, 2)),
        knee_only=np.zeros((n, 2)),
        swing=np.zeros((n, 2), dtype=bool),
        phase=np.full(n, np.nan),
        step_index=np.full(n, -1),
    )
    return dataclasses.replace(still, **changes)


def random_feet(n: int) -> FeetPoses:
    generator = np.random.default_rng(9)
    spread = generator.uniform([-0.02, -0.02, -0.01], [0.02, 0.02, 0.02], size=(n, 2, 3))
    lean = generator.uniform(-0.1, 0.3, size=n)
    return feet_poses(n, position=feet_poses(n).position + spread, trunk_pitch=lean)


def upright(n: int) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))


def test_the_published_joint_counts_hold_for_every_part() -> None:
    names = [joint.name for joint in ROBOT.tree.joints]
    assert len(names) == len(set(names)) == 23
    parts = {"head": 2, "waist": 3, "hip": 4, "knee": 2, "ankle": 4, "shoulder": 4, "elbow": 2}
    for part, count in parts.items():
        assert sum(part in name for name in names) == count, part
    assert sum("arm_yaw" in name for name in names) == 2
    assert {joint.servo for joint in ROBOT.tree.joints} == {"ax_12"}


def test_it_stands_400_mm_tall_and_spans_550_mm() -> None:
    joints = np.zeros((1, 23))
    for name, angle in (("left_shoulder_roll", np.pi / 2), ("right_shoulder_roll", -np.pi / 2)):
        joints[0, [joint.name for joint in ROBOT.tree.joints].index(name)] = angle
    poses = ROBOT.tree.poses(*upright(1), joints)
    head, foot = ROBOT.tree.index("head"), ROBOT.tree.index("left_foot")
    top = poses.position[0, head, 2] + ROBOT.upper_body.head
    assert top - poses.position[0, foot, 2] + ROBOT.sole.height == pytest.approx(0.400, abs=1e-12)
    elbows = [ROBOT.tree.index(f"{side}_forearm") for side in ("left", "right")]
    hands = poses.position[0, elbows] - ROBOT.upper_body.forearm * poses.rotation[0, elbows, :, 2]
    assert hands[0, 1] - hands[1, 1] == pytest.approx(0.550, abs=1e-12)


def test_it_weighs_3_kg_with_all_servos_and_frames_given_out() -> None:
    assert ROBOT.tree.mass == pytest.approx(3.0, abs=1e-12)
    times = [1 if row["link"] in SINGLE else 2 for row in ROBOT.table]
    servos = [int(row["servos_carried"]) for row in ROBOT.table]
    frames = [float(row["frame_share"]) for row in ROBOT.table]
    assert np.dot(times, servos) == 23
    assert np.dot(times, frames) == pytest.approx(1.0)
    assert load_servo("ax_12").mass == ROBOT.masses.servo


def test_left_and_right_links_mirror_each_other() -> None:
    links = {link.name: link for link in ROBOT.tree.links}
    mirrored = [name for name in links if name.startswith("left_")]
    assert len(mirrored) == 9
    for name in mirrored:
        left, right = links[name], links[name.replace("left_", "right_")]
        assert (right.mass, right.box.size) == (left.mass, left.box.size)
        mirror = np.array([1.0, -1.0, 1.0])
        np.testing.assert_array_equal(right.origin, mirror * left.origin)
        np.testing.assert_array_equal(right.box.centre, mirror * left.box.centre)


def test_its_tree_agrees_with_the_closed_form_of_its_legs() -> None:
    joints = np.random.default_rng(10).uniform(-1.0, 1.0, size=(200, 23))
    poses = ROBOT.tree.poses(*upright(200), joints)
    for k, side in enumerate(("left", "right")):
        sole = ROBOT.leg_of(side).sole_pose(joints[:, 5 * k : 5 * k + 5])
        foot = ROBOT.tree.index(f"{side}_foot")
        lowest = poses.position[:, foot] - ROBOT.sole.height * poses.rotation[:, foot, :, 2]
        np.testing.assert_allclose(lowest, sole[:, :3, 3], atol=1e-14)
        np.testing.assert_allclose(poses.rotation[:, foot], sole[:, :3, :3], atol=1e-14)


def test_feet_go_where_they_are_told_and_stay_level_under_a_leaning_trunk() -> None:
    feet = random_feet(2000)
    trunk = axis_rotation("y", feet.trunk_pitch)
    poses = ROBOT.tree.poses(np.zeros((2000, 3)), trunk, ROBOT.joint_targets(feet))
    for k, name in enumerate(ROBOT.feet):
        foot = ROBOT.tree.index(name)
        np.testing.assert_allclose(poses.rotation[:, foot, 2, 2], 1.0, atol=1e-12)
        wanted = feet.position[:, k] - [0.0, 0.0, ROBOT.hip_offset()]
        sole = poses.position[:, foot] - ROBOT.sole.height * poses.rotation[:, foot, :, 2]
        np.testing.assert_allclose(sole, np.einsum("nij,nj->ni", trunk, wanted), atol=1e-12)


def test_a_foot_that_would_have_to_turn_is_infeasible() -> None:
    heading = np.zeros((3, 2))
    heading[2, 1] = 0.1
    with pytest.raises(Infeasible, match="no hip yaw") as caught:
        ROBOT.joint_targets(feet_poses(3, heading=heading))
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 2)


def test_the_first_infeasible_instant_is_reported_whatever_its_leg() -> None:
    position = feet_poses(6).position
    position[4:, 0, 0] = 0.2
    position[2:, 1, 2] = -0.25
    with pytest.raises(Infeasible, match="the leg spans") as caught:
        ROBOT.joint_targets(feet_poses(6, position=position))
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 2)


def test_a_joint_beyond_its_limit_is_named() -> None:
    position = feet_poses(1).position
    position[0, 0] = [0.0, 0.16, -0.11]
    with pytest.raises(Infeasible, match=r"left_hip_roll .* its limits are"):
        ROBOT.joint_targets(feet_poses(1, position=position))


def test_waist_arms_and_head_hold_their_posture_within_their_limits() -> None:
    joints = ROBOT.joint_targets(feet_poses(3))[:, 10:]
    assert np.all(joints == joints[0])
    for value, joint in zip(joints[0], ROBOT.tree.joints[10:], strict=True):
        assert joint.lower <= value <= joint.upper
    assert joints[0, 4] == -joints[0, 8]  # both arms out


def test_servo_counts_have_one_direction_a_servo_with_right_pitch_turned_over() -> None:
    assert ax_counts(np.zeros(23), ROBOT.servo_directions).tolist() == [512] * 23
    counts = ax_counts(np.full(23, 0.1), ROBOT.servo_directions)
    for joint, count in zip(ROBOT.tree.joints, counts.tolist(), strict=True):
        turned_over = joint.name.removeprefix("right_") in MIRRORED and "right" in joint.name
        assert count == (492 if turned_over else 532), joint.name


def test_every_parameter_can_be_set_and_says_where_its_default_comes_from() -> None:
    for parameter in parameters(Robot):
        assert parameter.source.startswith(("assumption", "published")), parameter.name
        assert get_path(ROBOT, parameter.name) == parameter.default
        assert set_path(ROBOT, parameter.name, parameter.default) == ROBOT


def test_a_leg_can_be_asked_in_the_paper_s_frame_forwards_and_backwards() -> None:
    generator = np.random.default_rng(12)
    for limb in (ROBOT.limbs()["left_leg"], ROBOT.limbs()["right_leg"]):
        for target in generator.uniform([-0.03, 0.08, -0.03], [0.05, 0.12, 0.03], size=(200, 3)):
            for joints in limb.inverse(target, 0.0):
                pose = limb.forward(joints)
                np.testing.assert_allclose(pose[:3, 3], target, atol=1e-12)
                np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-9)


def test_a_leg_s_counts_follow_its_servos() -> None:
    limb = ROBOT.limbs()["right_leg"]
    joints = limb.inverse(np.array([0.02, 0.115, 0.0]), 0.0)[0]
    all_joints = np.zeros(23)
    all_joints[5:10] = joints
    wanted = ax_counts(all_joints, ROBOT.servo_directions)
    assert limb.counts is not None
    assert limb.counts(joints).tolist() == wanted[5:10].tolist()
