"""The level that half survive: its estimate, and how often its interval holds the truth."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.statistics import Count, half_point

LEVELS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
EXPERIMENTS = 3000
ERROR = 3.0 * np.sqrt(0.05 * 0.95 / EXPERIMENTS)  # of a coverage, three standard deviations
COUNTS = st.lists(
    st.integers(1, 20).flatmap(lambda n: st.builds(Count, st.integers(0, n), st.just(n))),
    min_size=1,
    max_size=6,
)


def counted(survived: np.ndarray) -> list[Count]:
    """Counts of trials. Shape (seeds, levels)."""
    return [Count(int(column.sum()), len(column)) for column in survived.T]


def paired(rng: np.random.Generator, n: int, truth: float, spread: float) -> np.ndarray:
    """Every seed has a strength of its own, which decides at all levels."""
    return rng.normal(truth, spread, (n, 1)) >= np.array(LEVELS)


def independent(rng: np.random.Generator, n: int, truth: float, spread: float) -> np.ndarray:
    """Chance decides anew at every level."""
    return rng.normal(truth, spread, (n, len(LEVELS))) >= np.array(LEVELS)


@pytest.mark.parametrize("draw", [paired, independent])
@pytest.mark.parametrize("seeds", [4, 6, 10, 25])
@pytest.mark.parametrize(("truth", "spread"), [(1.0, 0.5), (0.99, 0.05), (1.51, 1.0), (2.4, 0.3)])
def test_the_interval_holds_the_truth_as_often_as_it_says(
    draw: Callable[..., np.ndarray], seeds: int, truth: float, spread: float
) -> None:
    rng, held = np.random.default_rng(seeds), 0
    for _ in range(EXPERIMENTS):
        low, high = half_point(LEVELS, counted(draw(rng, seeds, truth, spread))).bounds
        held += low <= truth <= high
    assert held / EXPERIMENTS >= 0.95 - ERROR


@pytest.mark.parametrize("truth", [0.8, 1.3, 2.2])
def test_the_estimate_finds_the_truth_between_two_levels(truth: float) -> None:
    """As near as a straight line between two levels is to the curve."""
    survived = paired(np.random.default_rng(0), 20_000, truth, 0.7)
    assert half_point(LEVELS, counted(survived)).value == pytest.approx(truth, abs=0.05)


def test_nothing_is_said_beyond_what_was_tried() -> None:
    n = len(LEVELS)
    assert half_point(LEVELS, [Count(10, 10)] * n) == (inf, (LEVELS[-1], inf))
    assert half_point(LEVELS, [Count(0, 10)] * n) == (-inf, (-inf, LEVELS[0]))


def test_five_seeds_bound_nothing() -> None:
    """One in thirty-two is more often than one in forty."""
    found = half_point((0.0, 1.0), [Count(5, 5), Count(0, 5)])
    assert found == (0.5, (-inf, inf))
    assert half_point((0.0, 1.0), [Count(6, 6), Count(0, 6)]).bounds == (0.0, 1.0)


@settings(max_examples=200, deadline=None)
@given(COUNTS)
def test_the_interval_holds_the_estimate(counts: list[Count]) -> None:
    found = half_point(LEVELS[: len(counts)], counts)
    assert found.bounds.low <= found.value <= found.bounds.high or (
        found.value == -inf and found.bounds.low == -inf
    )


@settings(max_examples=200, deadline=None)
@given(COUNTS)
def test_who_falls_instead_of_surviving_turns_the_levels_round(counts: list[Count]) -> None:
    levels = LEVELS[: len(counts)]
    fell = [Count(n - k, n) for k, n in reversed(counts)]
    found, mirrored = half_point(levels, counts), half_point([-x for x in reversed(levels)], fell)
    assert mirrored.bounds == (-found.bounds.high, -found.bounds.low)


def test_more_confidence_is_a_wider_interval() -> None:
    counts = [Count(10, 10), Count(9, 10), Count(6, 10), Count(2, 10), Count(1, 10), Count(0, 10)]
    wide, narrow = (half_point(LEVELS, counts, c).bounds for c in (0.999, 0.9))
    assert wide.low <= narrow.low <= narrow.high <= wide.high


@pytest.mark.parametrize(
    ("levels", "counts"),
    [((), ()), ((1.0, 1.0), [Count(1, 2)] * 2), ((1.0,), [Count(0, 0)]), ((1.0,), [])],
)
def test_what_says_nothing_is_refused(levels: tuple[float, ...], counts: list[Count]) -> None:
    with pytest.raises(ValueError, match="level"):
        half_point(levels, counts)
