"""An IMU tells the truth, late and with the errors of its replicate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.transforms import roll_pitch_yaw, rotation_of
from gaitlab.model.imu import Imu, Readings, attitude
from gaitlab.model.randomness import randomness

PERFECT = Imu(delay=0.0, rate_noise=0.0, rate_bias=0.0, attitude_noise=0.0, attitude_bias=0.0)
DT = 0.002  # s
numbers = st.floats(-1.0, 1.0)


def turned(k: int) -> tuple[tuple[float, float, float, float], tuple[float, float, float]]:
    """An orientation and a spin that differ from tick to tick."""
    half = 0.01 * (k + 1)
    return (0.0, np.sin(half), 0.0, np.cos(half)), (0.1 * k, 0.2, -0.3)


def readings(imu: Imu, ticks: int, seed: int = 0) -> np.ndarray:
    """What an IMU tells after each tick."""
    at_work = Readings(imu, DT, randomness(seed).imu)
    told = []
    for k in range(ticks):
        at_work.see(*turned(k))
        told.append(at_work.read())
    return np.array(told)


@given(st.tuples(numbers, numbers, numbers, numbers), st.tuples(numbers, numbers, numbers))
def test_attitude_is_the_trunks_own_pitch_roll_and_spin(quaternion, spin) -> None:
    length = np.linalg.norm(quaternion)
    if length < 0.1:
        return
    unit = tuple((np.array(quaternion) / length).tolist())
    rotation = rotation_of(np.array(unit))
    roll, pitch, _ = roll_pitch_yaw(rotation)
    felt = attitude(unit, spin)
    assert (felt.pitch, felt.roll) == pytest.approx((pitch, roll), abs=1e-9)
    own = rotation.T @ spin
    assert (felt.roll_rate, felt.pitch_rate) == pytest.approx(tuple(own[:2]), abs=1e-12)


def test_leaning_forward_and_right_is_positive() -> None:
    forward = attitude((0.0, np.sin(0.1), 0.0, np.cos(0.1)), (0.0, 0.5, 0.0))
    right = attitude((np.sin(0.1), 0.0, 0.0, np.cos(0.1)), (0.5, 0.0, 0.0))
    assert forward == pytest.approx((0.2, 0.0, 0.5, 0.0))
    assert right == pytest.approx((0.0, 0.2, 0.0, 0.5))


@pytest.mark.parametrize("ticks", [1, 2, 7])
def test_a_delay_of_n_ticks_tells_what_was_true_n_ticks_before(ticks: int) -> None:
    now = readings(PERFECT, 20)
    late = readings(replace(PERFECT, delay=ticks * DT), 20)
    np.testing.assert_array_equal(late[ticks:], now[:-ticks])
    np.testing.assert_array_equal(late[:ticks], now[:1].repeat(ticks, axis=0))


def test_a_replicate_has_its_own_errors_and_has_them_again() -> None:
    once, again, other = (readings(Imu(), 30, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(once, again)
    assert (once != other).all()


def test_a_bias_is_one_constant_of_the_replicate() -> None:
    biased = replace(PERFECT, rate_bias=0.1, attitude_bias=0.05)
    error = readings(biased, 10) - readings(PERFECT, 10)
    np.testing.assert_allclose(error, error[:1].repeat(10, axis=0), atol=1e-12)
    assert (np.abs(error) > 1e-4).all()


def test_noise_and_bias_are_as_large_as_stated() -> None:
    noisy = replace(PERFECT, rate_noise=0.2, attitude_noise=0.1)
    noise = (readings(noisy, 4000) - readings(PERFECT, 4000)).std(axis=0)
    assert noise == pytest.approx([0.1, 0.1, 0.2, 0.2], rel=0.05)  # 4000 draws: 1.1 % a sigma
    biased = replace(PERFECT, rate_bias=0.2, attitude_bias=0.1)
    truth = readings(PERFECT, 1)
    bias = np.array([(readings(biased, 1, seed) - truth)[0] for seed in range(1000)]).std(axis=0)
    assert bias == pytest.approx([0.1, 0.1, 0.2, 0.2], rel=0.1)  # 1000 draws: 2.2 % a sigma


def due(period: float, dt: float, ticks: int = 3000) -> np.ndarray:
    return np.flatnonzero([Imu(period=period).due(tick, dt) for tick in range(ticks)])


@pytest.mark.parametrize(("period", "ticks"), [(1e-4, 1), (0.002, 1), (0.01, 5), (0.2, 100)])
def test_readings_come_every_so_many_ticks_and_no_faster(period: float, ticks: int) -> None:
    np.testing.assert_array_equal(due(period, DT), np.arange(0, 3000, ticks))


@pytest.mark.parametrize("dt", [0.001, 0.002, 0.003, 0.004, 0.007, 0.01])
def test_readings_are_a_period_apart_whatever_the_step_of_time(dt: float) -> None:
    imu = Imu(period=0.01)
    time = due(imu.period, dt) * dt
    late = time - imu.period * np.arange(len(time))
    assert late.min() >= -1e-9
    assert late.max() < dt
    assert np.diff(time).mean() == pytest.approx(imu.spacing(dt), rel=0.01)


def test_the_imus_stream_shifts_no_other() -> None:
    before = [np.random.default_rng(child) for child in np.random.SeedSequence(3).spawn(4)]
    after = randomness(3)[:4]
    assert [rng.random() for rng in before] == [rng.random() for rng in after]


def test_the_yaw_rate_is_read_apart_and_changes_no_other_reading() -> None:
    half = 0.3
    tilted = (np.sin(half), 0.0, 0.0, np.cos(half))  # rolled by 0.6 rad
    true = Readings(replace(Imu(), rate_noise=0.0, rate_bias=0.0), DT, np.random.default_rng(0))
    assert true.turning(tilted, (0.0, 0.0, 1.0)) == pytest.approx(np.cos(0.6))
    assert true.turning(tilted, (0.0, 1.0, 0.0)) == pytest.approx(-np.sin(0.6))
    noisy = Readings(Imu(rate_noise=0.1, rate_bias=0.0), DT, np.random.default_rng(0))
    found = [noisy.turning(tilted, (0.0, 0.0, 0.0)) for _ in range(2000)]
    assert np.std(found) == pytest.approx(0.1, rel=0.1)
