from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.render.raster import NOTHING, Layer, Triangles, stain

SIZE = 40


def layer() -> Layer:
    empty = Layer(SIZE, SIZE, 255)
    empty.clear(empty.whole)
    return empty


def triangle(*corners: tuple[float, float, float], colour: int = 0, face: int = 0) -> Triangles:
    points = np.array([corners], np.float32)
    return Triangles(points, np.full((1, 3), colour, np.uint8), np.array([face], np.int32))


def covered(points: np.ndarray) -> np.ndarray:
    stains = np.zeros((SIZE, SIZE), np.uint8)
    stain(stains, points.astype(np.float32), 1)
    return stains > 0


def test_the_nearer_of_two_triangles_shows_whatever_the_order() -> None:
    far = triangle((0, 0, 1), (39, 0, 1), (0, 39, 1), colour=10, face=1)
    near = triangle((0, 0, 2), (39, 0, 2), (0, 39, 2), colour=20, face=2)
    for order in ((far, near), (near, far)):
        painted = layer()
        for each in order:
            painted.paint(each)
        assert painted.face[3, 3] == 2
        assert painted.colour[3, 3].tolist() == [20, 20, 20]


def test_crossing_triangles_show_each_where_it_is_nearer() -> None:
    painted = layer()
    painted.paint(triangle((0, 0, 0), (39, 0, 4), (0, 39, 0), face=1))
    painted.paint(triangle((0, 0, 2), (39, 0, 2), (0, 39, 2), face=2))
    assert painted.face[1, 2] == 2
    assert painted.face[1, 30] == 1


def test_what_is_beyond_the_picture_is_left_out() -> None:
    painted = layer()
    painted.paint(triangle((-90, -90, 1), (-50, -90, 1), (-90, -50, 1)))
    painted.paint(triangle((90, 90, 1), (150, 90, 1), (90, 150, 1)))
    assert (painted.face == NOTHING).all()
    painted.paint(triangle((-900, -900, 1), (900, -900, 1), (0, 1800, 1), face=3))
    assert (painted.face == 3).all()


coordinate = st.floats(-20.0, 60.0, width=32)
corners = st.lists(st.tuples(coordinate, coordinate), min_size=4, max_size=4)


@given(corners)
def test_the_halves_of_a_convex_quadrangle_leave_no_gap_and_no_overlap(
    points: list[tuple[float, float]],
) -> None:
    hub = np.mean(points, axis=0)
    around = np.array(sorted(points, key=lambda p: np.arctan2(*(np.array(p) - hub)[::-1])))
    quad = np.column_stack([around, np.zeros(4)])
    first, second = covered(quad[None, [0, 1, 2]]), covered(quad[None, [0, 2, 3]])
    both = covered(quad[None, [0, 1, 2]]) | covered(quad[None, [0, 2, 3]])
    if _convex(around):
        assert not (first & second).any()
        inside = _inside(around)
        assert both[inside].all()


def _convex(points: np.ndarray) -> bool:
    a, b = (
        np.roll(points, -1, axis=0) - points,
        np.roll(points, -2, axis=0) - np.roll(points, -1, axis=0),
    )
    return bool((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 1e-3).all())


def _inside(points: np.ndarray) -> np.ndarray:
    """Pixels whose middles are inside by more than rounding."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    inside = np.ones((SIZE, SIZE), bool)
    for (ax, ay), (bx, by) in zip(points, np.roll(points, -1, axis=0), strict=True):
        length = max(np.hypot(bx - ax, by - ay), 1e-9)
        inside &= ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length > 1e-3
    return inside
