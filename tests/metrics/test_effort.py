"""Torque, saturation, energy and cost of transport."""

from __future__ import annotations

from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.log import TrialLog
from gaitlab.metrics import measure
from gaitlab.metrics.energy import absolute_work, energy
from gaitlab.metrics.joints import tracking_error
from tests.synthetic import HEADER, header, sine, walk

WALKED = 6.0 * HEADER.gait_period  # s


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_energy_of_a_constant_torque_is_torque_times_angle_and_never_negative(torque, velocity):
    log = walk(left_knee_torque=torque, left_knee_velocity=velocity)
    assert energy(log) == pytest.approx(max(torque * velocity, 0.0) * WALKED, abs=1e-5)


def test_one_joint_that_brakes_gives_nothing_to_another():
    log = walk(
        left_knee_torque=1.0,
        left_knee_velocity=2.0,
        right_knee_torque=1.0,
        right_knee_velocity=-2.0,
    )
    assert energy(log) == pytest.approx(2.0 * WALKED, rel=1e-6)


def pushed(torques: np.ndarray, inertia: float, dt: float) -> tuple[TrialLog, np.ndarray]:
    """A joint alone, moved as an engine moves it, and its speeds from before the walk on."""
    head = header(dt=dt)
    speeds = np.cumsum(torques) * dt / inertia
    start = round(head.startup_time / dt)
    log = walk(
        head,
        cycles=len(torques) * dt / head.gait_period - start * dt / head.gait_period,
        left_knee_torque=lambda walked: torques[: len(walked)],
        left_knee_velocity=lambda walked: speeds[: len(walked)],
    )
    return log, speeds[log.walking.start - 1 : log.walking.stop]


@pytest.mark.parametrize("dt", [0.001, 0.005, 0.02])
def test_work_is_what_it_adds_to_the_kinetic_energy(dt: float) -> None:
    rng = np.random.default_rng(4)
    inertia = 0.003
    log, speeds = pushed(rng.normal(0.0, 0.05, round(5.0 / dt)), inertia, dt)
    work = float(log.joint_power[log.walking].sum()) * dt
    gained = 0.5 * inertia * (speeds[-1] ** 2 - speeds[0] ** 2)
    assert work == pytest.approx(gained, rel=1e-5, abs=1e-7)
    assert energy(log) - absolute_work(log) == pytest.approx(0.5 * (work - absolute_work(log)))


def test_a_joint_that_speeds_up_from_rest_and_brakes_to_rest_costs_as_much_either_way() -> None:
    ticks = 1000
    torques = np.concatenate([np.full(ticks // 2, 0.02), np.full(ticks // 2, -0.02)])
    there, _ = pushed(torques, 0.003, 0.005)
    back, _ = pushed(-torques, 0.003, 0.005)
    assert energy(there) == pytest.approx(energy(back))
    power = there.joint_power[:, 0]
    assert power[: ticks // 2].sum() == pytest.approx(-power[ticks // 2 :].sum(), rel=1e-3)
    # The same motion seen backwards: speeds change sign, and the torques act in reverse order.
    backwards = {
        "left_knee_torque": lambda walked: torques[::-1],
        "left_knee_velocity": lambda walked: np.append(-np.cumsum(torques)[-2::-1], 0.0) * 5 / 3,
    }
    reverse = walk(there.header, cycles=5.0, **backwards)
    np.testing.assert_allclose(reverse.joint_power[1:-1, 0], -power[-2:0:-1], rtol=1e-5, atol=1e-7)


def test_a_window_begins_with_the_speed_of_the_row_before_it() -> None:
    start = round(HEADER.startup_time / HEADER.dt)

    def since(row: int, value: float):
        return lambda walked: np.where(np.arange(len(walked)) >= row, value, 0.0)

    log = walk(left_knee_torque=since(start, 1.0), left_knee_velocity=since(start, 2.0))
    assert log.walking.start == start
    assert log.joint_power[start, 0] == 1.0
    assert log.joint_power[start + 1, 0] == 2.0


def test_energy_does_not_depend_on_the_time_step():
    def worked(dt: float) -> TrialLog:
        # A row's torque is that of its tick, so of the tick's middle; its velocity is of the end.
        torque = sine(1.0)
        return walk(
            header(dt=dt),
            left_knee_torque=lambda walked: torque(walked - 0.5 * dt),
            left_knee_velocity=sine(2.0),
        )

    fine, coarse = worked(0.001), worked(0.01)
    assert energy(fine) == pytest.approx(energy(coarse), rel=1e-3)
    assert energy(fine) == pytest.approx(1.0 * WALKED, rel=1e-3)  # mean of 2 sin^2 is 1


def test_cost_of_transport_is_energy_over_weight_and_distance():
    found = measure(walk(left_knee_torque=1.0, left_knee_velocity=2.0))
    weight = 2.0 * 9.81
    assert found["cost_of_transport"] == pytest.approx(found["energy"] / weight / found["distance"])


def test_cost_of_transport_asks_what_was_walked_not_what_was_commanded():
    work = {"left_knee_torque": 1.0, "left_knee_velocity": 2.0}
    whole, half = measure(walk(**work)), measure(walk(speed=0.5 * HEADER.commanded_speed, **work))
    assert half["distance"] == pytest.approx(0.5 * whole["distance"])
    assert half["cost_of_transport"] == pytest.approx(2.0 * whole["cost_of_transport"])


def test_cost_of_transport_of_a_robot_that_goes_nowhere_is_not_a_number():
    work = {"left_knee_torque": 1.0, "left_knee_velocity": 2.0}
    assert isnan(measure(walk(speed=0.0, **work))["cost_of_transport"])
    assert isnan(measure(walk(header(step_length=0.0), speed=0.1, **work))["cost_of_transport"])


def test_peak_torque_is_the_largest_either_way():
    found = measure(walk(left_knee_torque=1.0, right_hip_roll_torque=-1.5))
    assert found["peak_torque"] == 1.5


def test_rms_torque_of_one_working_joint_of_four_is_half_its_torque():
    assert measure(walk(left_knee_torque=1.2))["rms_torque"] == pytest.approx(0.6, rel=1e-6)


@pytest.mark.parametrize(("torque", "share"), [(2.5, 0.25), (-2.5, 0.25), (2.46, 0.25), (2.4, 0.0)])
def test_saturation_share_counts_joints_at_their_limit(torque, share):
    assert measure(walk(left_knee_torque=torque))["saturation_share"] == share


def test_each_joint_has_its_own_limit():
    head = header(torque_limits=(1.0, 2.5, 2.5, 2.5))
    found = measure(walk(head, left_knee_torque=1.0, right_knee_torque=1.0))
    assert found["saturation_share"] == 0.25


def test_saturation_share_counts_ticks():
    found = measure(walk(left_knee_torque=lambda w: np.where(w > WALKED / 2.0, 2.5, 0.0)))
    assert found["saturation_share"] == pytest.approx(0.125, abs=1e-3)


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_tracking_error_of_one_joint_that_lags_is_its_lag_over_the_root_of_the_joints(target, lag):
    log = walk(left_knee_target=target, left_knee_position=target - lag)
    assert tracking_error(log) == pytest.approx(abs(lag) / len(HEADER.joints) ** 0.5, abs=1e-6)


def test_tracking_error_grows_with_latency():
    def late(latency: float) -> float:
        course = sine(0.2)
        return tracking_error(
            walk(
                left_knee_target=course,
                left_knee_position=lambda walked: course(walked - latency),
            )
        )

    assert 0.0 == late(0.0) < late(0.004) < late(0.012)
