from collections.abc import Sequence
from dataclasses import replace
from math import floor

import numpy as np
import pytest

from gaitlab.model.servo import Servo
from gaitlab.model.settings import Spread
from gaitlab.parameters import values
from gaitlab.servos.files import load_servo
from gaitlab.servos.latency import Latency, unequally_late

AX_12 = replace(load_servo("ax_12"), latency=0.08)
DT = 0.002  # s


def latencies(spread: float, seed: int = 0, latency: float = 0.08) -> np.ndarray:
    servos = [replace(AX_12, latency=latency)] * 1000
    late = unequally_late(servos, spread, np.random.default_rng(seed))
    return np.array([servo.latency for servo in late])


def heard(late: Sequence[float], sent: np.ndarray, dt: float = DT) -> np.ndarray:
    """What servos that are late by so many seconds hear. Shapes (n,) or (n, joints)."""
    rows = np.broadcast_to(sent[:, None], (len(sent), len(late))) if sent.ndim == 1 else sent
    servos = [replace(AX_12, latency=latency) for latency in late]
    return Latency(servos, dt, rows[0].copy()).arriving(rows.copy())


@pytest.fixture
def sent() -> np.ndarray:
    return np.random.default_rng(7).normal(size=(60, 3))


def test_no_spread_draws_nothing_and_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    servos = [AX_12] * 5
    assert unequally_late(servos, 0.0, rng) is servos
    assert rng.bit_generator.state == np.random.default_rng(1).bit_generator.state


def test_latencies_fill_the_range_and_nothing_else_of_a_servo_changes() -> None:
    found = latencies(0.04)
    assert 0.04 <= found.min() < 0.0405
    assert 0.1195 < found.max() <= 0.12
    assert found.mean() == pytest.approx(0.08, abs=0.003)  # s, four standard errors
    (servo,) = unequally_late([AX_12], 0.04, np.random.default_rng(2))
    assert replace(servo, latency=AX_12.latency) == AX_12


def test_one_draw_a_servo_in_their_order() -> None:
    rng = np.random.default_rng(3)
    found = [servo.latency for servo in unequally_late([AX_12] * 5, 0.01, rng)]
    drawn = np.random.default_rng(3)
    np.testing.assert_allclose(found, 0.08 + 0.01 * drawn.uniform(-1.0, 1.0, 5), rtol=1e-12)
    assert rng.bit_generator.state == drawn.bit_generator.state


def test_a_target_never_arrives_before_it_is_sent() -> None:
    assert latencies(0.1, latency=0.006).min() == 0.0


def test_seeds_differ_and_repeat() -> None:
    np.testing.assert_array_equal(latencies(0.01, seed=3), latencies(0.01, seed=3))
    assert np.any(latencies(0.01, seed=3) != latencies(0.01, seed=4))


def test_every_servo_hears_a_target_after_its_own_latency() -> None:
    servos: list[Servo] = [replace(AX_12, latency=n) for n in (0.0, 0.002, 0.006)]
    moving = Latency(servos, DT, np.zeros(3)).arriving(np.ones((5, 3))) > 0.0
    assert moving.argmax(axis=0).tolist() == [0, 1, 3]
    assert moving[-1].all()


def test_no_latency_passes_every_bit_through(sent) -> None:
    sent[5] = -0.0
    np.testing.assert_array_equal(heard([0.0] * 3, sent).view(np.int64), sent.view(np.int64))


@pytest.mark.parametrize("late", [(7, 7, 7), (0, 7, 31)])
@pytest.mark.parametrize("dt", [1e-4, 0.001, 0.002, 0.003, 0.004, 0.007])
def test_whole_ticks_shift_and_change_no_bit(sent, late, dt: float) -> None:
    sent[3] = -0.0
    found = heard([n * dt for n in late], sent, dt)
    for joint, n in enumerate(late):
        at = np.maximum(np.arange(len(sent)) - n, 0)
        wanted = np.ascontiguousarray(sent[at, joint])
        np.testing.assert_array_equal(found[:, joint].copy().view(np.int64), wanted.view(np.int64))


@pytest.mark.parametrize("late", [(0.0047,) * 3, (0.0047, 0.0, 0.0113)])
def test_between_two_ticks_a_target_lies_between_theirs(sent, late) -> None:
    found = heard(late, sent)
    for joint, latency in enumerate(late):
        n = floor(latency / DT)
        ticks = np.arange(n + 1, len(sent))
        pair = np.stack([sent[ticks - n, joint], sent[ticks - n - 1, joint]])
        assert np.all(found[ticks, joint] >= pair.min(axis=0) - 1e-12)
        assert np.all(found[ticks, joint] <= pair.max(axis=0) + 1e-12)


@pytest.mark.parametrize("dt", [0.0005, 0.001, 0.002, 0.004, 0.01])
@pytest.mark.parametrize("late", [(0.004,) * 3, (0.0137,) * 3, (0.0, 0.004, 0.0191)])
def test_the_delay_of_a_ramp_is_its_seconds_whatever_the_step_of_time(late, dt: float) -> None:
    time = dt * np.arange(round(0.1 / dt))
    found = heard(late, 3.0 * time, dt)
    settled = time > 0.0191 + dt
    wanted = 3.0 * (time[:, None] - np.array(late))
    np.testing.assert_allclose(found[settled], wanted[settled], rtol=1e-12)


def test_who_is_later_hears_a_rising_target_later() -> None:
    late = np.sort(np.random.default_rng(5).uniform(0.0, 0.02, 40))
    steps = np.random.default_rng(6).uniform(0.0, 1.0, 80)
    found = heard(late, np.cumsum(steps))
    assert np.all(np.diff(found, axis=1) <= 1e-12)
    assert np.all(np.diff(found, axis=0) >= -1e-12)


def test_a_servo_hears_the_same_whoever_else_is_late(sent) -> None:
    for late in (0.0, 0.004, 0.0047):
        alone = heard([late] * 3, sent)[:, 0]
        np.testing.assert_array_equal(heard([late, 0.0113, 0.05], sent)[:, 0], alone)


@pytest.mark.parametrize("late", [(0.0, 0.004, 0.0191), (0.0,) * 3, (0.0137,) * 3])
@pytest.mark.parametrize("cut", [1, 2, 7, 59])
def test_what_is_sent_at_once_arrives_as_what_is_sent_in_parts(sent, late, cut: int) -> None:
    servos = [replace(AX_12, latency=latency) for latency in late]
    whole = Latency(servos, DT, sent[0]).arriving(sent)
    parts = Latency(servos, DT, sent[0])
    found = np.concatenate([parts.arriving(sent[k : k + cut]) for k in range(0, len(sent), cut)])
    np.testing.assert_array_equal(found.view(np.int64), whole.view(np.int64))


def test_a_spread_of_latency_names_a_trial_only_where_it_is_used() -> None:
    assert "servo_latency" not in values(Spread())
    assert values(Spread(servo_latency=0.01))["servo_latency"] == 0.01
