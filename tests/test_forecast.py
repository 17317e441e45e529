"""The time left is right as soon as anything is known, and learns where robots soon fall."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.dispatch.forecast import Forecast

CARPET, GRASS = ("eros", "carpet_4mm"), ("eros", "grass_50mm")


def walked(forecast: Forecast, kind: tuple[str, str], planned: float, spent: float, at: float):
    """One more trial, from its start at an instant to its end."""
    name = f"{kind} {planned} {at}"
    forecast.start(name, kind, planned, at)
    forecast.end(name, at + spent)


def test_nothing_is_promised_before_the_first_trial_has_ended() -> None:
    forecast = Forecast(workers=2)
    forecast.expect(CARPET, 10.0)
    assert forecast.time_left(0.0) is None


@given(
    st.lists(st.floats(0.5, 100.0), min_size=2, max_size=12),
    st.floats(0.05, 3.0),
    st.integers(1, 8),
)
def test_at_a_steady_pace_every_second_of_the_forecast_comes_true(
    lengths: list[float], pace: float, workers: int
) -> None:
    """One after another on one worker; on several, the rest is shared among them."""
    forecast = Forecast(workers=workers)
    for length in lengths:
        forecast.expect(CARPET, length)
    now = 0.0
    for done, length in enumerate(lengths, start=1):
        walked(forecast, CARPET, length, pace * length, now)
        now += pace * length
        left = pace * sum(lengths[done:]) / workers
        assert forecast.time_left(now) == pytest.approx(left, rel=1e-9, abs=1e-9)


def test_long_trials_weigh_more_than_short_ones() -> None:
    forecast = Forecast(workers=1)
    for length in (5.0, 5.0, 50.0):
        forecast.expect(CARPET, length)
    walked(forecast, CARPET, 5.0, 1.0, 0.0)
    assert forecast.time_left(1.0) == pytest.approx(11.0)


def test_falls_on_one_ground_do_not_shorten_the_other() -> None:
    """Fifty trials a ground: a tenth of the time on grass is no promise for the carpet."""
    forecast = Forecast(workers=1)
    for kind in (GRASS, CARPET):
        for _ in range(50):
            forecast.expect(kind, 10.0)
    for number in range(25):
        walked(forecast, GRASS, 10.0, 0.2, 100.0 * number)
        walked(forecast, CARPET, 10.0, 2.0, 100.0 * number + 50.0)
    truth = 25 * 0.2 + 25 * 2.0
    assert abs(forecast.time_left(2500.0) - truth) < 0.05 * truth
    for number in range(25):
        walked(forecast, GRASS, 10.0, 0.2, 3000.0 + number)
    left = forecast.time_left(4000.0)
    assert abs(left - 50.0) < 5.0, "what is left is carpet, which takes its whole time"


def test_a_trial_that_runs_counts_down_and_never_below_nothing() -> None:
    forecast = Forecast(workers=2)
    for _ in range(2):
        forecast.expect(CARPET, 10.0)
    walked(forecast, CARPET, 10.0, 2.0, 0.0)
    forecast.start("last", CARPET, 10.0, 2.0)
    assert [forecast.time_left(now) for now in (2.0, 3.5, 30.0)] == pytest.approx([2.0, 0.5, 0.0])


def test_a_trial_alone_is_not_shared_among_workers() -> None:
    forecast = Forecast(workers=8)
    for _ in range(2):
        forecast.expect(CARPET, 10.0)
    walked(forecast, CARPET, 10.0, 4.0, 0.0)
    forecast.start("last", CARPET, 10.0, 4.0)
    assert forecast.time_left(4.0) == pytest.approx(4.0)


def test_the_start_of_a_worker_is_not_taken_for_the_pace_of_its_trials() -> None:
    forecast = Forecast(workers=1)
    for _ in range(11):
        forecast.expect(CARPET, 10.0)
    forecast.start("first", CARPET, 10.0, 0.0)
    forecast.end("first", 5.0, spent=2.0)
    assert forecast.time_left(5.0) == pytest.approx(20.0)
