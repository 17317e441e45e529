"""Tests over clusters, and what they can notice: exact, rarely wrong, and not blind."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import wilcoxon

from gaitlab.statistics import (
    detectable_drop,
    detectable_shift,
    sign_flip,
)
from gaitlab.statistics.clusters import _ranked


def _outcomes(rng: np.random.Generator, seeds: int, cells: int, shared: float) -> np.ndarray:
    """Stable or not of each seed in each cell; a seed's luck is shared between its cells."""
    luck = shared * rng.normal(size=(seeds, 1)) + np.sqrt(1.0 - shared**2) * rng.normal(
        size=(seeds, cells)
    )
    return (luck < 0.5).astype(float)


@pytest.mark.parametrize("shared", [0.0, 0.8], ids=["alone", "hanging together"])
def test_a_drop_that_can_be_noticed_is_noticed_four_times_in_five(shared):
    rng, level = np.random.default_rng(13), 0.01
    drop = detectable_drop(_outcomes(rng, 400, 6, shared), 20, level)
    found = 0
    for _ in range(300):
        before, after = (_outcomes(rng, 20, 6, shared) for _ in range(2))
        lost = rng.random(after.shape) < drop / 0.69  # the share of luck below 0.5
        gaps = np.where(lost, 0.0, after) - before
        found += sign_flip(gaps.sum(axis=1), "less") < level
    assert 0.70 < found / 300 < 0.90


def test_more_seeds_notice_less_and_hopeless_cells_nothing():
    y = _outcomes(np.random.default_rng(3), 24, 6, 0.3)
    assert detectable_drop(y, 48, 0.01) < detectable_drop(y, 12, 0.01) < 1.0
    assert detectable_drop(np.zeros((5, 1)), 5, 0.01) == np.inf
    shifts = np.random.default_rng(4).normal(size=(20, 6))
    assert detectable_shift(2.0 * shifts, 20, 0.01) == pytest.approx(
        2.0 * detectable_shift(shifts, 20, 0.01)
    )


def test_seeds_whose_signs_are_too_few_for_the_level_notice_nothing():
    shifts = np.random.default_rng(4).normal(size=(7, 6))
    assert detectable_shift(shifts, 6, 0.01) == np.inf  # 2^-6 is 0.016
    assert detectable_shift(shifts, 7, 0.01) < np.inf
    assert detectable_drop(np.ones((6, 4)), 6, 0.01) == np.inf


@pytest.mark.parametrize("clusters", [12, 24])
def test_a_shift_that_can_be_noticed_is_noticed_four_times_in_five(clusters):
    rng, level = np.random.default_rng(5), 0.001
    shift = detectable_shift(rng.normal(size=(400, 1)), clusters, level)
    drawn = rng.normal(shift, 1.0, (300, clusters))
    found = np.mean([sign_flip(sums, "greater") <= level for sums in drawn])
    assert 0.70 < found < 0.90


SUMS = st.lists(st.integers(-5, 5), min_size=1, max_size=10).map(lambda v: np.array(v, float))


@given(SUMS)
def test_a_sign_flip_counts_all_signs_as_by_hand(sums):
    totals = [np.dot(signs, sums) for signs in product((-1.0, 1.0), repeat=len(sums))]
    assert sign_flip(sums, "greater") == pytest.approx(np.mean(np.array(totals) >= sums.sum()))


@given(SUMS)
def test_a_sign_flip_of_exchanged_sides_is_its_mirror(sums):
    assert sign_flip(sums, "less") == sign_flip(-sums, "greater")
    assert sign_flip(sums) == sign_flip(-sums)
    assert sign_flip(7.0 * sums[::-1], "less") == pytest.approx(sign_flip(sums, "less"))


@given(SUMS)
def test_over_all_signs_a_sign_flip_alarms_no_more_often_than_it_says(sums):
    """If nothing changed, every sign is as likely; so this is the false-alarm rate itself."""
    sums = sums[:6]
    flipped = [np.array(signs) * sums for signs in product((-1.0, 1.0), repeat=len(sums))]
    found = np.array([sign_flip(each, "less") for each in flipped])
    for level in (0.02, 0.1, 0.3):
        assert np.mean(found <= level) <= level + 1e-12


def test_one_cluster_and_equal_clusters_find_nothing():
    assert sign_flip(np.array([-9.0]), "less") == 0.5
    assert sign_flip(np.zeros(12), "less") == 1.0


def test_many_clusters_agree_with_all_signs():
    sums = np.random.default_rng(2).normal(0.35, 1.0, 30)
    drawn = sign_flip(np.concatenate([sums, [1e-12]]), "greater")  # one more: random signs
    assert drawn == pytest.approx(sign_flip(sums, "greater"), abs=0.01)


@pytest.mark.parametrize("shared", [0.0, 3.0], ids=["alone", "hanging together"])
def test_sums_over_cells_alarm_as_rarely_as_they_say_where_single_walks_would_not(shared):
    rng = np.random.default_rng(17)
    gaps = shared * rng.normal(size=(600, 12, 1)) + rng.normal(size=(600, 12, 8))
    clustered = np.mean([sign_flip(night.sum(axis=1), "less") < 0.05 for night in gaps])
    assert clustered < 0.08  # 5 % claimed; 600 nights scatter by 0.9 points
    single = np.mean([wilcoxon(night.ravel(), alternative="less").pvalue < 0.05 for night in gaps])
    assert (single > 0.2) == (shared > 0.0)


def test_a_change_that_all_seeds_share_is_found():
    gaps = np.random.default_rng(19).normal(-1.0, 1.0, (12, 8))
    assert sign_flip(gaps.sum(axis=1), "less") == pytest.approx(2.0**-12)


@pytest.mark.parametrize("n", [2, 10, 200])
def test_ranks_of_a_stratum_weigh_alike_whatever_its_size(n: int) -> None:
    """Van Elteren's 1 / (n + 1): a stratum of many values does not drown one of few."""
    first, second = _ranked(np.arange(n, dtype=float), np.arange(n, dtype=float) + n)
    assert np.mean(second) - np.mean(first) == pytest.approx(n / (2 * n + 1))
    assert max(np.abs(first).max(), np.abs(second).max()) < 0.5
    assert first.sum() + second.sum() == pytest.approx(0.0, abs=1e-12)
