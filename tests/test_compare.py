"""The one comparison of two treatments: laws of the pairing, of the test and of the verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest, norm, ttest_1samp

from gaitlab.statistics.compare import (
    LEVEL,
    Key,
    Match,
    Runs,
    Side,
    contrast,
    judged,
    match,
    runs_of,
)

KEYS = st.lists(st.tuples(st.sampled_from("abc"), st.integers(0, 4)), unique=True, max_size=12)


def outcomes(
    rng: np.random.Generator,
    shares: tuple[float, float],
    *,
    cells: int = 4,
    seeds: int = 10,
    shared: float = 0.0,
) -> Runs:
    """Pairs that stay up with these shares; a seed's luck is partly shared by its cells."""

    def side(share: float) -> np.ndarray:
        own = rng.normal(size=(seeds, cells))
        luck = shared * rng.normal(size=(seeds, 1)) + np.sqrt(1.0 - shared**2) * own
        return (norm.cdf(luck) < share).astype(float).ravel()

    place = np.tile(np.arange(cells), seeds), np.repeat(np.arange(seeds), cells)
    first, second = (Side(side(share), *place) for share in shares)
    return runs_of(first, second, paired=True, outcomes=True)


def apart(runs: Runs) -> Runs:
    """The same runs as if no seed was shared."""
    second = runs.second._replace(seeds=runs.second.seeds + 1000)
    return runs_of(runs.first, second, paired=False, outcomes=runs.outcomes)


def swapped(runs: Runs) -> Runs:
    return replace(runs, first=runs.second, second=runs.first)


def shuffled(runs: Runs, rng: np.random.Generator) -> Runs:
    orders = [rng.permutation(len(runs.first.values))] * 2
    if not runs.paired:
        orders[1] = rng.permutation(len(runs.second.values))
    first, second = (
        Side(*(column[order] for column in side))
        for side, order in zip((runs.first, runs.second), orders, strict=True)
    )
    return replace(runs, first=first, second=second)


def drawn(paired: bool, outcome: bool, draw: int = 5) -> Runs:
    rng = np.random.default_rng(draw)
    runs = outcomes(rng, (0.8, 0.5))
    if not outcome:
        sides = (
            s._replace(values=s.values + rng.normal(size=40)) for s in (runs.first, runs.second)
        )
        runs = runs_of(*sides, paired=True)
    return runs if paired else apart(runs)


EVERY = [(True, True), (True, False), (False, True), (False, False)]


def keys_of(found: Match, first: list[Key], second: list[Key]) -> list[list[Key]]:
    pairs = zip((first, second), found.rows, strict=True)
    return [[side[row] for row in rows] for side, rows in pairs]


@given(KEYS, KEYS)
def test_runs_are_matched_by_cell_and_seed_or_else_by_cell(first: list[Key], second: list[Key]):
    found = match(first, second)
    sides = [
        [side[row] for row in rows] for side, rows in zip((first, second), found.rows, strict=True)
    ]
    common = set(first) & set(second)
    assert found.paired == bool(common)
    if found.paired:
        assert sides[0] == sides[1]
        assert set(sides[0]) == common
    else:
        cells = {cell for cell, _ in first} & {cell for cell, _ in second}
        assert [sorted(s) for s in sides] == [
            sorted(key for key in side if key[0] in cells) for side in (first, second)
        ]
    assert found.unshared == len({c for c, _ in first} ^ {c for c, _ in second})


@given(KEYS, KEYS, st.randoms())
def test_the_order_of_runs_does_not_matter_to_their_matching(first, second, random):
    def keys(found, first, second):
        return [
            [side[r] for r in rows] for side, rows in zip((first, second), found.rows, strict=True)
        ]

    mixed = random.sample(first, len(first)), random.sample(second, len(second))
    told, again = keys_of(match(first, second), first, second), keys_of(match(*mixed), *mixed)
    assert [sorted(side) for side in told] == [sorted(side) for side in again]
    back = keys_of(match(second, first), second, first)
    assert [sorted(side) for side in back[::-1]] == [sorted(side) for side in told]


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=25))
def test_in_one_cell_the_test_of_outcomes_is_the_exact_one_of_mcnemar(pairs):
    first, second = np.array(pairs, float).T
    place = np.zeros(len(pairs), int), np.arange(len(pairs))
    runs = runs_of(Side(first, *place), Side(second, *place), paired=True, outcomes=True)
    only, n = int((second > first).sum()), int((second != first).sum())
    for alternative in ("two-sided", "less", "greater"):
        expected = binomtest(only, n, alternative=alternative).pvalue if n else 1.0
        assert runs.p_value(alternative) == pytest.approx(expected)


def test_in_one_cell_the_interval_of_a_mean_is_students():
    rng = np.random.default_rng(1)
    place = np.zeros(12, int), np.arange(12)
    first, second = rng.normal(size=12), rng.normal(size=12)
    runs = runs_of(Side(first, *place), Side(second, *place), paired=True)
    known = ttest_1samp(second - first, 0.0).confidence_interval()
    assert tuple(runs.interval) == pytest.approx((known.low, known.high))


@pytest.mark.parametrize(("paired", "outcome"), EVERY)
def test_exchanged_treatments_give_the_mirror_image(paired, outcome):
    runs = drawn(paired, outcome)
    here, there = (contrast("stable", r, "higher") for r in (runs, swapped(runs)))
    assert here.difference == pytest.approx(-there.difference)
    assert tuple(here.interval) == pytest.approx((-there.interval.high, -there.interval.low))
    assert here.p_value == pytest.approx(there.p_value, abs=1e-9 if paired else 0.01)
    opposite = {"better": "worse", "cannot tell": "cannot tell"}
    (told,), (back,) = judged([here]), judged([there])
    assert back.verdict == opposite.get(told.verdict, "better")


@pytest.mark.parametrize(("paired", "outcome"), EVERY)
def test_the_order_of_runs_does_not_matter_to_what_is_said(paired, outcome):
    runs = drawn(paired, outcome)
    here = contrast("stable", runs, "higher")
    there = contrast("stable", shuffled(runs, np.random.default_rng(3)), "higher")
    assert there.difference == pytest.approx(here.difference)
    assert tuple(there.interval) == pytest.approx(tuple(here.interval))
    assert there.p_value == pytest.approx(here.p_value, abs=1e-9 if paired else 0.01)


def test_without_a_run_there_is_no_data_and_with_one_seed_nothing_is_told():
    nothing = runs_of(Side(*np.zeros((3, 0))), Side(*np.zeros((3, 0))), paired=True)
    assert [c.verdict for c in judged([contrast("stable", nothing, "higher")])] == ["no data"]
    single = outcomes(np.random.default_rng(1), (1.0, 0.0), seeds=1)
    (told,) = judged([contrast("stable", single, "higher")])
    assert (told.verdict, told.needed, told.advice) == ("cannot tell", np.inf, "")
    assert tuple(told.interval) == (-1.0, 1.0)


def test_what_is_not_a_number_leaves_with_its_partner():
    runs = drawn(paired=True, outcome=False)
    holes = runs.second.values.copy()
    holes[::4] = np.nan
    left = runs_of(runs.first, runs.second._replace(values=holes), paired=True)
    assert left.n == 30
    assert (left.first.seeds == left.second.seeds).all()
    assert (left.first.cells == left.second.cells).all()


def test_shared_luck_raises_no_more_alarms_than_are_claimed():
    """Whole seeds are the unit: of cells that share all their luck, pairs counted alone would."""
    rng = np.random.default_rng(8)
    found = [
        contrast("stable", outcomes(rng, (0.6, 0.6), shared=0.95), "higher") for _ in range(400)
    ]
    assert np.mean([item.p_value < LEVEL for item in found]) < 0.08  # 400 draws scatter by 1.1
    held = [item.interval.low <= 0.0 <= item.interval.high for item in found]
    assert np.mean(held) > 0.92


@pytest.mark.parametrize("shared", [0.0, 0.8], ids=["alone", "hanging together"])
def test_the_seeds_that_would_tell_do_tell_four_times_in_five(shared):
    rng = np.random.default_rng(4)
    large = contrast("stable", outcomes(rng, (0.55, 0.75), seeds=500, shared=shared), "higher")
    few = replace(large, p_value=1.0, seeds=3)
    (advised,) = judged([few])
    assert advised.verdict == "cannot tell"
    told = [
        judged([contrast("stable", runs, "higher")])[0].verdict == "better"
        for runs in (
            outcomes(rng, (0.55, 0.75), seeds=int(advised.needed), shared=shared)
            for _ in range(150)
        )
    ]
    assert 0.68 < np.mean(told) < 0.92


def test_advice_is_given_where_nothing_is_told_and_asks_for_more_than_there_is():
    rng = np.random.default_rng(6)
    for _ in range(40):
        runs = [
            outcomes(rng, (0.7, rng.random()), seeds=int(rng.integers(2, 12))) for _ in range(3)
        ]
        for told in judged([contrast("stable", part, "higher") for part in runs]):
            assert (told.verdict == "cannot tell") or not told.advice
            assert told.verdict != "cannot tell" or told.needed > told.seeds


def test_what_could_not_have_told_anything_costs_the_others_nothing():
    rng = np.random.default_rng(2)
    sure = contrast("stable", outcomes(rng, (0.9, 0.35), seeds=12), "higher")
    hopeless = contrast("stable", outcomes(rng, (1.0, 1.0), seeds=12), "higher")
    assert judged([sure])[0].verdict == "worse"
    assert judged([sure, *[hopeless] * 200])[0].verdict == "worse"


def test_of_families_without_any_difference_few_name_one():
    rng = np.random.default_rng(9)
    named = 0
    for _ in range(100):
        family = [
            contrast("stable", outcomes(rng, (0.7, 0.7), cells=2), "higher") for _ in range(6)
        ]
        named += any(item.verdict in ("better", "worse") for item in judged(family))
    assert named / 100 < 0.13  # 5 % claimed; 100 families scatter by 2.2 points


@pytest.mark.parametrize(
    ("direction", "words"),
    [("higher", ["better"]), ("lower", ["worse"]), ("neither", ["higher"])],
)
def test_the_word_follows_from_what_is_better(direction, words):
    found = contrast("x", outcomes(np.random.default_rng(1), (0.1, 0.9)), direction)
    assert [item.verdict for item in judged([found])] == words
