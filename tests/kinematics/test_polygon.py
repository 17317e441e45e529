from collections.abc import Callable

import numpy as np
import pytest

from gaitlab.kinematics.polygon import hull_margin, support_margin

RECTANGLE = np.array([(-1.0, -2.0), (-1.0, 2.0), (1.0, -2.0), (1.0, 2.0)])


def soles(n: int, seed: int = 7) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, corners of two turned soles and loads, as a walking robot has them."""
    generator = np.random.default_rng(seed)
    angle = generator.uniform(-3.0, 3.0, size=(n, 2))
    c, s = np.cos(angle), np.sin(angle)
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    sole = 0.5 * RECTANGLE * [0.0625, 0.02]
    centre = generator.uniform(-0.1, 0.1, size=(n, 2, 1, 2))
    corners = np.einsum("nfij,kj->nfki", turn, sole) + centre
    loaded = generator.random((n, 2)) < 0.6
    return generator.uniform(-0.15, 0.15, size=(n, 2)), corners, loaded


def sampled_margin(point: np.ndarray, corners: np.ndarray) -> float:
    """Minimum over 20 000 directions, tight to the width of the hull times their spacing."""
    angle = np.linspace(0.0, 2.0 * np.pi, 20_001)
    u = np.stack([np.cos(angle), np.sin(angle)])
    return float(((corners - point) @ u).max(axis=0).min())


def segment_margin(point: np.ndarray, corners: np.ndarray) -> float:
    """Least distance to the hull's edges, found by testing every pair; negative outside."""
    edges, inside = [], True
    for i, a in enumerate(corners):
        for j, b in enumerate(corners):
            along = b - a
            side = along[0] * (corners - a)[:, 1] - along[1] * (corners - a)[:, 0]
            if i != j and np.all(side >= -1e-15):
                share = np.clip((point - a) @ along / (along @ along), 0.0, 1.0)
                edges.append(float(np.linalg.norm(point - a - share * along)))
                inside &= along[0] * (point - a)[1] - along[1] * (point - a)[0] >= 0.0
    return min(edges) if inside else -min(edges)


def test_margin_of_one_rectangle_is_exact() -> None:
    point = np.array([(0, 0), (0.5, 0), (0, 1.75), (1, 0), (-1, 2), (3, 0), (4, 6), (-1.5, -2)])
    margin = hull_margin(point.astype(float), np.tile(RECTANGLE, (len(point), 1, 1)))
    np.testing.assert_allclose(margin, [1, 0.5, 0.25, 0, 0, -2, -5, -0.5], atol=1e-15)


@pytest.mark.parametrize(
    ("reference", "tolerance"), [(segment_margin, 1e-12), (sampled_margin, 1e-4)]
)
def test_margin_equals_brute_force(reference: Callable[..., float], tolerance: float) -> None:
    point, corners, loaded = soles(300)
    margin = support_margin(point, corners, loaded)
    for k in np.flatnonzero(loaded.any(axis=1)):
        expected = reference(point[k], corners[k][loaded[k]].reshape(-1, 2))
        assert margin[k] == pytest.approx(expected, abs=tolerance)


def test_margin_is_nan_exactly_where_no_foot_is_loaded() -> None:
    point, corners, loaded = soles(1000)
    np.testing.assert_array_equal(
        np.isnan(support_margin(point, corners, loaded)), ~loaded.any(axis=1)
    )


def test_an_unloaded_foot_does_not_matter() -> None:
    point, corners, _ = soles(200)
    left_only = np.tile([True, False], (200, 1))
    moved = corners.copy()
    moved[:, 1] += 10.0
    moved[::2, 1] = np.nan
    np.testing.assert_array_equal(
        support_margin(point, corners, left_only), support_margin(point, moved, left_only)
    )


def test_moving_and_turning_everything_keeps_the_margin() -> None:
    point, corners, loaded = soles(1000)
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shift = np.array([1.0, -2.0])
    moved = support_margin(point @ turn.T + shift, corners @ turn.T + shift, loaded)
    np.testing.assert_allclose(moved, support_margin(point, corners, loaded), atol=1e-12)


def test_order_of_corners_and_feet_does_not_matter() -> None:
    point, corners, loaded = soles(1000)
    shuffled = corners[:, ::-1][:, :, [2, 0, 3, 1]]
    np.testing.assert_allclose(
        support_margin(point, shuffled, loaded[:, ::-1]),
        support_margin(point, corners, loaded),
        atol=1e-14,
    )


def test_adding_a_foot_never_shrinks_the_margin() -> None:
    point, corners, _ = soles(2000)
    one = support_margin(point, corners, np.tile([True, False], (2000, 1)))
    both = support_margin(point, corners, np.ones((2000, 2), dtype=bool))
    assert np.all(both >= one - 1e-12)


def test_margin_changes_no_faster_than_the_point_moves() -> None:
    point, corners, loaded = soles(2000)
    both = np.ones_like(loaded)
    step = np.random.default_rng(8).normal(scale=0.01, size=point.shape)
    change = support_margin(point + step, corners, both) - support_margin(point, corners, both)
    assert np.all(np.abs(change) <= np.linalg.norm(step, axis=1) + 1e-12)


def test_corners_of_the_hull_have_no_margin() -> None:
    _, corners, _ = soles(50)
    for corner in range(4):
        margin = hull_margin(corners[:, 0, corner], corners[:, 0])
        np.testing.assert_allclose(margin, 0.0, atol=1e-15)


def test_a_hull_that_is_a_point_or_a_line_has_no_inside() -> None:
    same = np.zeros((1, 4, 2))
    assert hull_margin(np.zeros((1, 2)), same)[0] == 0.0
    assert hull_margin(np.array([[3.0, 4.0]]), same)[0] == -5.0
    line = np.array([[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]])
    assert hull_margin(np.array([[1.5, 0.0]]), line)[0] == 0.0
    assert hull_margin(np.array([[1.5, 0.5]]), line)[0] == -0.5
