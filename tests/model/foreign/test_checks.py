"""What is wrong with a foreign robot is mended and noted by name, or refused where it stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError
from gaitlab.model import Robot
from gaitlab.model.foreign.anatomy import Legs, find_legs
from gaitlab.model.foreign.checks import leg_lengths, mend, without_servo
from gaitlab.model.foreign.reading import Bodies, Body, BodyJoint, Geometry, read_urdf
from gaitlab.model.tree import box_inertia
from gaitlab.model.urdf import urdf
from gaitlab.robots import bioloid, eros, flow, nao

FILE = Path("robot.urdf")
ROBOTS = [eros.Robot(), nao.Robot(), bioloid.Robot(), flow.Robot()]
KNEE = 3  # place in a leg of eros: yaw, roll, pitch, knee


def bodies(robot: Robot = ROBOTS[0]) -> tuple[Bodies, Legs]:
    found = read_urdf(urdf(robot.tree, robot.sole, robot.feet, effort=10.0, velocity=6.0), FILE)
    return found, find_legs(found, FILE)


def notes(robot: Bodies, legs: Legs) -> tuple[str, ...]:
    return mend(robot, legs, FILE).notes


def without(robot: Bodies) -> list[str]:
    """Joints without a servo."""
    joints = [joint(robot, k) for k in range(1, len(robot.bodies))]
    return [each.name for each in joints if without_servo(each, joints)]


def with_body(robot: Bodies, place: int, **changes) -> Bodies:
    found = list(robot.bodies)
    found[place] = replace(found[place], **changes)
    return replace(robot, bodies=tuple(found))


def with_joint(robot: Bodies, place: int, **changes) -> Bodies:
    return with_body(robot, place, joint=joint(robot, place)._replace(**changes))


def joint(robot: Bodies, place: int) -> BodyJoint:
    found = robot.bodies[place].joint
    assert found is not None
    return found


def with_joints(robot: Bodies, change: Callable[[BodyJoint], BodyJoint]) -> Bodies:
    return replace(
        robot,
        bodies=tuple(
            body if body.joint is None else replace(body, joint=change(body.joint))
            for body in robot.bodies
        ),
    )


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_a_robot_that_is_well_described_is_left_alone(robot: Robot) -> None:
    found, legs = bodies(robot)
    mended = mend(found, legs, FILE)
    assert mended.notes == ()
    assert all(one is other for one, other in zip(found.bodies, mended.bodies, strict=True))


def test_a_leg_is_as_long_as_between_its_pitch_axes() -> None:
    found, legs = bodies()
    assert leg_lengths(found, legs) == pytest.approx(
        (ROBOTS[0].leg.thigh, ROBOTS[0].leg.shank), abs=1e-9
    )


@pytest.mark.parametrize("unit", [1000.0, 39.37, 0.1])
def test_lengths_in_another_unit_are_refused_at_the_hip(unit: float) -> None:
    robot, _ = bodies()
    scaled = replace(
        robot,
        bodies=tuple(replace(body, position=unit * body.position) for body in robot.bodies),
    )
    legs = find_legs(scaled, FILE)
    with pytest.raises(FileError, match="metres") as caught:
        mend(scaled, legs, FILE)
    (problem,) = caught.value.problems
    assert problem.line == joint(scaled, legs.left[0]).tag.line
    assert f"{sum(leg_lengths(scaled, legs)):.4g} m" in problem.message


def test_knees_that_contradict_each_other_are_refused_where_one_stands() -> None:
    robot, legs = bodies()
    place = legs.right[KNEE]
    knee = joint(robot, place)
    assert knee.lower + knee.upper != 0.0
    other = with_joint(robot, place, lower=-knee.upper, upper=-knee.lower)
    with pytest.raises(FileError, match="knees contradict") as caught:
        mend(other, legs, FILE)
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (knee.tag.line, knee.tag.column)
    assert knee.name in problem.message
    assert joint(robot, legs.left[KNEE]).name in problem.message


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_knee_may_be_written_about_either_end_of_its_axis(side: str) -> None:
    robot, legs = bodies()
    place = getattr(legs, side)[KNEE]
    knee = joint(robot, place)
    turned = with_joint(robot, place, axis=-knee.axis, lower=-knee.upper, upper=-knee.lower)
    assert notes(turned, legs) == ()


@pytest.mark.parametrize(("lower", "upper"), [(-np.inf, np.inf), (-1.0, 1.0), (-1.01, 1.0)])
def test_a_knee_that_may_bend_either_way_contradicts_none(lower: float, upper: float) -> None:
    robot, legs = bodies()
    found = notes(with_joint(robot, legs.right[KNEE], lower=lower, upper=upper), legs)
    assert any("no mirror images" in note for note in found)
    assert any("no range" in note for note in found) == np.isinf(upper)


PLACEHOLDERS = [(0.0, 6.0), (1000.0, 6.0), (5e4, 6.0), (10.0, 0.0), (10.0, 100.0), (1.0, 20.0)]


@pytest.mark.parametrize(("effort", "velocity"), PLACEHOLDERS)
def test_an_exporters_numbers_are_no_servo(effort: float, velocity: float) -> None:
    robot = with_joints(bodies()[0], lambda j: j._replace(effort=effort, velocity=velocity))
    assert without(robot) == [joint(robot, k).name for k in range(1, len(robot.bodies))]


def test_the_joints_without_a_servo_are_named_and_no_others() -> None:
    robot, legs = bodies()
    nameless = with_joint(robot, legs.left[0], effort=0.0)
    assert without(nameless) == [joint(robot, legs.left[0]).name]
    assert without(with_joint(robot, legs.left[0], effort=1.0)) == []  # a weak one


def test_joints_without_a_range_are_counted() -> None:
    robot, legs = bodies()
    (note,) = notes(with_joints(robot, lambda j: j._replace(lower=-np.inf, upper=np.inf)), legs)
    assert note.startswith(f"{len(robot.bodies) - 1} joints ")
    assert f"and {len(robot.bodies) - 4} more" in note


IMPOSSIBLE = {
    "larger than the robot": np.diag([100.0, 100.0, 100.0]),
    "smaller than a bolt": np.diag([1e-9, 1e-9, 1e-9]),
    "a line": np.diag([0.0, 1e-3, 1e-3]),
    "none": np.zeros((3, 3)),
    "negative": np.diag([1e-3, 1e-3, -1e-3]),
    "products too large": np.diag([1e-3] * 3) + 2e-3 * (1.0 - np.eye(3)),
    "no triangle": np.diag([1e-3, 1e-3, 3e-3]),
}


@pytest.mark.parametrize("inertia", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_an_impossible_inertia_becomes_that_of_a_box_around_the_body(inertia: np.ndarray) -> None:
    robot, legs = bodies()
    place = legs.left[KNEE]
    shin = robot.bodies[place]
    mended = mend(with_body(robot, place, inertia=inertia), legs, FILE)
    (box,) = (shape.size for shape in shin.shapes if shape.collision)
    assert np.allclose(mended.bodies[place].inertia, np.diag(box_inertia(shin.mass, box)))
    assert (mended.bodies[place].mass, mended.mass) == (shin.mass, robot.mass)
    assert np.array_equal(mended.bodies[place].centre, shin.centre)
    (note,) = mended.notes
    assert note.startswith(f"1 body ({shin.name})")
    assert all(body is mended.bodies[k] for k, body in enumerate(robot.bodies) if k != place)


@pytest.mark.parametrize("size", [None, (9.0, 9.0, 9.0)], ids=["no geometry", "too large"])
def test_without_a_fitting_box_the_body_is_a_ball_of_water(size) -> None:
    robot, legs = bodies()
    shapes = () if size is None else (
        Geometry("box", size, "", np.array([0.0, 0.0, 5.0]), np.eye(3), collision=True),
    )  # fmt: skip
    trunk = robot.bodies[0]
    wrong = with_body(robot, 0, inertia=np.eye(3) * 1e4, shapes=shapes)
    moment = 0.4 * trunk.mass * (3.0 * trunk.mass / (4e3 * np.pi)) ** (2.0 / 3.0)
    assert np.allclose(mend(wrong, legs, FILE).bodies[0].inertia, moment * np.eye(3))


@pytest.mark.parametrize("mass", [1e-6, 1e-3, 50.0])
def test_what_is_mended_once_is_right(mass: float) -> None:
    robot, legs = bodies()
    for shapes in ((), robot.bodies[legs.left[0]].shapes):
        wrong = with_body(robot, legs.left[0], mass=mass, inertia=np.zeros((3, 3)), shapes=shapes)
        once = mend(wrong, legs, FILE)
        again = mend(once, legs, FILE)
        assert again.bodies[legs.left[0]] is once.bodies[legs.left[0]]


def test_a_root_without_mass_has_no_inertia_to_mend() -> None:
    robot, legs = bodies()
    assert notes(with_body(robot, 0, mass=0.0, inertia=np.zeros((3, 3))), legs) == ()


def test_many_bodies_are_one_note() -> None:
    robot, legs = bodies()

    def wrong(body: Body) -> Body:
        return replace(body, inertia=np.zeros((3, 3)))

    (note,) = notes(replace(robot, bodies=tuple(map(wrong, robot.bodies))), legs)
    assert note.startswith(f"{len(robot.bodies)} bodies ")


@pytest.mark.parametrize(("factor", "said"), [(1.04, False), (1.06, True), (0.9, True)])
def test_legs_of_unlike_mass_are_noted(factor: float, said: bool) -> None:
    robot, legs = bodies()
    shin = robot.bodies[legs.right[KNEE]]
    found = notes(with_body(robot, legs.right[KNEE], mass=factor * shin.mass), legs)
    assert [shin.name in note and "5%" in note for note in found] == [True] * said


@pytest.mark.parametrize("place", range(6))
def test_limits_that_do_not_mirror_are_noted_by_joint(place: int) -> None:
    robot, legs = bodies()
    turned = joint(robot, legs.left[place])
    wider = with_joint(robot, legs.left[place], upper=turned.upper + 0.1)
    (note,) = notes(wider, legs)
    assert turned.name in note
    assert "mirror" in note
    about = with_joint(
        robot, legs.left[place],
        axis=-turned.axis, lower=-turned.upper, upper=-turned.lower,
    )  # fmt: skip
    assert notes(about, legs) == ()


def test_geometry_below_the_soles_is_noted() -> None:
    robot, legs = bodies()
    stick = Geometry("box", (0.02, 0.02, 2.0), "", np.zeros(3), np.eye(3), collision=True)
    trunk = robot.bodies[0]
    (note,) = notes(with_body(robot, 0, shapes=(*trunk.shapes, stick)), legs)
    assert note.startswith(f"1 body ({trunk.name})")
    assert "below the soles" in note


def test_meshes_that_are_missing_are_one_note_and_no_error(tmp_path: Path) -> None:
    robot, legs = bodies()
    shape = Geometry("mesh", (1.0,) * 3, "package://p/a.stl", np.zeros(3), np.eye(3), True)
    lost = replace(robot, bodies=tuple(replace(body, shapes=(shape,)) for body in robot.bodies))
    (note,) = mend(lost, legs, tmp_path / "robot.urdf").notes
    assert "a.stl" in note


def test_what_was_noted_before_is_kept_in_front() -> None:
    robot, legs = bodies()
    found = notes(replace(with_body(robot, 1, inertia=np.zeros((3, 3))), notes=("before",)), legs)
    assert found[0] == "before"
    assert len(found) == 2
