from __future__ import annotations

from math import inf

import numpy as np
import pytest

from gaitlab.render.lens import CAMERAS, Lens, View


def lens(view: View, distance: float = inf) -> Lens:
    return Lens(
        camera=CAMERAS[view],
        focus=np.array([1.0, 2.0, 0.3]),
        place=(100.0, 80.0),
        scale=200.0,
        distance=distance,
    )


@pytest.mark.parametrize("view", CAMERAS)
@pytest.mark.parametrize("distance", [2.0, inf])
def test_the_focus_is_seen_at_its_place(view: View, distance: float) -> None:
    given = lens(view, distance)
    assert given.see(given.focus)[:2] == pytest.approx([100.0, 80.0])


def test_the_side_view_shows_lengths_along_the_walk_and_heights_true() -> None:
    given = lens("side")
    ahead, up = given.see(given.focus + np.array([[0.1, 0.7, 0.0], [0.0, -0.7, 0.1]]))
    assert ahead[:2] == pytest.approx([120.0, 80.0])
    assert up[:2] == pytest.approx([100.0, 60.0])


@pytest.mark.parametrize("view", CAMERAS)
@pytest.mark.parametrize("distance", [2.0, inf])
def test_what_is_nearer_to_the_camera_has_the_larger_nearness(view: View, distance: float) -> None:
    given = lens(view, distance)
    away = given.camera.axes[2]
    near = given.see(given.focus + np.array([[-0.2], [0.0], [0.3]]) * away)[:, 2]
    assert (np.diff(near) < 0.0).all()


def test_a_perspective_view_shows_near_things_larger() -> None:
    given = lens("perspective", 2.0)
    right, _, away = given.camera.axes
    sizes = [
        given.see(given.focus + depth * away + 0.1 * right)[0] - 100.0 for depth in (-0.5, 0.0, 0.5)
    ]
    assert sizes[0] > sizes[1] == pytest.approx(20.0)
    assert sizes[2] < sizes[1]


def test_nearness_is_linear_along_a_line_on_the_screen() -> None:
    given = lens("perspective", 2.0)
    ends = given.see(given.focus + np.array([[0.3, 0.1, 0.0], [-0.4, 0.2, 0.5]]))
    share = np.linspace(0.0, 1.0, 9)[:, None]
    between = given.see(
        given.focus + np.array([[0.3, 0.1, 0.0]]) * (1 - share) + share * np.array([-0.4, 0.2, 0.5])
    )
    slope = (between[:, 2] - ends[0, 2]) / (between[:, 0] - ends[0, 0] + 1e-12)
    assert slope[1:] == pytest.approx(np.full(8, slope[-1]))
