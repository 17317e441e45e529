"""Torque, saturation, energy and cost of transport."""

from __future__ import annotations

from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.metrics import measure
from gaitlab.metrics.energy import energy
from gaitlab.metrics.tracking_error import tracking_error
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


def test_energy_does_not_depend_on_the_time_step():
    courses = {"left_knee_torque": sine(1.0), "left_knee_velocity": sine(2.0)}
    fine, coarse = (walk(header(dt=dt), **courses) for dt in (0.001, 0.01))
    assert energy(fine) == pytest.approx(energy(coarse), rel=1e-3)
    assert energy(fine) == pytest.approx(1.0 * WALKED, rel=1e-3)  # mean of 2 sin^2 is 1


def test_cost_of_transport_is_energy_over_weight_and_distance():
    found = measure(walk(left_knee_torque=1.0, left_knee_velocity=2.0))
    weight = 2.0 * 9.81
    assert found["cost_of_transport"] == pytest.approx(found["energy"] / weight / found["distance"])


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
