"""Intervals and tests of proportions, and the counting of the EROS tables."""

from __future__ import annotations

import csv
from math import isnan
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from gaitlab.statistics import (
    Count,
    clustered_rank_sum,
    difference_of_proportions,
    distance_difference,
    efficiency,
    holm,
    mean_interval,
    paired_difference,
    stability_percent,
    stable_cell,
    values_for_mean,
    wilson,
)

DATA = Path(__file__).parent / "data"
counts = st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


def printed(table: str) -> dict[str, list[bool]]:
    with (DATA / f"{table}.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    pedestals = [f"pedestal_{i}" for i in range(1, 5)]
    return {name: [row[name] == "STABLE" for row in rows] for name in pedestals}


@given(counts)
def test_wilson_contains_the_share(count):
    low, high = wilson(*count)
    assert 0.0 <= low <= count[0] / count[1] <= high <= 1.0


@given(counts)
def test_wilson_of_failures_mirrors_that_of_successes(count):
    k, n = count
    low, high = wilson(k, n)
    assert wilson(n - k, n) == pytest.approx((1.0 - high, 1.0 - low), abs=1e-12)


def test_wilson_is_that_of_scipy() -> None:
    for n in range(1, 40):
        for k in range(n + 1):
            theirs = binomtest(k, n).proportion_ci(0.95, method="wilson")
            assert tuple(wilson(k, n)) == pytest.approx(tuple(theirs), abs=1e-14)


@given(counts)
def test_wilson_narrows_with_n(count):
    k, n = count
    few, many = wilson(k, n), wilson(4 * k, 4 * n)
    assert many.high - many.low < few.high - few.low


@given(counts)
def test_wilson_widens_with_confidence(count):
    sure, unsure = wilson(*count, confidence=0.99), wilson(*count, confidence=0.8)
    assert sure.low <= unsure.low
    assert unsure.high <= sure.high


def test_wilson_of_twenty_out_of_twenty():
    # By hand: k = n gives [n / (n + z^2), 1] with z = 1.96.
    assert wilson(20, 20) == pytest.approx((20.0 / (20.0 + 1.959964**2), 1.0), abs=1e-6)
    assert wilson(20, 20).low == pytest.approx(0.839, abs=5e-4)


def test_wilson_of_nothing_is_everything():
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(("k", "n"), [(-1, 3), (4, 3), (0, -1)])
def test_impossible_counts_are_refused(k, n):
    with pytest.raises(ValueError, match="successes"):
        wilson(k, n)


@given(counts, counts)
def test_difference_changes_sign_when_the_two_are_swapped(a, b):
    low, high = difference_of_proportions(Count(*a), Count(*b))
    assert difference_of_proportions(Count(*b), Count(*a)) == pytest.approx((-high, -low))
    assert -1.0 - 1e-9 <= low <= a[0] / a[1] - b[0] / b[1] <= high <= 1.0 + 1e-9


def test_difference_of_newcombes_example():
    # [Newcombe1998], 56/70 against 48/80, method 10.
    low, high = difference_of_proportions(Count(56, 70), Count(48, 80))
    assert (low, high) == pytest.approx((0.0524, 0.3339), abs=5e-5)


def test_a_difference_needs_trials_on_both_sides():
    with pytest.raises(ValueError, match="no trials"):
        difference_of_proportions(Count(0, 0), Count(1, 2))


def test_half_of_the_seeds_make_a_cell_stable():
    assert stable_cell(0.5)
    assert not stable_cell(0.49)


@pytest.mark.parametrize(
    ("table", "percents", "mean"),
    [("eros_table7", [30, 30, 50, 90], 50), ("eros_table8", [70, 70, 80, 100], 80)],
)
def test_counting_the_printed_tables(table, percents, mean):
    counted = [stability_percent(cells) for cells in printed(table).values()]
    assert counted == percents
    assert efficiency(counted) == mean


def test_scores_of_nothing_are_not_numbers():
    assert isnan(stability_percent([]))
    assert isnan(efficiency([]))


@pytest.mark.parametrize(("fell_at", "percent"), [(4.46, 25.67), (3.57, 40.5), (2.68, 55.33)])
def test_difference_of_distance_as_printed(fell_at, percent):
    assert distance_difference(6.0, fell_at) == pytest.approx(percent, abs=5e-3)


SURFACES = [[Count(7, 10), Count(5, 10), Count(1, 10)], [Count(10, 10), Count(6, 10)]]


def test_mean_interval_of_two_values_by_hand():
    # Two values d apart: the deviation is d / sqrt(2), over sqrt(2) it is d / 2; t is 12.706.
    low, high = mean_interval([1.0, 2.0])
    assert (low, high) == pytest.approx((1.5 - 12.7062 / 2.0, 1.5 + 12.7062 / 2.0), abs=1e-4)


@given(st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=20), st.floats(-50.0, 50.0))
def test_mean_interval_moves_with_its_values_and_holds_their_mean(values, shift):
    low, high = mean_interval(values)
    assert low <= np.mean(values) + 1e-9
    assert high >= np.mean(values) - 1e-9
    moved = mean_interval([value + shift for value in values])
    assert moved == pytest.approx((low + shift, high + shift), abs=1e-6)


def test_one_value_tells_nothing_of_its_mean():
    assert mean_interval([3.0]) == (-np.inf, np.inf)


pairs = st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=40)


@given(pairs)
def test_a_paired_difference_lies_in_its_interval_and_changes_sign_with_the_order(found):
    low, high = paired_difference(found)
    gap = np.mean([a for a, _ in found]) - np.mean([b for _, b in found])
    assert -1.0 <= low <= high <= 1.0
    if 0 < abs(gap) < 1 or not gap:
        shrunk = gap * len(found) / (len(found) + 2)
        assert low - 1e-12 <= shrunk <= high + 1e-12
    swapped = paired_difference([(b, a) for a, b in found])
    assert swapped == pytest.approx((-high, -low))


def test_equal_pairs_still_leave_a_difference_possible():
    low, high = paired_difference([(True, True)] * 10)
    assert low == -high < 0.0


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_holm_never_lowers_a_p_value_and_keeps_their_order(p_values):
    adjusted = holm(p_values)
    assert all(p <= a <= 1.0 for p, a in zip(p_values, adjusted, strict=True))
    order = np.argsort(p_values, kind="stable")
    assert np.all(np.diff(np.array(adjusted)[order]) >= 0.0)


def test_holm_of_three_by_hand():
    assert holm([0.04, 0.01, 0.03]) == pytest.approx([0.06, 0.03, 0.06])


def _night(rng: np.random.Generator, *, cells: int, seeds: int, shift: float, shared: float):
    """Values of two sides with other seeds, and their labels; a seed moves its values alike."""
    moved = [shared * rng.normal(size=seeds) for _ in range(2)]
    strata = [
        (rng.normal(k + shift, 1.0, seeds) + moved[0], rng.normal(k, 1.0, seeds) + moved[1])
        for k in range(cells)
    ]
    return strata, [(np.arange(seeds), seeds + np.arange(seeds))] * cells


def test_ranks_within_strata_do_not_see_what_differs_between_them():
    strata, seeds = _night(np.random.default_rng(3), cells=6, seeds=8, shift=0.0, shared=0.0)
    moved = [(a + 100.0 * k, b + 100.0 * k) for k, (a, b) in enumerate(strata)]
    assert clustered_rank_sum(moved, seeds) == clustered_rank_sum(strata, seeds)


@pytest.mark.parametrize("shared", [0.0, 2.0], ids=["alone", "hanging together"])
def test_ranks_within_strata_raise_no_more_alarms_than_they_say(shared):
    rng = np.random.default_rng(5)
    nights = (_night(rng, cells=6, seeds=8, shift=0.0, shared=shared) for _ in range(150))
    found = [clustered_rank_sum(*night, "less") < 0.1 for night in nights]
    assert np.mean(found) < 0.18  # 10 % claimed; 150 rounds scatter by 2.5 points


def test_ranks_within_strata_find_a_shift_and_its_direction():
    night = _night(np.random.default_rng(5), cells=6, seeds=8, shift=2.5, shared=0.0)
    assert clustered_rank_sum(*night, "greater") < 0.001
    assert clustered_rank_sum(*night, "less") > 0.99


def test_equal_values_on_both_sides_find_nothing():
    same = [(np.ones(4), np.ones(5))]
    assert clustered_rank_sum(same, [(np.arange(4), 4 + np.arange(5))]) == 1.0


@given(st.floats(0.05, 0.9), st.floats(1.1, 3.0))
def test_a_larger_difference_needs_no_more_trials(difference, times):
    larger = min(difference * times, 0.95)
    assert values_for_mean(1.0, larger) <= values_for_mean(1.0, difference)


def test_no_difference_is_never_told():
    assert values_for_mean(1.0, 0.0) == np.inf
