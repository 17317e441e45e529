import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.gaits.nao import Gait
from gaitlab.metrics import measure
from gaitlab.model import Robot as RobotProtocol
from gaitlab.model.settings import Horizon
from gaitlab.model.tree import box_inertia
from gaitlab.parameters import parameters, set_path
from gaitlab.robots import nao
from gaitlab.robots.nao import Robot
from gaitlab.servos.files import load_servo
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Names, Trial, plugin
from gaitlab.surfaces.files import load_surface

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "nao.json").read_text())
ROBOT: RobotProtocol = Robot()


def walk(surface: str, cycles: float, seed: int = 0, **gait: float) -> Trial:
    robot = Robot()
    return Trial(
        robot=robot,
        gait=Gait(**gait),
        surface=load_surface(surface),
        servos=tuple(load_servo(str(joint.servo)) for joint in robot.tree.joints),
        horizon=Horizon(cycles=cycles),
        seed=seed,
        names=Names(robot="nao", gait="nao", surface=surface),
        robot_code=plugin("robot", "nao"),
        gait_code=plugin("gait", "nao"),
    )


def test_mass_and_centre_of_mass_are_the_reference() -> None:
    reference = GOLDEN["body_v40"]
    assert Robot().tree.mass == pytest.approx(reference["total_mass"], abs=1e-6)
    stand = Gait(stand_time=5.0).feet(np.zeros(1))
    joints = ROBOT.joint_targets(stand)
    hips = np.array([[0.0, 0.0, ROBOT.hip_offset()]])
    poses = ROBOT.tree.poses(hips, np.eye(3)[None], joints)
    found = ROBOT.tree.centre_of_mass(poses)[0]
    np.testing.assert_allclose(found, reference["com_rel_hip_centre"], atol=1e-5)


def test_every_link_has_the_published_mass_centre_and_moments() -> None:
    text = Path(nao.__file__).with_name("nao_v40_links.csv").read_text()
    published = csv.DictReader(text.splitlines())
    table = sorted(published, key=lambda row: float(row["com_x_m"]))
    links = sorted(ROBOT.tree.links, key=lambda link: link.box.centre[0])
    assert len(links) == len(table) == 25
    for row in table:
        (link,) = (
            one
            for one in links
            if one.box.centre == tuple(float(row[f"com_{a}_m"]) for a in "xyz")
            and one.name.startswith("right") == row["link"].lower().startswith("r")
        )
        # Aldebaran's total is 10 ppm above the sum of its links.
        assert link.mass == pytest.approx(float(row["mass_kg"]), rel=2e-5)
        moments = [float(row[name]) for name in ("ixx", "iyy", "izz")]
        np.testing.assert_allclose(box_inertia(link.mass, link.box.size), moments, rtol=2e-5)


def test_joints_have_the_published_limits_and_nao_s_order_in_the_legs() -> None:
    names = [joint.name for joint in ROBOT.tree.joints]
    leg = ("hip_yaw_pitch", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")
    assert names[:12] == [f"{side}_{joint}" for side in ("left", "right") for joint in leg]
    assert len(names) == 24
    by_name = {joint.name: joint for joint in ROBOT.tree.joints}
    assert np.degrees(by_name["left_hip_roll"].lower) == pytest.approx(-21.74, abs=0.01)
    assert np.degrees(by_name["right_hip_roll"].upper) == pytest.approx(21.74, abs=0.01)
    assert np.degrees(by_name["left_knee_pitch"].upper) == pytest.approx(121.04, abs=0.01)
    servos = {by_name[f"left_{name}"].servo for name in ("hip_roll", "hip_yaw_pitch", "ankle_roll")}
    assert servos == {"nao_leg_roll"}
    assert by_name["right_knee_pitch"].servo == "nao_leg_pitch"
    assert by_name["head_yaw"].servo == "nao_arm"


def test_feet_go_where_they_are_told_with_level_soles() -> None:
    gait = Gait()
    feet = gait.feet(np.linspace(0.0, gait.startup_time + gait.gait_period, 400))
    joints = ROBOT.joint_targets(feet)
    trunk = np.array([[0.0, 0.0, ROBOT.hip_offset()]]).repeat(400, axis=0)
    poses = ROBOT.tree.poses(trunk, np.eye(3)[None].repeat(400, axis=0), joints)
    for k, name in enumerate(ROBOT.feet):
        foot = ROBOT.tree.index(name)
        np.testing.assert_allclose(
            poses.rotation[:, foot], np.eye(3)[None] + np.zeros((400, 3, 3)), atol=1e-12
        )
        sole = poses.position[:, foot] - [0.0, 0.0, ROBOT.sole.height]
        np.testing.assert_allclose(sole, feet.position[:, k], atol=1e-12)


def test_tree_agrees_with_the_closed_form_of_the_legs_slanted_hips_included() -> None:
    generator = np.random.default_rng(5)
    limits = np.array([(joint.lower, joint.upper) for joint in ROBOT.tree.joints])
    joints = generator.uniform(*limits.T, size=(200, 24))
    poses = ROBOT.tree.poses(np.zeros((200, 3)), np.eye(3)[None].repeat(200, axis=0), joints)
    for k, (name, limb) in enumerate(Robot().limbs().items()):
        side = 1.0 if name == "left_leg" else -1.0
        expected = limb.forward(joints[:, 6 * k : 6 * k + 6])
        foot = ROBOT.tree.index(ROBOT.feet[k])
        hip = np.array([0.0, side * 0.05, -0.085])
        np.testing.assert_allclose(poses.position[:, foot] - hip, expected[:, :3, 3], atol=1e-12)
        np.testing.assert_allclose(poses.rotation[:, foot], expected[:, :3, :3], atol=1e-12)


def test_soles_and_sensors_mirror_each_other_and_lie_out_of_the_ankle() -> None:
    sole = ROBOT.sole
    mirror = np.array([1.0, -1.0, 1.0])
    left, right = sole.corners(0), sole.corners(1)
    assert (left[:, 1].min(), left[:, 1].max()) == pytest.approx((-0.038, 0.050))
    np.testing.assert_allclose(sorted(map(tuple, left * mirror)), sorted(map(tuple, right)))
    for foot in range(2):
        sensors, corners = sole.sensors(foot), sole.corners(foot)[:, :2]
        assert sensors is not None
        assert np.all((sensors > corners.min(axis=0)) & (sensors < corners.max(axis=0)))


def test_hips_that_would_have_to_turn_apart_are_refused() -> None:
    stand = Gait().feet(np.zeros(3))
    turned = dataclasses.replace(stand, heading=np.array([[0.0, 0.0], [0.0, 0.0], [0.3, 0.3]]))
    with pytest.raises(Infeasible, match="one motor turns both") as caught:
        ROBOT.joint_targets(turned)
    assert caught.value.tick == 2
    toes_out = dataclasses.replace(stand, heading=np.array([[0.2, -0.2]] * 3))
    joints = ROBOT.joint_targets(toes_out)
    assert np.all(joints[:, 0] == pytest.approx(joints[:, 6]))
    assert abs(joints[0, 0]) > 0.1


def test_a_shift_beyond_the_ankle_roll_is_refused_by_name() -> None:
    gait = Gait(lateral_sway=0.08)
    with pytest.raises(Infeasible, match=r"left_ankle_roll would have to turn to -0\.\d+"):
        ROBOT.joint_targets(gait.feet(np.linspace(0.0, 5.0, 500)))


def test_heavier_and_longer_robots_follow_their_parameters() -> None:
    heavy = set_path(Robot(), "mass", 6.0)
    assert heavy.tree.mass == pytest.approx(6.0)
    longer = set_path(Robot(), "leg.tibia", 0.12)
    joints = longer.joint_targets(Gait(hip_height=0.245).feet(np.zeros(1)))
    poses = longer.tree.poses(np.zeros((1, 3)), np.eye(3)[None], joints)
    foot = poses.position[0, longer.tree.index("left_foot")]
    assert foot[2] == pytest.approx(-0.085 - 0.245 + longer.sole.height, abs=1e-12)
    for parameter in parameters(Robot):
        assert parameter.source.startswith(("published", "assumption")), parameter.name


@pytest.mark.parametrize("surface", ["hard_floor", "carpet_4mm"])
def test_it_walks_and_its_sensors_carry_its_weight(surface: str) -> None:
    log = simulate(walk(surface, cycles=2.0))
    found = measure(log)
    assert not found["fell"]
    assert log.distance == pytest.approx(log.commanded_distance, rel=0.25)
    sensors = sum(
        log.vector(
            f"{side}_foot_fsr_", ("front_left", "front_right", "rear_left", "rear_right")
        ).sum(axis=1)
        for side in ("left", "right")
    )
    np.testing.assert_allclose(sensors, log.per_foot("normal_force").sum(axis=1), atol=1e-3)
    assert sensors[log.walking].mean() == pytest.approx(log.header.weight, rel=0.02)


@pytest.mark.long
def test_the_lateral_profile_as_printed_rocks_the_robot_far_more() -> None:
    profiles = ("printed", walk("hard_floor", cycles=1.0).gait.lateral_profile)
    walks = (walk("hard_floor", cycles=2.0, lateral_profile=profile) for profile in profiles)
    printed, ours = (measure(simulate(each))["roll_amplitude"] for each in walks)
    assert printed > 2.0 * ours
