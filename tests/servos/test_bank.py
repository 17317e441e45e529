from dataclasses import replace

import numpy as np
import pytest

from gaitlab.canonical import values
from gaitlab.servos import Servo
from gaitlab.servos.bank import ServoBank, unequally_late
from gaitlab.servos.files import load_servo
from gaitlab.settings import Spread

AX_12 = replace(load_servo("ax_12"), latency=40)


def latencies(spread: float, seed: int = 0, latency: int = 40) -> np.ndarray:
    servos = [replace(AX_12, latency=latency)] * 1000
    late = unequally_late(servos, spread, np.random.default_rng(seed))
    return np.array([servo.latency for servo in late])


def test_no_spread_draws_nothing_and_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    servos = [AX_12] * 5
    assert unequally_late(servos, 0.0, rng) is servos
    assert rng.bit_generator.state == np.random.default_rng(1).bit_generator.state


def test_latencies_fill_the_range_and_nothing_else_of_a_servo_changes() -> None:
    found = latencies(20.0)
    assert (found.min(), found.max()) == (20, 60)
    assert found.mean() == pytest.approx(40.0, abs=1.5)  # ticks, four standard errors
    (servo,) = unequally_late([AX_12], 20.0, np.random.default_rng(2))
    assert replace(servo, latency=AX_12.latency) == AX_12


def test_a_target_never_arrives_before_it_is_sent() -> None:
    assert latencies(50.0, latency=3).min() == 0


def test_seeds_differ_and_repeat() -> None:
    np.testing.assert_array_equal(latencies(5.0, seed=3), latencies(5.0, seed=3))
    assert np.any(latencies(5.0, seed=3) != latencies(5.0, seed=4))


def test_every_servo_hears_a_target_after_its_own_latency() -> None:
    servos: list[Servo] = [replace(AX_12, latency=n) for n in (0, 1, 3)]
    bank = ServoBank(servos, np.ones(3), 0.002, np.zeros(3), np.eye(3))
    still = np.zeros(3)
    heard = [bank.drive(np.ones(3), still, still, still)[0] for _ in range(5)]
    moving = np.array(heard) > 0.0
    assert moving.argmax(axis=0).tolist() == [0, 1, 3]
    assert moving[-1].all()


def test_a_spread_of_latency_names_a_trial_only_where_it_is_used() -> None:
    assert "servo_latency" not in values(Spread())
    assert values(Spread(servo_latency=5.0))["servo_latency"] == 5.0
