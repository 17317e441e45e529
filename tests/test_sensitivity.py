"""Laws of the sensitivity statistics: known planes, no effect, order and units of the points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.experiment.design import unit_points
from gaitlab.statistics import fewest_points, linear_effects, sign_shares
from gaitlab.statistics.sensitivity import LinearEffects

POINTS = unit_points("sobol", 48, 10, 1)
SLOPES = np.array([0.5, -0.3, 0.0, 0.1, 0.0, 0.0, -0.05, 0.0, 0.2, 0.0])


def noise(seed: int, n: int = 48) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, 0.1, n)


def changes(found: LinearEffects) -> np.ndarray:
    return np.array([effect.change for effect in found.effects])


def ends(found: LinearEffects) -> np.ndarray:
    return np.array([effect.interval for effect in found.effects])


def p_values(found: LinearEffects) -> np.ndarray:
    return np.array([effect.p_value for effect in found.effects])


def test_a_plane_without_noise_is_found_exactly() -> None:
    found = linear_effects(POINTS, 0.4 + POINTS @ SLOPES)
    np.testing.assert_allclose(changes(found), SLOPES, atol=1e-12)
    np.testing.assert_allclose(ends(found), np.column_stack([SLOPES, SLOPES]), atol=1e-9)
    assert found.r_squared == pytest.approx(1.0)
    assert found.adjusted == pytest.approx(1.0)


def test_a_plane_under_noise_is_within_its_intervals_and_large_slopes_are_told() -> None:
    found = linear_effects(POINTS, POINTS @ SLOPES + noise(1))
    low, high = ends(found).T
    assert np.sum((low <= SLOPES) & (high >= SLOPES)) >= 9
    told = p_values(found) < 0.05
    assert told[[0, 1]].all()
    assert not told[SLOPES == 0.0].any()


@pytest.fixture(scope="module")
def without_effect() -> list[LinearEffects]:
    """Fits of 60 responses that scatter, three times as much at one end of the box as elsewhere."""
    return [linear_effects(POINTS, noise(s) * (0.5 + POINTS[:, 0])) for s in range(60)]


def test_no_effect_is_covered_as_often_as_promised(without_effect) -> None:
    """95 % of 60 x 10 intervals, within what 600 of them scatter and the small n allows."""
    low, high = np.array([ends(found) for found in without_effect]).reshape(-1, 2).T
    assert 0.92 <= np.mean((low <= 0.0) & (high >= 0.0)) <= 0.99


def test_no_effect_is_rarely_called_one(without_effect) -> None:
    """Of 60 boxes without any effect at most 5 % name one; more than 8 is one chance in 200."""
    assert sum(np.min(p_values(found)) < 0.05 for found in without_effect) <= 8


def test_a_plane_explains_of_noise_what_its_numbers_allow(without_effect) -> None:
    assert np.mean([f.r_squared for f in without_effect]) == pytest.approx(10 / 47, abs=0.05)
    assert np.mean([f.adjusted for f in without_effect]) == pytest.approx(0.0, abs=0.06)


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 1000))
def test_the_order_of_the_points_does_not_matter(seed: int) -> None:
    response = POINTS @ SLOPES + noise(3)
    order = np.random.default_rng(seed).permutation(len(POINTS))
    first, other = linear_effects(POINTS, response), linear_effects(POINTS[order], response[order])
    np.testing.assert_allclose(ends(other), ends(first), atol=1e-12)
    np.testing.assert_array_equal(p_values(other), p_values(first))


@settings(max_examples=8, deadline=None)
@given(
    shift=st.floats(-5.0, 5.0), scale=st.floats(0.01, 100.0), back=st.booleans(),
    lift=st.floats(-1.0, 1.0), gain=st.floats(0.1, 10.0),
)  # fmt: skip
def test_units_and_origins_do_not_matter(shift, scale, back, lift, gain) -> None:
    response, factor = POINTS @ SLOPES + noise(4), -scale if back else scale
    box = np.array([[shift] * 10, [shift + factor] * 10])
    first = linear_effects(POINTS, response)
    other = linear_effects(shift + factor * POINTS, lift + gain * response, box)
    np.testing.assert_allclose(changes(other), gain * changes(first), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(ends(other), gain * ends(first), rtol=1e-6, atol=1e-9)
    assert other.r_squared == pytest.approx(first.r_squared)


def test_quantities_may_stand_in_any_order() -> None:
    response, order = POINTS @ SLOPES + noise(5), np.arange(10)[::-1]
    first, other = linear_effects(POINTS, response), linear_effects(POINTS[:, order], response)
    np.testing.assert_allclose(changes(other)[order], changes(first), atol=1e-12)


def test_the_opposite_response_has_the_opposite_effects() -> None:
    response = POINTS @ SLOPES + noise(6)
    first, other = linear_effects(POINTS, response), linear_effects(POINTS, -response)
    np.testing.assert_allclose(ends(other), -ends(first)[:, ::-1], atol=1e-12)
    np.testing.assert_array_equal(p_values(other), p_values(first))


def test_a_response_that_never_changes_has_no_effects() -> None:
    found = linear_effects(POINTS, np.full(48, 0.3))
    np.testing.assert_array_equal(ends(found), np.zeros((10, 2)))
    np.testing.assert_array_equal(p_values(found), np.ones(10))
    assert np.isnan(found.r_squared)


def test_too_few_points_and_quantities_that_move_together_are_refused() -> None:
    assert fewest_points(10) == 22
    with pytest.raises(ValueError, match="at least 22"):
        linear_effects(POINTS[:21], noise(1, 21))
    with pytest.raises(ValueError, match="move together"):
        linear_effects(POINTS[:, [0, 0, 1]], noise(1))


@given(st.lists(st.sampled_from([-0.5, -0.25, 0.0, 0.25]), min_size=1, max_size=30))
def test_every_point_has_one_sign(values: list[float]) -> None:
    shares = sign_shares(np.array(values))
    assert sum(count.successes for count in shares) == len(values)
    assert {count.n for count in shares} == {len(values)}
    flipped = sign_shares(-np.array(values))
    assert (flipped.positive, flipped.zero) == (shares.negative, shares.zero)
