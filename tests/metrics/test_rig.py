"""Figures of robots on belts and gantries."""

from __future__ import annotations

from math import isnan, sqrt

import pytest

from gaitlab.metrics import lookup
from gaitlab.metrics.energy import absolute_work, energy
from gaitlab.metrics.feet import sole_penetration
from gaitlab.metrics.joints import (
    coupling_residual,
    on_gantry,
    peak_balancing_moment,
    peak_torque,
    rms_balancing_moment,
    rms_torque,
    saturation_share,
)
from tests.synthetic import HEADER, header, sine, walk

BELTED = header(
    joints=("left_knee", "left_ankle", "right_knee", "right_ankle", "gantry_pitch"),
    torque_limits=(2.5, 0.0, 2.5, 0.0, 0.0),
)
ON_BELTS = ("coupling_residual", "peak_balancing_moment", "rms_balancing_moment")


def test_the_residual_is_the_worst_of_the_coupled_joints_alone() -> None:
    log = walk(
        BELTED,
        left_ankle_position=0.2,
        left_ankle_target=0.25,
        right_ankle_position=-0.1,
        right_ankle_target=-0.08,
        left_knee_position=1.0,
        gantry_pitch_position=0.7,
    )
    assert coupling_residual(log) == pytest.approx(0.05, abs=1e-6)


@pytest.mark.parametrize("name", ON_BELTS)
def test_a_robot_on_its_own_has_no_figure_of_belts_and_gantry(name: str) -> None:
    assert isnan(lookup(name)(walk(left_knee_torque=1.0)))


def test_the_gantry_is_no_servo_but_has_a_moment() -> None:
    plain = walk(BELTED, left_knee_torque=sine(1.0), left_knee_velocity=2.0)
    log = walk(
        BELTED,
        left_knee_torque=sine(1.0),
        left_knee_velocity=2.0,
        gantry_pitch_torque=sine(40.0),
        gantry_pitch_velocity=3.0,
        left_ankle_torque=9.0,
    )
    for figure in (energy, absolute_work, peak_torque, rms_torque, saturation_share):
        assert figure(log) == figure(plain)
    assert peak_balancing_moment(log) == pytest.approx(40.0, rel=1e-3)
    assert rms_balancing_moment(log) == pytest.approx(40.0 / sqrt(2.0), rel=1e-3)


def test_every_result_declares_whether_the_robot_hung_on_a_gantry() -> None:
    assert on_gantry(walk(BELTED)) is True
    assert on_gantry(walk()) is False


def test_braking_counts_as_driving_in_absolute_work_only() -> None:
    log = walk(left_knee_torque=-1.0, left_knee_velocity=2.0)
    assert energy(log) == 0.0
    walked = 6.0 * HEADER.gait_period
    assert absolute_work(log) == pytest.approx(2.0 * walked, rel=1e-6)


def test_a_sole_in_the_pile_is_not_in_the_base() -> None:
    pile = HEADER.pile_height
    assert sole_penetration(walk(left_foot_sink=0.9 * pile)) == 0.0
    assert sole_penetration(walk(left_foot_sink=pile + 0.002)) == pytest.approx(0.002, abs=1e-6)
