"""The time left is right as soon as anything is known, and learns where robots soon fall."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.running.forecast import Forecast

CARPET, GRASS = ("eros", "carpet_4mm", "0"), ("eros", "grass_50mm", "1")


def walked(
    forecast: Forecast, kind: tuple[str, ...], planned: float, spent: float, at: float
) -> None:
    """One more trial, from its start at an instant to its end."""
    name = f"{kind} {planned} {at}"
    forecast.start(name, kind, planned, at)
    forecast.end(name, at + spent)


def test_nothing_is_promised_while_only_first_trials_of_workers_have_ended() -> None:
    forecast = Forecast(workers=2)
    for _ in range(4):
        forecast.expect(CARPET, 10.0)
    for number in range(3):
        assert forecast.time_left(100.0 * number) is None
        walked(forecast, CARPET, 10.0, 2.0, 100.0 * number)
    assert forecast.time_left(300.0) == pytest.approx(1.0)


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
        if done > workers or done == len(lengths):
            left = pace * sum(lengths[done:]) / workers
            assert forecast.time_left(now) == pytest.approx(left, rel=1e-9, abs=1e-9)


def test_long_trials_weigh_more_than_short_ones() -> None:
    forecast = Forecast(workers=1)
    for length in (5.0, 5.0, 5.0, 50.0):
        forecast.expect(CARPET, length)
    for at in (0.0, 1.0):
        walked(forecast, CARPET, 5.0, 1.0, at)
    assert forecast.time_left(2.0) == pytest.approx(11.0)


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


def test_a_cell_of_which_nothing_is_known_is_like_others_on_its_ground() -> None:
    forecast = Forecast(workers=1)
    unknown = ("eros", "grass_50mm", "7")
    forecast.expect(unknown, 10.0)
    for number in range(5):
        for kind, spent in ((CARPET, 2.0), (GRASS, 0.2)):
            forecast.expect(kind, 10.0)
            walked(forecast, kind, 10.0, spent, 10.0 * number)
    left = forecast.time_left(100.0)
    assert left is not None
    assert 0.2 < left < 0.6


def test_a_trial_that_runs_counts_down_and_never_below_nothing() -> None:
    forecast = Forecast(workers=2)
    for _ in range(4):
        forecast.expect(CARPET, 10.0)
    for at in (0.0, 2.0, 4.0):
        walked(forecast, CARPET, 10.0, 2.0, at)
    forecast.start("last", CARPET, 10.0, 6.0)
    told = [forecast.time_left(now) for now in (6.0, 7.5, 30.0)]
    assert told == pytest.approx([2.0, 0.5, 0.0]), "one trial alone is not shared among workers"


def test_a_machine_that_slows_down_is_noticed() -> None:
    forecast = Forecast(workers=1)
    for _ in range(300):
        forecast.expect(CARPET, 10.0)
    for number in range(100):
        walked(forecast, CARPET, 10.0, 2.0, 10.0 * number)
    for number in range(100, 200):
        walked(forecast, CARPET, 10.0, 4.0, 10.0 * number)
    assert forecast.time_left(9000.0) == pytest.approx(400.0, rel=0.1)


def test_the_start_of_a_worker_is_not_taken_for_the_pace_of_its_trials() -> None:
    forecast = Forecast(workers=1)
    for _ in range(12):
        forecast.expect(CARPET, 10.0)
    forecast.start("first", CARPET, 10.0, 0.0)
    forecast.end("first", 14.0)
    walked(forecast, CARPET, 10.0, 2.0, 14.0)
    left = forecast.time_left(16.0)
    assert left is not None
    assert 20.0 <= left < 35.0
