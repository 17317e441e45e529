"""Counting: what is scored, what is not, and how sure one may be."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.report.scores import (
    EMPTY,
    ScoredCell,
    cell_of,
    efficiency_draws,
    interval_of,
    mean_percent,
    surface_percent,
)

STATES = st.sampled_from(["DONE", "INFEASIBLE", "FAILED", "MISSING"])


def cell(k: int, n: int) -> ScoredCell:
    outcomes = (True,) * k + (False,) * (n - k)
    return ScoredCell(stable=outcomes, strict=outcomes, infeasible=0, failed=0, missing=0)


def infeasible(n: int) -> ScoredCell:
    return ScoredCell(stable=(False,) * n, strict=(False,) * n, infeasible=n, failed=0, missing=0)


@given(st.lists(st.tuples(STATES, st.booleans()), min_size=1))
def test_every_trial_is_counted_once(trials: list[tuple[str, bool]]) -> None:
    frame = pd.DataFrame(trials, columns=["state", "up"])
    flags = frame["up"].where(frame["state"] == "DONE").astype("boolean")
    found = cell_of(frame.assign(stable=flags, stable_strict=flags))
    assert found.planned == len(trials)
    assert found.count() == sum(up for state, up in trials if state == "DONE")
    assert found.n == sum(state in ("DONE", "INFEASIBLE") for state, _ in trials)


def test_steps_out_of_reach_count_as_unstable_and_failures_do_not_count() -> None:
    assert infeasible(3).verdict() is False
    failed = ScoredCell(stable=(True,), strict=(True,), infeasible=0, failed=5, missing=4)
    assert failed.verdict() is True
    assert (failed.n, failed.planned) == (1, 10)


def test_half_of_the_seeds_make_a_cell_stable() -> None:
    assert [cell(k, 4).verdict() for k in range(5)] == [False, False, True, True, True]


def test_a_cell_without_a_score_is_neither_stable_nor_unstable() -> None:
    assert EMPTY.verdict() is None
    assert surface_percent([EMPTY, cell(4, 4)]) == 100.0
    assert math.isnan(mean_percent([[EMPTY]]))


@pytest.mark.parametrize("k", [0, 3])
def test_three_seeds_that_agree_are_not_certain(k: int) -> None:
    bounds = interval_of(efficiency_draws([[cell(k, 3)] * 4] * 4))
    assert bounds.high > bounds.low


def test_an_infeasible_cell_is_certain() -> None:
    assert np.all(efficiency_draws([[infeasible(3)]]) == 0.0)


def test_more_seeds_narrow_the_interval_around_the_efficiency() -> None:
    widths = []
    for n in (4, 12, 40):
        surfaces = [[cell(3 * n // 4, n), cell(n // 4, n)]] * 4
        bounds = interval_of(efficiency_draws(surfaces))
        assert bounds.low <= mean_percent(surfaces) <= bounds.high
        widths.append(bounds.high - bounds.low)
    assert widths[0] > widths[1] > widths[2]


def test_the_same_stream_draws_alike_and_another_does_not() -> None:
    surfaces = [[cell(2, 4)] * 5]
    first, again = efficiency_draws(surfaces), efficiency_draws(surfaces)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, efficiency_draws(surfaces, stream=1))
