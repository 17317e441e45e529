from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.render.camera import VIEWPOINTS, Camera, View


def looking(azimuth: float, elevation: float, distance: float = inf) -> Camera:
    return Camera(
        azimuth=azimuth,
        elevation=elevation,
        focus=np.array([1.0, 2.0, 0.3]),
        place=(100.0, 80.0),
        scale=200.0,
        distance=distance,
    )


def camera(view: View, distance: float = inf) -> Camera:
    return looking(VIEWPOINTS[view].azimuth, VIEWPOINTS[view].elevation, distance)


@given(st.floats(-pi, pi), st.floats(-1.5, 1.5))
def test_a_camera_keeps_lengths_and_handedness(azimuth: float, elevation: float) -> None:
    axes = looking(azimuth, elevation).axes
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    right, up, away = axes
    assert np.allclose(np.cross(right, up), -away, atol=1e-12)


def test_from_the_right_side_forward_is_right_and_left_is_far() -> None:
    assert np.allclose(camera("side").axes, [[1, 0, 0], [0, 0, 1], [0, 1, 0]], atol=1e-12)


@pytest.mark.parametrize("view", VIEWPOINTS)
@pytest.mark.parametrize("distance", [2.0, inf])
def test_the_focus_is_seen_at_its_place(view: View, distance: float) -> None:
    watched = camera(view, distance)
    assert watched.see(watched.focus)[:2] == pytest.approx([100.0, 80.0])


def test_the_side_view_shows_lengths_along_the_walk_and_heights_true() -> None:
    watched = camera("side")
    ahead, up = watched.see(watched.focus + np.array([[0.1, 0.7, 0.0], [0.0, -0.7, 0.1]]))
    assert ahead[:2] == pytest.approx([120.0, 80.0])
    assert up[:2] == pytest.approx([100.0, 60.0])


@pytest.mark.parametrize("view", VIEWPOINTS)
@pytest.mark.parametrize("distance", [2.0, inf])
def test_what_is_nearer_to_the_camera_has_the_larger_nearness(view: View, distance: float) -> None:
    watched = camera(view, distance)
    away = watched.axes[2]
    near = watched.see(watched.focus + np.array([[-0.2], [0.0], [0.3]]) * away)[:, 2]
    assert (np.diff(near) < 0.0).all()


def test_a_perspective_view_shows_near_things_larger() -> None:
    watched = camera("perspective", 2.0)
    right, _, away = watched.axes
    sizes = [
        watched.see(watched.focus + depth * away + 0.1 * right)[0] - 100.0
        for depth in (-0.5, 0.0, 0.5)
    ]
    assert sizes[0] > sizes[1] == pytest.approx(20.0)
    assert sizes[2] < sizes[1]


def test_nearness_is_linear_along_a_line_on_the_screen() -> None:
    watched = camera("perspective", 2.0)
    ends = watched.see(watched.focus + np.array([[0.3, 0.1, 0.0], [-0.4, 0.2, 0.5]]))
    share = np.linspace(0.0, 1.0, 9)[:, None]
    between = watched.see(
        watched.focus
        + np.array([[0.3, 0.1, 0.0]]) * (1 - share)
        + share * np.array([-0.4, 0.2, 0.5])
    )
    slope = (between[:, 2] - ends[0, 2]) / (between[:, 0] - ends[0, 0] + 1e-12)
    assert slope[1:] == pytest.approx(np.full(8, slope[-1]))
