import dataclasses

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.arm import hand_pose
from gaitlab.kinematics.head import camera_pose
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Robot as RobotProtocol
from gaitlab.model.gait import SHAPES, FeetPoses
from gaitlab.model.link_table import Row
from gaitlab.parameters import get_path, parameters, set_path
from gaitlab.robots.eros import Robot
from gaitlab.robots.nao import Robot as Nao

ROBOT: RobotProtocol = Robot()
LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "elbow")


def feet_poses(n: int, **changes: np.ndarray) -> FeetPoses:
    """Both feet level below the hips, 228 mm down, unless changed."""
    still = FeetPoses(
        position=np.tile([[0.0, 0.042, -0.228], [0.0, -0.042, -0.228]], (n, 1, 1)),
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
    spread = generator.uniform([-0.03, -0.02, -0.005], [0.03, 0.02, 0.03], size=(n, 2, 3))
    return feet_poses(
        n,
        position=feet_poses(n).position + spread,
        heading=generator.uniform(-0.3, 0.3, size=(n, 2)),
        trunk_pitch=generator.uniform(-0.1, 0.2, size=n),
    )


def upright(n: int) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))


def test_the_twenty_joints_come_left_leg_right_leg_arms_head() -> None:
    expected = [f"{side}_{joint}" for side in ("left", "right") for joint in LEG]
    expected += [f"{side}_{joint}" for side in ("left", "right") for joint in ARM]
    expected += ["head_pan", "head_tilt"]
    assert [joint.name for joint in ROBOT.tree.joints] == expected
    servos = [joint.servo for joint in ROBOT.tree.joints]
    assert servos == ["mx_64"] * 12 + ["mx_28"] * 8


def test_it_stands_520_mm_tall_with_straight_legs() -> None:
    poses = ROBOT.tree.poses(*upright(1), np.zeros((1, 20)))
    tops, bottoms = [], []
    for k, link in enumerate(ROBOT.tree.links):
        corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * link.box.size
        z = poses.position[0, k, 2] + corners[:, 2] + link.box.centre[2]
        tops.append(z.max())
        bottoms.append(z.min())
    assert max(tops) - min(bottoms) == pytest.approx(0.520, abs=1e-12)
    sole = poses.position[0, ROBOT.tree.index("left_foot"), 2] - ROBOT.sole.height
    assert min(bottoms) == pytest.approx(sole, abs=1e-12)


def test_mass_is_the_parameter_and_the_links_keep_their_shares() -> None:
    assert ROBOT.tree.mass == pytest.approx(3.50, abs=1e-12)
    heavy = Robot(mass=4.2)
    assert heavy.tree.mass == pytest.approx(4.2, abs=1e-12)
    for one, other in zip(ROBOT.tree.links, heavy.tree.links, strict=True):
        assert other.mass == pytest.approx(1.2 * one.mass)


def test_a_robot_with_a_table_of_its_own_has_its_shares_limits_and_servos() -> None:
    def changed(row: Row) -> Row:
        own = {"lower_deg": "-150", "servo": "mx_64", "mass_kg": "0.24"}
        return {**row, **own} if row["link"] == "forearm" else row

    class Stronger(Robot):
        table = tuple(changed(row) for row in Robot.table)

    tree, before = Stronger().tree, ROBOT.tree
    assert tree.mass == pytest.approx(3.5, abs=1e-12)
    assert [joint.name for joint in tree.joints] == [joint.name for joint in before.joints]
    elbows = [joint for joint in tree.joints if "elbow" in joint.name]
    assert [(np.degrees(elbow.lower), elbow.servo) for elbow in elbows] == [(-150.0, "mx_64")] * 2
    forearm, old = (one.links[one.index("left_forearm")].mass for one in (tree, before))
    assert forearm == pytest.approx(2.0 * old * 3.5 / 3.74)


def test_left_and_right_links_mirror_each_other() -> None:
    links = {link.name: link for link in ROBOT.tree.links}
    mirrored = [name for name in links if name.startswith("left_")]
    assert len(mirrored) == 9
    for name in mirrored:
        left, right = links[name], links[name.replace("left_", "right_")]
        assert right.mass == left.mass
        assert right.box.size == left.box.size
        mirror = np.array([1.0, -1.0, 1.0])
        np.testing.assert_array_equal(right.origin, mirror * left.origin)
        np.testing.assert_array_equal(right.box.centre, mirror * left.box.centre)


def test_tree_agrees_with_the_closed_forms_of_every_limb() -> None:
    n = 200
    joints = np.random.default_rng(10).uniform(-1.5, 1.5, size=(n, 20))
    poses, tree = ROBOT.tree.poses(*upright(n), joints), ROBOT.tree
    for k, side in enumerate(("left", "right")):
        leg = Leg(geometry=ROBOT.leg, ankle_height=ROBOT.sole.height, side=side)
        sole = leg.sole_pose(joints[:, 6 * k : 6 * k + 6])
        foot = tree.index(f"{side}_foot")
        lowest = poses.position[:, foot] - ROBOT.sole.height * poses.rotation[:, foot, :, 2]
        np.testing.assert_allclose(lowest, sole[:, :3, 3], atol=1e-14)
        np.testing.assert_allclose(poses.rotation[:, foot], sole[:, :3, :3], atol=1e-14)
        hand = hand_pose(ROBOT.arm, joints[:, 12 + 3 * k : 15 + 3 * k], side)
        elbow = tree.index(f"{side}_forearm")
        end = poses.position[:, elbow] - ROBOT.arm.forearm * poses.rotation[:, elbow, :, 2]
        shoulder = [0.0, 0.0, ROBOT.torso.shoulder_height]
        np.testing.assert_allclose(end, hand[:, :3, 3] + shoulder, atol=1e-14)
    camera = camera_pose(ROBOT.head, joints[:, 18:])
    head = tree.index("head")
    eye = poses.position[:, head] + ROBOT.head.camera * poses.rotation[:, head, :, 2]
    base = [0.0, 0.0, ROBOT.torso.shoulder_height + ROBOT.torso.neck_height]
    np.testing.assert_allclose(eye, camera[:, :3, 3] + base, atol=1e-14)


def test_feet_go_where_they_are_told_with_leaning_trunk_and_turned_feet() -> None:
    feet = random_feet(2000)
    joints = ROBOT.joint_targets(feet)
    trunk = axis_rotation("y", feet.trunk_pitch)
    poses = ROBOT.tree.poses(np.zeros((2000, 3)), trunk, joints)
    for k, name in enumerate(ROBOT.feet):
        foot = ROBOT.tree.index(name)
        level = axis_rotation("z", feet.heading[:, k])
        np.testing.assert_allclose(poses.rotation[:, foot], level, atol=1e-9)
        from_hip = feet.position[:, k] - [0.0, 0.0, ROBOT.hip_offset()]
        sole = poses.position[:, foot] - ROBOT.sole.height * poses.rotation[:, foot, :, 2]
        np.testing.assert_allclose(sole, np.einsum("nij,nj->ni", trunk, from_hip), atol=1e-9)


def test_an_upright_trunk_gives_the_flat_inverse_kinematics() -> None:
    feet = dataclasses.replace(random_feet(500), trunk_pitch=np.zeros(500))
    joints = ROBOT.joint_targets(feet)
    for k, side in enumerate(("left", "right")):
        leg = Leg(geometry=ROBOT.leg, ankle_height=ROBOT.sole.height, side=side)
        position = feet.position[:, k] - [0.0, 0.0, ROBOT.hip_offset()]
        flat = leg.flat_joints(position, feet.heading[:, k])
        np.testing.assert_allclose(joints[:, 6 * k : 6 * k + 6], flat, atol=1e-12)


@pytest.mark.parametrize("robot", [Robot(), Nao()], ids=lambda robot: robot.name)
def test_what_is_held_gives_the_targets_of_its_first_instant(robot: RobotProtocol) -> None:
    """And where it cannot be reached, the first instant of the whole gait is named."""
    straight = {"heading": np.zeros((40, 2)), "trunk_pitch": np.zeros(40)}
    feet = dataclasses.replace(random_feet(40), **straight)
    times = np.random.default_rng(2).integers(1, 6, 40)
    parts = {name: np.repeat(getattr(feet, name), times, axis=0) for name in SHAPES}
    once, held = robot.joint_targets(feet), robot.joint_targets(FeetPoses(**parts))
    np.testing.assert_array_equal(held, np.repeat(once, times, axis=0))
    parts["position"][np.repeat(np.arange(40) >= 17, times), 1, 2] += 0.3
    with pytest.raises(Infeasible, match="right_leg") as caught:
        robot.joint_targets(FeetPoses(**parts))
    assert caught.value.tick == times[:17].sum()


def test_arms_and_head_hold_their_posture_within_their_limits() -> None:
    robot = set_path(Robot(), "posture.head_tilt", 0.4)
    joints = robot.joint_targets(feet_poses(3))
    limits = robot.tree.joints[12:]
    assert np.all(joints[:, 12:] == joints[0, 12:])
    assert joints[0, 19] == 0.4
    assert joints[0, 13] == -joints[0, 16]  # both arms out
    for value, joint in zip(joints[0, 12:], limits, strict=True):
        assert joint.lower <= value <= joint.upper


def test_ankle_pitch_is_added_to_the_level_ankle() -> None:
    added = np.random.default_rng(11).uniform(-0.3, 0.3, size=(50, 2))
    plain = ROBOT.joint_targets(feet_poses(50))
    turned = ROBOT.joint_targets(feet_poses(50, ankle_pitch=added))
    expected = plain.copy()
    expected[:, [4, 10]] += added
    np.testing.assert_allclose(turned, expected, atol=1e-15)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_knee_only_leaves_that_share_of_the_hip_pitch_out(share: float) -> None:
    feet = dataclasses.replace(
        random_feet(100), trunk_pitch=np.zeros(100), heading=np.zeros((100, 2))
    )
    joints = ROBOT.joint_targets(dataclasses.replace(feet, knee_only=np.full((100, 2), share)))
    for k in (0, 6):
        hip_pitch, knee, ankle_pitch = joints[:, k + 2 : k + 5].T
        wanted = np.clip(-(knee + (1.0 - share) * hip_pitch), np.radians(-70), np.radians(60))
        np.testing.assert_allclose(ankle_pitch, wanted, atol=1e-12)


def test_an_added_angle_beyond_the_ankle_stops_at_its_limit() -> None:
    joints = ROBOT.joint_targets(feet_poses(1, ankle_pitch=np.array([[-3.0, 3.0]])))
    np.testing.assert_allclose(joints[0, [4, 10]], np.radians([-70.0, 60.0]), atol=1e-15)


def test_a_level_sole_beyond_the_ankle_is_infeasible() -> None:
    position = feet_poses(4).position
    position[2:, 1] = [-0.09, -0.042, -0.145]
    with pytest.raises(Infeasible) as caught:
        ROBOT.joint_targets(feet_poses(4, position=position))
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 2)
    assert "right_ankle_pitch" in caught.value.reason
    assert "its limits are -1.222 and 1.047 rad (-70.0 and 60.0 degrees)" in caught.value.reason


def test_the_first_infeasible_instant_is_reported_whatever_its_leg_and_reason() -> None:
    position = feet_poses(6).position
    position[4:, 0, 0] = 0.3  # left out of reach from tick 4
    position[2:, 1] = [-0.09, -0.042, -0.145]  # right ankle beyond its limit from tick 2
    with pytest.raises(Infeasible, match="right_ankle_pitch") as caught:
        ROBOT.joint_targets(feet_poses(6, position=position))
    assert caught.value.tick == 2
    position[:, 1] = feet_poses(6).position[:, 1]
    position[1, 0] = [-0.09, 0.042, -0.145]  # now the same leg, before it is out of reach
    with pytest.raises(Infeasible, match="left_ankle_pitch") as caught:
        ROBOT.joint_targets(feet_poses(6, position=position))
    assert caught.value.tick == 1


def test_every_parameter_can_be_set_and_says_where_its_default_comes_from() -> None:
    paths = [parameter.name for parameter in parameters(Robot)]
    assert {"mass", "leg.thigh", "sole.kind", "arm.forearm", "head.neck"} <= set(paths)
    for parameter in parameters(Robot):
        assert parameter.source.startswith("assumption"), parameter.name
        assert get_path(Robot(), parameter.name) == parameter.default
        changed = set_path(Robot(), parameter.name, parameter.default)
        assert changed == Robot()


def test_longer_legs_and_a_higher_ankle_reach_sole_and_kinematics_alike() -> None:
    robot = set_path(set_path(Robot(), "leg.thigh", 0.12), "sole.height", 0.05)
    joints = robot.joint_targets(feet_poses(1))
    poses = robot.tree.poses(*upright(1), joints)
    foot = robot.tree.index("left_foot")
    sole = poses.position[0, foot] + robot.sole.centre
    expected = 0.228 + robot.hip_offset()
    assert -sole[2] == pytest.approx(expected, abs=1e-12)
