"""A leg of axis lines: the inverse undoes the forward map, whatever the order of its axes."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.axis_leg import AxisLeg, SolePoses
from gaitlab.kinematics.transforms import vector_rotation
from gaitlab.model import Robot, Tree
from gaitlab.robots import eros, nao

THIGH, SHANK, ANKLE = 0.14, 0.15, 0.05
TURNS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
HIPS = ["".join(order) for order in permutations("xyz")]
SEED = np.array([-0.4, 0.8, -0.4])  # of hip, knee and ankle pitch: the knee ahead


def leg(hips: str, ankle: str = "yx", slide: float = 0.0) -> AxisLeg:
    """Joints of a hip in one point, a knee and an ankle below; drawn elsewhere on their lines."""
    turns = [*hips, "y", *ankle]
    heights = [0.0] * len(hips) + [-THIGH] + [-THIGH - SHANK] * len(ankle)
    axes = np.array([TURNS[turn] for turn in turns])
    points = np.array([(0.01, 0.0, z) for z in heights]) + slide * axes
    limits = np.array([(-2.0, 2.0)] * len(turns))
    limits[len(hips)] = (0.0, 2.5)
    sole = np.array([0.01, 0.0, -THIGH - SHANK - ANKLE])
    return AxisLeg(axes=axes, points=points, sole=sole, rotation=np.eye(3), limits=limits)


def standing(made: AxisLeg) -> np.ndarray:
    """Knee ahead: the pitch joints from above are hip, knee and ankle."""
    pitch = np.flatnonzero(np.abs(made.axes[:, 1]) > 0.9)
    angles = np.zeros(len(made.axes))
    angles[pitch] = SEED
    return angles


def walked(made: AxisLeg, n: int = 200) -> np.ndarray:
    """Angles about the standing ones."""
    rng = np.random.default_rng(3)
    return standing(made) + rng.uniform(-0.35, 0.35, (n, len(made.axes)))


@pytest.mark.parametrize("hips", HIPS)
def test_the_inverse_undoes_the_forward_map(hips: str) -> None:
    made = leg(hips)
    angles = walked(made)
    found = made.inverse(made.forward(angles), standing(made))
    assert found.misplaced.max() < 1e-9
    assert found.misturned.max() < 1e-9
    assert np.allclose(found.angles, angles, atol=1e-8)


@pytest.mark.parametrize("hips", HIPS)
def test_the_jacobian_is_the_derivative(hips: str) -> None:
    made, h = leg(hips), 1e-6
    angles = walked(made, 20)
    found = made.jacobian(angles)
    for joint in range(len(made.axes)):
        more, less = angles.copy(), angles.copy()
        more[:, joint] += h
        less[:, joint] -= h
        ahead, behind = made.forward(more), made.forward(less)
        assert np.allclose((ahead.position - behind.position) / (2 * h), found[:, :3, joint])
        spin = (
            (ahead.rotation - behind.rotation)
            / (2 * h)
            @ np.swapaxes(made.forward(angles).rotation, 1, 2)
        )
        assert np.allclose(spin[:, [2, 0, 1], [1, 2, 0]], found[:, 3:, joint], atol=1e-8)


@given(st.floats(-0.3, 0.3), st.sampled_from(HIPS))
def test_where_a_joint_is_drawn_on_its_line_makes_no_difference(slide: float, hips: str) -> None:
    there, here = leg(hips, slide=slide), leg(hips)
    angles = walked(here, 5)
    for one, other in zip(there.forward(angles), here.forward(angles), strict=True):
        assert np.allclose(one, other, atol=1e-12)


@given(st.floats(-3.1, 3.1), st.sampled_from(HIPS))
def test_a_turned_body_turns_the_poses_and_keeps_the_angles(yaw: float, hips: str) -> None:
    here = leg(hips)
    turn = vector_rotation((0.0, 0.0, 1.0), np.array(yaw))
    there = AxisLeg(
        axes=here.axes @ turn.T,
        points=here.points @ turn.T,
        sole=turn @ here.sole,
        rotation=turn @ here.rotation,
        limits=here.limits,
    )
    angles = walked(here, 5)
    poses = here.forward(angles)
    turned = SolePoses(poses.position @ turn.T, turn @ poses.rotation)
    assert np.allclose(there.forward(angles).position, turned.position, atol=1e-12)
    assert np.allclose(there.inverse(turned, standing(here)).angles, angles, atol=1e-8)


@pytest.mark.parametrize("hips", ["zxy", "yxz"])
def test_a_leg_without_an_ankle_roll_is_placed_and_headed_right_and_only_rolls_over(hips: str):
    made = replace(leg(hips, ankle="y"), holds=(False, True, True))
    level = SolePoses(
        np.array([[0.03, 0.02, -0.31], [0.0, -0.02, -0.30]]), np.broadcast_to(np.eye(3), (2, 3, 3))
    )
    found = made.inverse(level, standing(made))
    assert found.misplaced.max() < 1e-9
    assert found.misturned.max() < 1e-9
    forward = made.forward(found.angles).rotation[:, :, 0]
    assert np.abs(forward[:, 1:]).max() < 0.01, "toes ahead and level, whatever rolls over"


def test_limits_hold_and_what_is_out_of_reach_is_said() -> None:
    made = leg("zxy")
    far = SolePoses(np.array([[0.6, 0.0, -0.2]]), np.eye(3)[None])
    found = made.inverse(far, standing(made))
    assert found.misplaced[0] > 0.1
    assert np.all((found.angles >= made.limits[:, 0]) & (found.angles <= made.limits[:, 1]))


def test_no_instants_are_no_angles() -> None:
    made = leg("zxy")
    none = SolePoses(np.empty((0, 3)), np.empty((0, 3, 3)))
    assert made.inverse(none, standing(made)).angles.shape == (0, 6)


def axis_leg(tree: Tree, foot: str) -> tuple[AxisLeg, list[int]]:
    """The leg of one of our robots as lines, and its joints' places in the tree."""
    zero = np.zeros((1, len(tree.joints)))
    poses = tree.poses(np.zeros((1, 3)), np.eye(3)[None], zero)
    chain, link = [], tree.links[tree.index(foot)]
    while link.joint is not None:
        chain.insert(0, link)
        link = tree.links[tree.index(str(link.parent))]
    axes = np.array([_vector(found.joint.axis) for found in chain])  # type: ignore[union-attr]
    at = [tree.index(found.name) for found in chain]
    limits = np.array([(f.joint.lower, f.joint.upper) for f in chain])  # type: ignore[union-attr]
    made = AxisLeg(
        axes=axes,
        points=poses.position[0, at],
        sole=poses.position[0, at[-1]],
        rotation=np.eye(3),
        limits=limits,
    )
    names = [joint.name for joint in tree.joints]
    return made, [names.index(found.joint.name) for found in chain]  # type: ignore[union-attr]


def _vector(axis: object) -> tuple[float, float, float]:
    if isinstance(axis, tuple):
        return axis
    sign = -1.0 if str(axis).startswith("-") else 1.0
    x, y, z = (sign * part for part in TURNS[str(axis)[-1]])
    return x, y, z


@pytest.mark.parametrize(("robot", "yaw_apart"), [(eros.Robot(), True), (nao.Robot(), False)])
def test_the_closed_forms_agree(robot: Robot, yaw_apart: bool) -> None:
    """EROS' and NAO's own inverse kinematics, without which none of their walks was made."""
    rng = np.random.default_rng(5)
    names = [joint.name for joint in robot.tree.joints]
    for foot in robot.feet:
        made, places = axis_leg(robot.tree, foot)
        angles = np.zeros((300, len(names)))
        seed = standing(made)
        angles[:, places] = np.clip(
            seed + rng.uniform(-0.2, 0.2, (300, len(places))), *made.limits.T
        )
        if not yaw_apart:
            angles[:, places[0]] = 0.0
        poses = robot.tree.poses(np.zeros((300, 3)), np.tile(np.eye(3), (300, 1, 1)), angles)
        at = robot.tree.index(foot)
        wanted = SolePoses(poses.position[:, at], poses.rotation[:, at])
        for one, other in zip(made.forward(angles[:, places]), wanted, strict=True):
            assert np.allclose(one, other, atol=1e-12)
        found = made.inverse(wanted, seed)
        assert found.misplaced.max() < 1e-9
        assert np.abs(found.angles - angles[:, places]).max() < 1e-7
