"""Legs are found by geometry: the same legs whatever the file calls, turns, mirrors or slides."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Robot
from gaitlab.model.foreign.anatomy import Legs, find_legs, lines_of, roles
from gaitlab.model.foreign.reading import Bodies, Body, read_urdf
from gaitlab.model.urdf import urdf
from gaitlab.robots import bioloid, biped, eros, flow, nao

FILE = Path("robot.urdf")
ROBOTS = [eros.Robot(), nao.Robot(), bioloid.Robot(), flow.Robot()]
each = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
FLIP = np.diag([1.0, -1.0, 1.0])


def bodies(robot: Robot) -> Bodies:
    return read_urdf(urdf(robot.tree, robot.sole, robot.feet), FILE)


def feet(robot: Bodies, legs: Legs) -> list[str]:
    return [robot.bodies[leg[-1]].name for leg in (legs.left, legs.right)]


def changed(robot: Bodies, change) -> Bodies:
    """Every body made another one."""
    return replace(robot, bodies=tuple(change(k, body) for k, body in enumerate(robot.bodies)))


def moved(body: Body, turn: np.ndarray, by: np.ndarray) -> Body:
    """A body whose mass and shapes are turned and then moved in its frame."""
    shapes = tuple(
        shape._replace(position=turn @ shape.position + by, rotation=turn @ shape.rotation)
        for shape in body.shapes
    )
    return replace(
        body,
        centre=turn @ body.centre + by,
        inertia=turn @ body.inertia @ turn.T,
        shapes=shapes,
    )


def turned(robot: Bodies, yaw: float) -> Bodies:
    """The root's frame turned about z: everything on it is turned the other way."""
    turn = axis_rotation("z", np.array(-yaw))

    def change(k: int, body: Body) -> Body:
        if body.parent == -1:
            return moved(body, turn, np.zeros(3))
        if body.parent != 0:
            return body
        return replace(body, position=turn @ body.position, rotation=turn @ body.rotation)

    return changed(robot, change)


def slid(robot: Bodies, seed: int) -> Bodies:
    """Every joint drawn elsewhere on its axis, what it carries where it was."""
    rng = np.random.default_rng(seed)
    shifts = [
        np.zeros(3) if body.joint is None else rng.uniform(-0.05, 0.05) * body.joint.axis
        for body in robot.bodies
    ]

    def change(k: int, body: Body) -> Body:
        if body.joint is None:
            return body
        at = body.position + body.rotation @ shifts[k] - shifts[body.parent]
        return moved(replace(body, position=at), np.eye(3), -shifts[k])

    return changed(robot, change)


def renamed(robot: Bodies, seed: int) -> Bodies:
    """Names that say nothing."""
    draw = random.Random(seed)

    def change(k: int, body: Body) -> Body:
        name = f"b{draw.randrange(10**9)}"
        joint = None if body.joint is None else body.joint._replace(name=f"j{name}")
        return replace(body, name=name, joint=joint)

    return changed(robot, change)


def mirrored(robot: Bodies) -> Bodies:
    """The robot in a mirror across y."""

    def change(k: int, body: Body) -> Body:
        joint = body.joint
        if joint is not None:
            joint = joint._replace(axis=-FLIP @ joint.axis)
        shapes = tuple(
            s._replace(position=FLIP @ s.position, rotation=FLIP @ s.rotation @ FLIP)
            for s in body.shapes
        )
        return replace(
            body,
            position=FLIP @ body.position,
            rotation=FLIP @ body.rotation @ FLIP,
            joint=joint,
            centre=FLIP @ body.centre,
            inertia=FLIP @ body.inertia @ FLIP,
            shapes=shapes,
        )

    return changed(robot, change)


@each
def test_our_robots_have_the_legs_that_they_say(robot: Robot) -> None:
    found = bodies(robot)
    legs = find_legs(found, FILE)
    assert feet(found, legs) == list(robot.feet)
    assert found.bodies[legs.pelvis].name == robot.tree.links[0].name or robot.name == "flow"
    assert np.allclose(legs.base, np.eye(3))
    assert legs.apart < 1e-6
    assert legs.named[0] == legs.named[1] > 0


@each
@pytest.mark.parametrize("quarter", range(4))
def test_the_yaw_of_the_root_makes_no_difference(robot: Robot, quarter: int) -> None:
    yaw = quarter * np.pi / 2.0
    here, there = bodies(robot), turned(bodies(robot), yaw)
    before, after = find_legs(here, FILE), find_legs(there, FILE)
    assert (after.left, after.right) == (before.left, before.right)
    assert np.allclose(after.base @ axis_rotation("z", np.array(-yaw)), before.base)
    one, other = (
        lines_of(b, legs.left).axes @ legs.base.T for b, legs in ((here, before), (there, after))
    )
    assert np.allclose(one, other)


@each
@pytest.mark.parametrize("seed", range(3))
def test_where_joints_are_drawn_makes_no_difference(robot: Robot, seed: int) -> None:
    before = find_legs(bodies(robot), FILE)
    after = find_legs(slid(bodies(robot), seed), FILE)
    assert (after.left, after.right, after.pelvis) == (before.left, before.right, before.pelvis)
    assert np.allclose(after.base, before.base)
    assert np.allclose(after.middle, before.middle, atol=1e-9)


@each
def test_without_names_the_left_leg_is_on_the_positive_side(robot: Robot) -> None:
    found = bodies(robot)
    before, after = find_legs(found, FILE), find_legs(renamed(found, 7), FILE)
    assert (after.left, after.right) == (before.left, before.right)
    assert after.named == (0, 0)
    assert np.allclose(after.base, before.base)


@each
def test_a_mirror_exchanges_what_is_left_and_nothing_else(robot: Robot) -> None:
    found = renamed(bodies(robot), 3)
    before, after = find_legs(found, FILE), find_legs(mirrored(found), FILE)
    assert (after.left, after.right) == (before.right, before.left)
    assert np.allclose(after.base, before.base)
    axes = [lines_of(found, before.left).axes, lines_of(mirrored(found), after.right).axes]
    assert roles(axes[0]) == roles(axes[1])


def test_names_decide_when_the_root_looks_backwards() -> None:
    found = bodies(eros.Robot())
    legs = find_legs(turned(found, np.pi), FILE)
    assert feet(found, legs) == list(eros.Robot().feet)
    assert np.allclose(legs.base[0], [-1.0, 0.0, 0.0])


def test_one_leg_is_no_robot_that_walks_and_the_chains_are_named() -> None:
    found = bodies(eros.Robot())
    legs = find_legs(found, FILE)
    lost = {*legs.right}
    kept = [k for k in range(len(found.bodies)) if k not in lost]
    places = {k: place for place, k in enumerate(kept)}
    one = tuple(
        replace(found.bodies[k], parent=places.get(found.bodies[k].parent, -1)) for k in kept
    )
    with pytest.raises(FileError, match=found.bodies[legs.left[-1]].name):
        find_legs(replace(found, bodies=one), FILE)


def test_roles_say_slanted_axes_in_small_letters() -> None:
    axes = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0.0, 0.6, 0.8]])
    assert roles(axes) == "YRPPy"


def test_straight_legs_on_belts_are_two_short_for_legs() -> None:
    with pytest.raises(FileError):
        find_legs(bodies(biped.Robot()), FILE)
