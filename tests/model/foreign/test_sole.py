"""The sole of a foot: a box's lower face, whatever stands on it and however it is turned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model.foreign.reading import Geometry
from gaitlab.model.foreign.sole import corners, find_sole

BASE = np.eye(3)
SIZE = (0.16, 0.08, 0.02)


def box(size=SIZE, position=(0.0, 0.0, 0.0), rotation=BASE) -> Geometry:
    return Geometry("box", size, "", np.array(position), np.asarray(rotation), collision=True)


@given(
    pitch=st.floats(-0.5, 0.5), roll=st.floats(-0.5, 0.5), yaw=st.floats(-3.1, 3.1),
    at=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)  # fmt: skip
def test_a_tilted_box_stands_on_its_lower_face(pitch: float, roll: float, yaw: float, at) -> None:
    tilt = axis_rotation("y", np.array(pitch)) @ axis_rotation("x", np.array(roll))
    turn = axis_rotation("z", np.array(yaw))
    found = find_sole(corners([box(position=at, rotation=turn @ tilt)]), turn.T)
    assert found is not None
    # Seen along the robot's forward a face that rolls is a little turned in its own plane.
    assert found.length == pytest.approx(SIZE[0], abs=0.03)
    assert found.tilt == pytest.approx(np.arccos(tilt[2, 2]), abs=1e-6)
    assert np.allclose(found.centre, np.array(at) + turn @ tilt @ [0.0, 0.0, -0.01], atol=1e-9)
    assert np.allclose(found.rotation.T @ found.rotation, np.eye(3), atol=1e-12)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)


@given(st.floats(-0.5, 0.5))
def test_a_pitched_box_has_its_own_length_and_width(pitch: float) -> None:
    turn = axis_rotation("y", np.array(pitch))
    found = find_sole(corners([box(rotation=turn)]), BASE)
    assert found is not None
    assert (found.length, found.width) == pytest.approx(SIZE[:2])
    assert np.allclose(found.rotation, turn, atol=1e-9)


def test_what_stands_on_a_sole_does_not_make_it_larger() -> None:
    shin = box((0.05, 0.05, 0.3), (0.0, 0.0, 0.16))
    shell = Geometry("sphere", (0.05,), "", np.array([0.0, 0.0, 0.06]), BASE, collision=True)
    found = find_sole(corners([box(), shin, shell]), BASE)
    assert found is not None
    assert (found.length, found.width, found.tilt) == pytest.approx((*SIZE[:2], 0.0))


def test_a_toe_that_bends_up_does_not_tilt_a_flat_sole() -> None:
    toe = [[0.12, y, -0.01 + 0.04 * np.tan(np.radians(2.5))] for y in (-0.04, 0.04)]
    found = find_sole(np.vstack([corners([box()]), toe]), BASE)
    assert found is not None
    assert found.tilt == pytest.approx(0.0, abs=1e-9)
    assert found.centre[2] == pytest.approx(-0.01)


def test_studs_carry_over_the_rectangle_that_they_span() -> None:
    studs = [
        Geometry("cylinder", (0.005, 0.01), "", np.array([x, y, 0.0]), BASE, collision=True)
        for x in (-0.07, 0.07) for y in (-0.03, 0.03)
    ]  # fmt: skip
    found = find_sole(corners(studs), BASE)
    assert found is not None
    assert (found.length, found.width) == pytest.approx((0.15, 0.07), abs=1e-3)


@pytest.mark.parametrize("vertices", [np.empty((0, 3)), np.eye(3), np.eye(4)[:, :3] * [1, 1, 0]])
def test_what_has_no_volume_has_no_sole(vertices: np.ndarray) -> None:
    assert find_sole(vertices, BASE) is None
