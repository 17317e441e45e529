"""Laws of the sensitivity statistics: functions of known indices, noise alone, order and units."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.experiment.design import unit_points
from gaitlab.statistics.sensitivity import (
    Sensitivity,
    fewest_points,
    sensitivity_of,
    sign_shares,
)
from gaitlab.statistics.surrogate import _loss, fit_process, quality

POINTS = unit_points("sobol", 64, 4, 1)
SLOPES = np.array([0.5, -0.3, 0.1, 0.0])


def ishigami(points: np.ndarray, a: float = 7.0, b: float = 0.1) -> np.ndarray:
    """The function of Ishigami and Homma, 1990, on the unit cube."""
    x = np.pi * (2.0 * points - 1.0)
    return np.sin(x[:, 0]) * (1.0 + b * x[:, 2] ** 4) + a * np.sin(x[:, 1]) ** 2


def ishigami_indices(a: float = 7.0, b: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """First-order and total indices, from the integrals over the cube."""
    first = np.array([0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0])
    both = b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    total = first + np.array([both, 0.0, both])
    variance = first.sum() + both
    return first / variance, total / variance


def indices(found: Sensitivity) -> np.ndarray:
    """First-order and total indices and changes. Shape (k, 3)."""
    return np.array([[e.first.value, e.total.value, e.change.value] for e in found.effects])


def test_the_indices_of_ishigamis_function_are_the_known_ones() -> None:
    points = unit_points("sobol", 256, 3, 1)
    found = sensitivity_of(points, ishigami(points))
    first, total = ishigami_indices()
    assert found.quality.predicts
    assert found.quality.q_squared > 0.9
    np.testing.assert_allclose(indices(found)[:, 0], first, atol=0.04)
    np.testing.assert_allclose(indices(found)[:, 1], total, atol=0.08)


def test_in_a_sum_first_order_and_total_indices_are_one_and_add_up() -> None:
    found = sensitivity_of(POINTS, POINTS @ SLOPES)
    first, total, change = indices(found).T
    np.testing.assert_allclose(first, total, atol=0.02)
    assert first.sum() == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(first, SLOPES**2 / np.sum(SLOPES**2), atol=0.02)
    np.testing.assert_allclose(change, SLOPES, atol=0.01)


def test_a_product_has_a_total_and_no_first_order_index() -> None:
    x = 2.0 * POINTS - 1.0
    first, total, _ = indices(sensitivity_of(POINTS, x[:, 0] * x[:, 1])).T
    np.testing.assert_allclose(first, np.zeros(4), atol=0.05)
    np.testing.assert_allclose(total, [1.0, 1.0, 0.0, 0.0], atol=0.05)


def test_noise_alone_is_modelled_in_at_most_one_draw_of_twenty() -> None:
    """Of 40 draws at most 2 would be the rate promised; more than 5 is one chance in 70."""
    points = unit_points("sobol", 48, 3, 1)
    draws = np.random.default_rng(1).normal(size=(40, 48))
    assert sum(quality(points, values).predicts for values in draws) <= 5


def test_without_a_model_no_index_is_given() -> None:
    noise = np.random.default_rng(2).normal(size=64)
    assert sensitivity_of(POINTS, noise).effects == ()
    same = sensitivity_of(POINTS, np.full(64, 0.3))
    assert (same.quality.predicts, same.effects) == (False, ())


def test_noise_that_is_known_widens_the_intervals_and_keeps_the_sum_within() -> None:
    noisy = POINTS @ SLOPES + np.random.default_rng(3).normal(0.0, 0.1, 64)
    found = sensitivity_of(POINTS, noisy, noise=0.01)
    for effect, slope in zip(found.effects, SLOPES, strict=True):
        low, high = effect.change.interval
        assert low - 0.05 < slope < high + 0.05
        for estimate in (effect.first, effect.total):
            assert 0.0 <= estimate.interval.low <= estimate.value <= estimate.interval.high <= 1.0
    widths = [np.ptp(e.change.interval) for e in found.effects]
    exact = [np.ptp(e.change.interval) for e in sensitivity_of(POINTS, POINTS @ SLOPES).effects]
    assert min(widths) > max(exact)


def test_the_order_of_the_points_does_not_matter() -> None:
    values = POINTS @ SLOPES + np.random.default_rng(4).normal(0.0, 0.05, 64)
    order = np.random.default_rng(5).permutation(64)
    first, other = sensitivity_of(POINTS, values), sensitivity_of(POINTS[order], values[order])
    np.testing.assert_array_equal(indices(first), indices(other))


def test_the_unit_of_the_response_does_not_matter() -> None:
    values = POINTS @ SLOPES + np.random.default_rng(6).normal(0.0, 0.05, 64)
    first, other = sensitivity_of(POINTS, values), sensitivity_of(POINTS, 3.0 - 100.0 * values)
    np.testing.assert_allclose(indices(other)[:, :2], indices(first)[:, :2], atol=1e-3)
    np.testing.assert_allclose(indices(other)[:, 2], -100.0 * indices(first)[:, 2], atol=0.1)


def test_without_noise_the_process_meets_its_points_and_its_paths_do() -> None:
    values = ishigami(POINTS[:, :3])
    model = fit_process(POINTS[:, :3], values)
    reach = 4.0 * np.sqrt(model.noise.max())
    np.testing.assert_allclose(model.predict(model.points), values, atol=reach)
    paths = model.paths(np.random.default_rng(1), np.tile(values[:, None], 3))
    np.testing.assert_allclose(paths(model.points), np.tile(values[:, None], 3), atol=2.0 * reach)


def test_the_mean_of_many_paths_is_the_expected_function() -> None:
    values = POINTS @ SLOPES + np.random.default_rng(7).normal(0.0, 0.1, 64)
    model = fit_process(POINTS, values)
    places = np.random.default_rng(8).random((50, 4))
    paths = model.paths(np.random.default_rng(9), np.tile(values[:, None], 2000))(places)
    error = paths.std(axis=1) / np.sqrt(2000.0)
    assert np.max(np.abs(paths.mean(axis=1) - model.predict(places)) / error) < 5.0


def test_the_gradient_of_the_likelihood_is_its_slope() -> None:
    points, values = POINTS[:32, :3], np.random.default_rng(10).normal(size=32)
    squares = (points[:, None] - points[None]) ** 2
    theta, known = np.array([0.1, -0.5, 0.2, 0.4, -1.0]), np.full(32, 0.01)
    for j, step in enumerate(1e-5 * np.eye(5)):
        ends = [_loss(theta + sign * step, squares, values, known)[0] for sign in (-1.0, 1.0)]
        slope = _loss(theta, squares, values, known)[1][j]
        assert slope == pytest.approx((ends[1] - ends[0]) / 2e-5, rel=1e-5)


def test_too_few_points_are_refused() -> None:
    assert fewest_points(10) == 22
    with pytest.raises(ValueError, match="10 are needed"):
        sensitivity_of(POINTS[:9], POINTS[:9] @ SLOPES)


@given(st.lists(st.sampled_from([-0.5, -0.25, 0.0, 0.25]), min_size=1, max_size=30))
def test_every_point_has_one_sign(values: list[float]) -> None:
    shares = sign_shares(np.array(values))
    assert sum(count.successes for count in shares) == len(values)
    assert {count.n for count in shares} == {len(values)}
    signs = Counter(np.sign(values).tolist())
    assert shares.positive.successes == signs[1.0]
    flipped = sign_shares(-np.array(values))
    assert (flipped.positive, flipped.zero) == (shares.negative, shares.zero)
