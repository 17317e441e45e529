"""A robot from its URDF is the robot: the same numbers, the same targets, the same walk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError, Infeasible
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.walk import Gait
from gaitlab.kinematics.transforms import axis_rotation, rotation_of
from gaitlab.model import Robot, Tree
from gaitlab.model.foreign.anatomy import find_legs
from gaitlab.model.foreign.meshes import vertices_of_all
from gaitlab.model.foreign.reading import Bodies
from gaitlab.model.foreign.reduced import Overrides, Reduced, reduced
from gaitlab.model.foreign.robot_file import Loaded, load_robot
from gaitlab.model.stance import stance_of, standing_feet
from gaitlab.model.urdf import urdf
from gaitlab.parameters import get_path, parameters, set_path
from gaitlab.robots import bioloid, eros, flow, nao
from gaitlab.simulation.simulate import engine_for, simulate
from gaitlab.simulation.trial import Trial
from tests.driven import drive
from tests.model.foreign.test_anatomy import bodies, mirrored, renamed, slid, turned

FILE = Path("robot.urdf")
ROBOTS = [eros.Robot(), nao.Robot(), bioloid.Robot(), flow.Robot()]
each = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
CLOSED = [eros.Robot(), flow.Robot()]
CLOSE = 1e-9
OVERRIDES = Overrides(posture=lambda _: None, servo=lambda _: "mx_28", sole={})


def reduction(robot: Bodies) -> Reduced:
    vertices = vertices_of_all(robot, FILE, [])
    return reduced(robot, find_legs(robot, FILE), vertices, OVERRIDES)


def read_back(robot: Robot, folder: Path, change=lambda text: text) -> Loaded:
    file = folder / f"{robot.name}_again.urdf"
    file.write_text(change(urdf(robot.tree, robot.sole, robot.feet)))
    return load_robot(file)


def numbers(found: Reduced) -> np.ndarray:
    """All numbers of a reduced robot but for the signs of its axes."""
    links = [
        [*link.origin, link.mass, *link.centre, *link.moments, *link.box.size, *link.box.centre]
        for link in found.tree.links
    ]
    legs = [
        np.concatenate([np.abs(leg.axes).ravel(), leg.points.ravel(), leg.ankle]).ravel()
        for leg in found.legs
    ]
    return np.concatenate([np.ravel(links), *legs, found.sole])


@each
@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_a_turned_root_is_the_same_robot(robot: Robot, quarter: int) -> None:
    yaw = quarter * np.pi / 2.0
    before, after = reduction(bodies(robot)), reduction(turned(bodies(robot), yaw))
    if robot.name != "bioloid":  # its waist makes the root heavier than what the turn moves
        assert numbers(after)[13:] == pytest.approx(numbers(before)[13:], abs=1e-7)
    assert tuple(after.sole) == pytest.approx(tuple(before.sole), abs=CLOSE)
    for one, other in zip(before.legs, after.legs, strict=True):
        assert other.points == pytest.approx(one.points, abs=CLOSE)
        assert other.axes == pytest.approx(one.axes, abs=CLOSE)


@each
@pytest.mark.parametrize("seed", range(3))
def test_a_joint_drawn_elsewhere_on_its_axis_is_the_same_robot(robot: Robot, seed: int) -> None:
    before, after = reduction(bodies(robot)), reduction(slid(bodies(robot), seed))
    assert numbers(after) == pytest.approx(numbers(before), abs=1e-7)


@each
def test_other_names_are_the_same_robot(robot: Robot) -> None:
    before, after = reduction(bodies(robot)), reduction(renamed(bodies(robot), 5))
    assert numbers(after) == pytest.approx(numbers(before), abs=1e-12)


@pytest.mark.parametrize("robot", [eros.Robot(), flow.Robot()], ids=lambda robot: robot.name)
def test_a_mirrored_file_has_left_and_right_exchanged_and_nothing_else(robot: Robot) -> None:
    found = renamed(bodies(robot), 3)
    before, after = reduction(found), reduction(mirrored(found))
    assert after.feet == before.feet[::-1]
    assert tuple(after.sole) == pytest.approx(tuple(before.sole), abs=1e-7)
    for one, other in zip(before.legs, after.legs, strict=True):
        assert np.abs(other.axes) == pytest.approx(np.abs(one.axes), abs=CLOSE)
        assert other.points == pytest.approx(one.points, abs=CLOSE)


@each
def test_mass_inertia_and_soles_come_back(robot: Robot, tmp_path: Path) -> None:
    again = read_back(robot, tmp_path).cls()
    tree, sole = robot.tree, robot.sole
    assert again.tree.mass == pytest.approx(tree.mass, abs=CLOSE)
    assert again.feet == robot.feet
    assert again.sole.length == pytest.approx(sole.length, abs=1e-6)
    assert again.sole.width == pytest.approx(sole.width, abs=1e-6)
    zero = np.zeros((1, len(tree.joints)))
    upright = np.eye(3)[None]
    ours = tree.poses(np.array([[0.0, 0.0, robot.hip_offset()]]), upright, zero)
    theirs = again.tree.poses(np.zeros((1, 3)), upright, np.zeros((1, len(again.tree.joints))))
    com = [t.centre_of_mass(p)[0] for t, p in ((tree, ours), (again.tree, theirs))]
    assert (com[1] - com[0])[1:2] == pytest.approx([0.0], abs=1e-7)
    centres = []
    for made, poses in ((robot, ours), (again, theirs)):
        for side, foot in enumerate(made.feet):
            k = made.tree.index(foot)
            at = poses.position[0, k] + poses.rotation[0, k] @ made.sole.centre_of(side)
            centres.append(at)
    assert centres[0] - centres[2] == pytest.approx(com[0] - com[1], abs=1e-6)
    assert centres[1] - centres[3] == pytest.approx(com[0] - com[1], abs=1e-6)


def whole_inertia(tree: Tree, joints: np.ndarray) -> np.ndarray:
    """Inertia of a robot in a pose about its centre of mass, in [kg m^2]. Shape (3, 3)."""
    poses = tree.poses(np.zeros((1, 3)), np.eye(3)[None], joints[None])
    centre, tensor = tree.centre_of_mass(poses)[0], np.zeros((3, 3))
    for k, link in enumerate(tree.links):
        xx, yy, zz, xy, xz, yz = link.moments
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        turn = poses.rotation[0, k]
        arm = poses.position[0, k] + turn @ np.array(link.centre) - centre
        tensor += turn @ own @ turn.T + link.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return tensor


@pytest.mark.parametrize("robot", [eros.Robot(), nao.Robot()], ids=lambda robot: robot.name)
def test_the_same_targets_and_the_same_robot_at_them(robot: Robot, tmp_path: Path) -> None:
    again = read_back(robot, tmp_path).cls()
    gait = Gait(**Gait.suited_to(robot))
    feet = gait.feet(np.linspace(0.0, gait.startup_time + gait.gait_period, 400))
    ours, theirs = robot.joint_targets(feet), again.joint_targets(feet)
    names = [[joint.name for joint in made.tree.joints] for made in (robot, again)]
    legs = [k for k, name in enumerate(names[0]) if name in again.found.legs[0].joints]
    legs += [k for k, name in enumerate(names[0]) if name in again.found.legs[1].joints]
    same = [names[1].index(names[0][k]) for k in legs]
    assert theirs[:, same] == pytest.approx(ours[:, legs], abs=1e-7)
    posed = np.array([theirs[7][names[1].index(name)] for name in names[0]])
    there = whole_inertia(again.tree, theirs[7])
    assert there == pytest.approx(whole_inertia(robot.tree, posed), abs=CLOSE)


@each
def test_it_stands_with_its_centre_of_mass_over_its_soles(robot: Robot, tmp_path: Path) -> None:
    again = read_back(robot, tmp_path).cls()
    stance = stance_of(again)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    joints = again.joint_targets(feet)
    poses = again.tree.poses(np.zeros((1, 3)), np.eye(3)[None], joints)
    com = again.tree.centre_of_mass(poses)[0]
    k = again.tree.index(again.feet[0])
    sole = poses.position[0, k] + poses.rotation[0, k] @ again.sole.centre_of(0)
    assert com[0] == pytest.approx(sole[0], abs=1e-4)
    assert -sole[2] == pytest.approx(stance.hip_height, abs=1e-6)


def trial_of(robot: str, folder: Path, seconds: float, *settings: str) -> Trial:
    file = folder / "experiment.yaml"
    file.write_text(
        f"title: A walk\nrobot: {robot}\ngait: walk\nsurfaces: [hard_floor]\nseeds: 1\n"
        f"horizon: {{cycles: 1000, time: {seconds}, distance: 100}}\n"
    )
    experiment = load_experiment(file, settings)
    return next(iter(plan(experiment).trials())).trial


@pytest.mark.parametrize("products", [(0.0, 0.0, 0.0), (3e-3, -4e-3, 2e-3)])
def test_it_begins_upright_on_level_soles_whatever_its_trunk_is(products, tmp_path: Path) -> None:
    """Bullet's own frame of a trunk with products of inertia is turned."""
    xy, xz, yz = products
    first = 'ixy="0.0" ixz="0.0" iyz="0.0"'
    read_back(
        eros.Robot(),
        tmp_path,
        lambda text: text.replace(first, f'ixy="{xy}" ixz="{xz}" iyz="{yz}"', 1),
    )
    trial = trial_of("./eros_again.urdf", tmp_path, 1.0, "spread.tilt=0")
    feet = trial.gait.feet(np.arange(100) * trial.engine.dt)
    with engine_for(trial, feet) as engine:
        assert rotation_of(engine.trunk[3:7]) == pytest.approx(np.eye(3), abs=1e-6)
        tape = drive(engine, trial.robot.joint_targets(feet))
    assert not tape.body_touches.any()
    assert rotation_of(tape.trunk[-1, 3:7])[2, 2] > np.cos(np.radians(2.0))


def test_a_robot_walks_from_its_urdf_alone_and_its_log_is_one(tmp_path: Path) -> None:
    read_back(eros.Robot(), tmp_path)
    trial = trial_of("./eros_again.urdf", tmp_path, 1.0, "robot.mass=3.5", "robot.sole.length=0.13")
    log = simulate(trial)
    assert log.header.mass == pytest.approx(3.5)
    assert log.header.sole_length == 0.13
    assert log["fall_cause"].max() == 0
    rebuilt = Trial.from_dict(trial.to_dict())
    assert rebuilt.id == trial.id
    assert np.array_equal(simulate(rebuilt)["trunk_x"], log["trunk_x"])


def test_comments_and_folders_change_no_trial_and_numbers_do(tmp_path: Path) -> None:
    trials = []
    for k, change in enumerate(
        (
            lambda text: text,
            lambda text: text.replace("<robot", "<!-- ours -->\n<robot"),
            lambda text: text.replace('mass value="', 'mass value="0'),
            lambda text: text.replace('mass value="', 'mass value="1', 1),
        )
    ):
        folder = tmp_path / str(k)
        folder.mkdir()
        read_back(eros.Robot(), folder, change)
        trials.append(trial_of("./eros_again.urdf", folder, 1.0).id)
    assert trials[0] == trials[1] == trials[2]
    assert trials[3] != trials[0]


def test_every_number_of_a_robot_file_is_a_parameter(tmp_path: Path) -> None:
    read_back(nao.Robot(), tmp_path)
    file = tmp_path / "mine.yaml"
    file.write_text(
        "urdf: ./nao_again.urdf\nservos: {default: mx_106, '.*ankle.*': "
        "{stall_torque: 3.0, no_load_speed: 6.0}}\nmass: {value: 5.5, unit: kg, source: scales}\n"
        "posture: {'.*_shoulder_pitch': 1.2}\nsole: {width: 0.08, kind: studs}\n"
    )
    robot = load_robot(file).cls()
    assert robot.tree.mass == pytest.approx(5.5)
    assert (robot.sole.width, robot.sole.kind) == (0.08, "studs")
    assert robot.posture.left_shoulder_pitch == robot.posture.right_shoulder_pitch == 1.2
    servos = {joint.name: joint.servo for joint in robot.tree.joints}
    assert servos["left_knee_pitch"] == "mx_106"
    assert robot.own_servos[servos["left_ankle_roll"]].stall_torque == 3.0
    for item in parameters(type(robot)):
        if item.type is float:
            value = get_path(robot, item.name)
            inside = value + 0.01 * ((item.high or 1.0) - value)
            changed = set_path(robot, item.name, inside)
            assert get_path(changed, item.name) == inside
    joints = [joint.name for joint in robot.tree.joints]
    bent = set_path(robot, "posture.left_elbow_yaw", -1.0)
    stance = stance_of(robot)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    assert bent.joint_targets(feet)[0, joints.index("left_elbow_yaw")] == -1.0


def test_the_walk_says_which_limb_cannot_reach(tmp_path: Path) -> None:
    robot = read_back(eros.Robot(), tmp_path).cls()
    stance = stance_of(robot)
    far = standing_feet(1.2 * stance.leg_length, stance.step_width, 0.0)
    with pytest.raises(Infeasible) as raised:
        robot.joint_targets(far)
    assert raised.value.limb == "left_leg"


def test_a_foot_without_geometry_is_asked_for(tmp_path: Path) -> None:
    import re

    read_back(eros.Robot(), tmp_path)
    text = (tmp_path / "eros_again.urdf").read_text()
    bare = re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.S)
    (tmp_path / "bare.urdf").write_text(bare)
    with pytest.raises(FileError, match="sole"):
        load_robot(tmp_path / "bare.urdf")
    file = tmp_path / "mine.yaml"
    file.write_text(
        "urdf: ./bare.urdf\nsole: {length: 0.14, width: 0.08, heel: 0.06, height: 0.03}\n"
    )
    sole = load_robot(file).cls().sole
    assert (sole.length, sole.width, sole.heel) == (0.14, 0.08, pytest.approx(0.06))
    assert sole.height == pytest.approx(0.03)


def test_a_tilted_foot_has_a_level_sole_when_it_stands(tmp_path: Path) -> None:
    """A sole that is turned against its link at zero angles is turned back by the ankle."""
    tilt = 0.25
    robot = eros.Robot()
    chain = bodies(robot)
    boxed = tuple(
        replace(b, shapes=tuple(s for s in b.shapes if s.kind == "box")) for b in chain.bodies
    )
    chain = replace(chain, bodies=boxed)
    lean = axis_rotation("y", np.array(tilt))
    tilted = []
    for body in chain.bodies:
        if body.name in robot.feet:
            shapes = tuple(
                s._replace(position=lean @ s.position, rotation=lean @ s.rotation)
                for s in body.shapes
                if s.kind == "box"  # a ball touches elsewhere when it is turned
            )
            body = replace(body, shapes=shapes)
        tilted.append(body)
    before, after = reduction(chain), reduction(replace(chain, bodies=tuple(tilted)))
    assert after.tilt == pytest.approx(tilt, abs=1e-6)
    assert tuple(after.sole) == pytest.approx(tuple(before.sole), abs=1e-6)


def test_a_xacro_is_expanded_with_what_it_includes(tmp_path: Path) -> None:
    plain = read_back(eros.Robot(), tmp_path).cls()
    text = (tmp_path / "eros_again.urdf").read_text()
    parts = tmp_path / "my_description" / "urdf"
    parts.mkdir(parents=True)
    inside = text[text.index("<link") : text.index("</robot>")]
    space = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    (parts / "body.xacro").write_text(f"<robot {space}>{inside}</robot>")
    main = parts / "mine.urdf.xacro"
    main.write_text(
        f'<robot name="mine" {space}>'
        '<xacro:include filename="$(find my_description)/urdf/body.xacro"/></robot>'
    )
    assert load_robot(main).cls().tree == plain.tree
    main.write_text(main.read_text().replace("body.xacro", "nobody.xacro"))
    with pytest.raises(FileError, match="nobody"):
        load_robot(main)


@pytest.mark.parametrize(("effort", "stated"), [("10.0", True), ("80.0", False), ("1000.0", False)])
def test_a_torque_that_no_servo_of_such_a_robot_has_is_no_servo(tmp_path, effort, stated) -> None:
    loaded = read_back(
        eros.Robot(),
        tmp_path,
        lambda text: text.replace('effort="1000.0"', f'effort="{effort}"').replace(
            'velocity="100.0"', 'velocity="6.0"'
        ),
    )
    torques = {servo.stall_torque for servo in loaded.cls().own_servos.values()}
    assert (torques == {float(effort)}) is stated
    assert (loaded.unstated == ()) is stated
    assert max(torques) < 20.0


def test_names_that_only_signs_tell_apart_are_refused(tmp_path: Path) -> None:
    def rename(text: str) -> str:
        return text.replace('"left_hip_yaw"', '"hip/yaw"').replace('"right_hip_yaw"', '"hip yaw"')

    with pytest.raises(FileError, match="hip_yaw"):
        read_back(eros.Robot(), tmp_path, rename)
    spaced = read_back(nao.Robot(), tmp_path, lambda text: text.replace('"head_yaw"', '"head/yaw"'))
    assert "head_yaw" in spaced.found.held


@pytest.mark.parametrize("side", [0, 1])
def test_a_foot_without_geometry_has_the_mirror_image_of_the_other_sole(side: int) -> None:
    whole = bodies(eros.Robot())
    bare = replace(
        whole,
        bodies=tuple(
            replace(body, shapes=()) if body.name == eros.Robot().feet[side] else body
            for body in whole.bodies
        ),
    )
    before, after = reduction(whole), reduction(bare)
    assert tuple(after.sole) == pytest.approx(tuple(before.sole), abs=1e-9)
    for one, other in zip(before.legs, after.legs, strict=True):
        assert other.rotation == pytest.approx(one.rotation, abs=1e-9)
