from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest
from pybullet_utils.bullet_client import BulletClient

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.model import LinkPoses
from gaitlab.model import Robot as AnyRobot
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.model.tree import box_inertia
from gaitlab.model.urdf import urdf
from gaitlab.parameters import set_path
from gaitlab.robots.bioloid import Robot as Bioloid
from gaitlab.robots.eros import Robot
from gaitlab.robots.nao import Robot as Nao

POSITION = 1e-6  # m, Bullet's joint angles are exact, its poses nearly so
ROTATION = 2e-6  # -, of six turns that each leave a unit quaternion by some 1e-7


ROBOTS = {
    "flat": Robot(),
    "studs": set_path(Robot(), "sole.kind", "studs"),
    "slanted hips and soles off the ankle": Nao(),
    "no hip yaw and a waist": Bioloid(),
}


@pytest.fixture(params=ROBOTS.values(), ids=ROBOTS.keys())
def robot(request: pytest.FixtureRequest) -> AnyRobot:
    return request.param


@pytest.fixture
def client() -> Iterator[BulletClient]:
    client = BulletClient(pybullet.DIRECT)
    yield client
    client.disconnect()


def load(client: BulletClient, robot: AnyRobot, folder: Path) -> int:
    file = folder / "robot.urdf"
    file.write_text(urdf(robot.tree, robot.sole, robot.feet))
    return client.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)


def bullet_poses(client: BulletClient, body: int, robot: AnyRobot) -> LinkPoses:
    """Link frames of all links as Bullet has them, the trunk first."""
    offset = client.getDynamicsInfo(body, -1)[3:5]
    base = client.getBasePositionAndOrientation(body)
    trunk = client.multiplyTransforms(*base, *client.invertTransform(*offset))
    names = [client.getJointInfo(body, k)[12].decode() for k in range(client.getNumJoints(body))]
    poses = {
        name: client.getLinkState(body, k, computeForwardKinematics=True)[4:6]
        for k, name in enumerate(names)
    } | {"trunk": trunk}
    position, quaternion = zip(*(poses[link.name] for link in robot.tree.links), strict=True)
    return LinkPoses(np.array([position]), rotation_of(np.array([quaternion])))


def test_loaded_masses_and_inertias_equal_the_trees(
    client: BulletClient, robot: AnyRobot, tmp_path: Path
) -> None:
    body = load(client, robot, tmp_path)
    joints = len(robot.tree.joints)
    names = {client.getJointInfo(body, k)[12].decode(): k for k in range(joints)} | {"trunk": -1}
    assert set(names) == {link.name for link in robot.tree.links}
    total = 0.0
    for link in robot.tree.links:
        info = client.getDynamicsInfo(body, names[link.name])
        total += info[0]
        assert info[0] == pytest.approx(link.mass, rel=1e-12)
        assert info[2] == pytest.approx(box_inertia(link.mass, link.box.size), rel=1e-9)
        assert info[3] == pytest.approx(link.box.centre, abs=1e-12)
    assert total == pytest.approx(robot.tree.mass, rel=1e-12)


def test_loaded_link_poses_equal_the_trees(
    client: BulletClient, robot: AnyRobot, tmp_path: Path
) -> None:
    body = load(client, robot, tmp_path)
    joints = np.random.default_rng(12).uniform(-1.5, 1.5, (20, len(robot.tree.joints)))
    for angles in joints:
        for k, angle in enumerate(angles):
            client.resetJointState(body, k, angle)
        found = bullet_poses(client, body, robot)
        start = found.position[:, 0], found.rotation[:, 0]
        expected = robot.tree.poses(*start, angles[None])
        np.testing.assert_allclose(found.position, expected.position, atol=POSITION)
        np.testing.assert_allclose(found.rotation, expected.rotation, atol=ROTATION)


def test_loaded_joints_come_in_order_with_their_limits(
    client: BulletClient, robot: AnyRobot, tmp_path: Path
) -> None:
    body = load(client, robot, tmp_path)
    for k, joint in enumerate(robot.tree.joints):
        info = client.getJointInfo(body, k)
        assert info[1].decode() == joint.name
        assert info[2] == pybullet.JOINT_REVOLUTE
        assert info[8:10] == pytest.approx((joint.lower, joint.upper), abs=1e-12)
        assert min(info[10], info[11]) > 0.0


def test_spheres_of_the_feet_touch_the_sole_at_its_supports(
    client: BulletClient, robot: AnyRobot, tmp_path: Path
) -> None:
    body = load(client, robot, tmp_path)
    for foot, name in enumerate(robot.feet):
        index = robot.tree.index(name) - 1
        shapes = client.getCollisionShapeData(body, index)
        centre_of_mass = np.array(client.getDynamicsInfo(body, index)[3])
        spheres = [shape for shape in shapes if shape[2] == pybullet.GEOM_SPHERE]
        assert len(spheres) == len(shapes) == len(robot.sole.supports(foot))
        assert {shape[3][0] for shape in spheres} == {SUPPORT_RADIUS}
        lowest = np.array([shape[5] for shape in spheres]) + centre_of_mass
        lowest[:, 2] -= SUPPORT_RADIUS
        np.testing.assert_allclose(lowest, robot.sole.supports(foot), atol=1e-12)


def test_only_feet_touch_a_plane_at_the_soles_height(
    client: BulletClient, robot: AnyRobot, tmp_path: Path
) -> None:
    body = load(client, robot, tmp_path)
    straight = robot.tree.poses(
        np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, len(robot.tree.joints)))
    )
    feet = [robot.tree.index(name) for name in robot.feet]
    leg = robot.sole.height - straight.position[0, feet[0], 2]
    offset = client.getDynamicsInfo(body, -1)[3]
    client.resetBasePositionAndOrientation(body, np.add(offset, [0.0, 0.0, leg]), (0, 0, 0, 1))
    plane = client.createCollisionShape(pybullet.GEOM_PLANE)
    client.createMultiBody(0.0, plane)
    client.performCollisionDetection()
    contacts = client.getContactPoints(body)
    assert {contact[3] for contact in contacts} == {foot - 1 for foot in feet}
    for side, foot in enumerate(feet):
        found = np.array([contact[5][:2] for contact in contacts if contact[3] == foot - 1])
        expected = (robot.sole.supports(side) + straight.position[0, foot])[:, :2]
        order, wanted = np.lexsort(found.round(5).T), np.lexsort(expected.round(5).T)
        np.testing.assert_allclose(found[order], expected[wanted], atol=1e-6)
    assert max(abs(contact[8]) for contact in contacts) < 1e-6


def test_text_is_broken_into_lines_and_states_every_inertia_and_limit() -> None:
    robot = Robot()
    text = urdf(robot.tree, robot.sole, robot.feet, effort=12.5, velocity=7.0)
    assert max(map(len, text.splitlines())) < 200
    root = ElementTree.fromstring(text)
    assert len(root.findall("link/inertial/inertia")) == len(robot.tree.links)
    limits = [limit.attrib for limit in root.findall("joint/limit")]
    assert {(limit["effort"], limit["velocity"]) for limit in limits} == {("12.5", "7.0")}


def test_the_same_robot_gives_the_same_text() -> None:
    one, other = Robot(), Robot()
    assert urdf(one.tree, one.sole, one.feet) == urdf(other.tree, other.sole, other.feet)


def test_a_foot_that_is_no_link_is_refused() -> None:
    robot = Robot()
    with pytest.raises(ValueError, match="left_paw"):
        urdf(robot.tree, robot.sole, ("left_paw", "right_foot"))
