"""A foreign URDF as bodies: our own robots come back, the same robot in other words is the same."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Robot
from gaitlab.model.foreign.reading import LEAST_MASS, Bodies, read_urdf
from gaitlab.model.tree import box_inertia
from gaitlab.model.urdf import urdf
from gaitlab.robots import bioloid, eros, flow, nao

FILE = Path("robot.urdf")
ROBOTS = [eros.Robot(), nao.Robot(), flow.Robot(), bioloid.Robot()]
ARM = """\
<robot name="arm">
  <link name="base"><inertial><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="plate"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0.2 0"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="bolt" type="fixed"><parent link="base"/><child link="plate"/>
    <origin xyz="0 0 0.3" rpy="1.5707963267948966 0 0"/></joint>
  <joint name="wrist" type="revolute"><parent link="plate"/><child link="hand"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 0 -2"/>
    <limit lower="-1" upper="1" effort="3" velocity="4"/></joint>
</robot>
"""


def read(text: str) -> Bodies:
    return read_urdf(text, FILE)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_our_robots_come_back(robot: Robot) -> None:
    tree = robot.tree
    found = read(urdf(tree, robot.sole, robot.feet))
    assert found.mass == pytest.approx(tree.mass, abs=1e-9)
    assert [body.name for body in found.bodies[:1]] == [tree.links[0].name]
    zero = tree.poses(np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, len(tree.joints))))
    position, rotation = found.at_zero
    for body, at, turn in zip(found.bodies, position, rotation, strict=True):
        k = tree.index(body.name)
        link = tree.links[k]
        assert np.allclose(at, zero.position[0, k], atol=1e-12)
        assert np.allclose(turn, zero.rotation[0, k], atol=1e-12)
        assert np.allclose(body.centre, link.box.centre, atol=1e-12)
        moments = link.inertia or box_inertia(link.mass, link.box.size)
        assert np.allclose(body.inertia, np.diag(moments), atol=1e-9)
        if link.joint is not None:
            assert body.joint is not None
            assert (body.joint.name, body.joint.lower) == (link.joint.name, link.joint.lower)


def test_a_fixed_link_is_part_of_what_carries_it() -> None:
    base, hand = read(ARM).bodies
    assert base.links == ("base", "plate")
    turn = axis_rotation("x", np.array(np.pi / 2))
    centre = (2.0 * np.zeros(3) + 1.0 * (np.array([0, 0, 0.3]) + turn @ np.array([0, 0, 0.1]))) / 3
    assert base.mass == pytest.approx(3.0)
    assert np.allclose(base.centre, centre)
    apart = np.linalg.norm(np.array([0, 0, 0.3]) + turn @ np.array([0, 0, 0.1]))
    reduced = 2.0 / 3.0  # kg, of two masses about their common centre
    total = 0.06 + 0.003 + 2.0 * reduced * apart**2
    assert np.trace(base.inertia) == pytest.approx(total)
    assert np.allclose(base.shapes[0].position, [0.0, 0.0, 0.5])
    assert hand.joint is not None
    assert np.allclose(hand.joint.axis, [0, 0, -1])
    assert np.allclose(hand.position, [0.1, 0.0, 0.3])


def test_what_moves_without_a_mass_is_light_and_named() -> None:
    found = read(ARM)
    assert found.bodies[1].mass == LEAST_MASS
    (note,) = found.notes
    assert "1 body (hand)" in note


def test_all_that_move_without_a_mass_are_one_note() -> None:
    fingers = "".join(
        f'<link name="f{k}"/><joint name="j{k}" type="continuous">'
        f'<parent link="hand"/><child link="f{k}"/></joint>'
        for k in range(9)
    )
    (note,) = read(ARM.replace("</robot>", f"{fingers}</robot>")).notes
    assert note.startswith("10 bodies (hand, f0, f1 and 7 more)")


@pytest.mark.parametrize(
    "limit", ["", '<limit effort="3" velocity="4"/>', '<limit lower="1" upper="1"/>']
)
def test_no_range_is_any_angle(limit: str) -> None:
    text = re.sub(r"<limit[^>]*>", limit, ARM)
    joint = read(text).bodies[1].joint
    assert joint is not None
    assert (joint.lower, joint.upper) == (-np.inf, np.inf)


def test_a_world_that_a_robot_floats_in_is_no_part_of_it() -> None:
    joint = '<joint name="f" type="floating"><parent link="world"/><child link="base"/></joint>'
    world = f'<link name="world"/>{joint}'
    found = read(ARM.replace("</robot>", f"{world}</robot>"))
    assert found.bodies[0].name == "base"
    assert found.mass == read(ARM).mass


WRONG = [
    ("<robot", "<robot <", 1, "XML"),
    ('<robot name="arm">', '<!DOCTYPE r [<!ENTITY a "b">]><robot name="arm">', 1, "DOCTYPE"),
    ('<robot name="arm">', '<robot name="&arm;">', 1, "XML"),
    ('name="hand"', 'name="base"', 8, "'base'"),
    ('name="wrist"', 'name="bolt"', 11, "'bolt'"),
    ('parent link="plate"', 'parent link="fist"', 11, "'fist'"),
    ('<link name="hand"/>', '<link name="hand"/><link name="lost"/>', 8, "2 links"),
    ('child link="hand"', 'child link="fist"', 11, "'fist'"),
    ('type="revolute"', 'type="prismatic"', 11, "prismatic"),
    ('<axis xyz="0 0 -2"/>', '<axis xyz="0 0 0"/>', 12, "no axis"),
    ('<axis xyz="0 0 -2"/>', '<axis xyz="0 0"/>', 12, "3 finite numbers"),
    ('<axis xyz="0 0 -2"/>', '<axis xyz="0 0 nan"/>', 12, "3 finite numbers"),
    ('mass value="2"', 'mass value="-2"', 2, "-2 kg"),
    ('mass value="2"', 'mass value="2000"', 1, "2001"),
    ('box size="0.1 0.2 0.3"', 'box size="0.1 0.2 0"', 6, "above 0"),
    ('name="bolt"', "", 9, "no name"),
    ('<parent link="base"/><child link="plate"/>', '<parent link="base"/>', 9, "<child>"),
    ('<parent link="base"/>', '<parent link="hand"/>', None, "hang"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "words"), WRONG)
def test_a_mistake_is_named_where_it_stands(old: str, new: str, line, words) -> None:
    assert old in ARM
    with pytest.raises(FileError) as caught:
        read(ARM.replace(old, new, 1))
    (problem,) = caught.value.problems
    assert problem.file == FILE
    assert line is None or problem.line == line
    assert words is None or words in problem.message


def test_broken_xml_is_named_by_line_and_column() -> None:
    broken = ARM.replace('<link name="hand"/>', '<link name="hand" name="fist"/>')
    with pytest.raises(FileError) as caught:
        read(broken)
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (8, 1 + broken.splitlines()[7].index('name="fist'))


def test_a_robot_without_joints_is_refused() -> None:
    with pytest.raises(FileError, match="joint") as caught:
        read('<robot name="stone"><link name="stone"/></robot>')
    assert caught.value.problems[0].line == 1


def test_a_robot_without_mass_is_refused() -> None:
    without = re.sub(r"<inertial>.*?</inertial>", "", ARM, flags=re.DOTALL)
    fixed = re.sub(r'"revolute"(.*?)<axis.*?/>', r'"fixed"\1', without, flags=re.DOTALL)
    with pytest.raises(FileError, match="weighs 0 kg"):
        read(fixed)


def test_another_document_is_refused() -> None:
    with pytest.raises(FileError, match="<model>"):
        read("<model/>")


def test_a_loop_of_joints_is_refused() -> None:
    loop = ARM.replace(
        "</robot>",
        '<joint name="b" type="fixed"><parent link="hand"/><child link="base"/></joint></robot>',
    )
    with pytest.raises(FileError, match="loop"):
        read(loop)
