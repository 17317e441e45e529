"""The sinusoidal walk: smooth, periodic, mirrored, with feet that stand still on the ground."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.gaits.flow import Gait
from gaitlab.model.gait import Gait as GaitProtocol
from gaitlab.parameters import parameters
from gaitlab.robots.flow import Robot

GAIT = Gait(step_length=0.08)
STEP = 1e-4  # s, between two instants of a fine grid


def walking(gait: Gait, cycles: float = 2.0) -> np.ndarray:
    """Instants of whole cycles at full amplitude."""
    n = round(cycles * gait.gait_period / STEP)
    return gait.startup_time + np.arange(n) * STEP


def test_it_is_a_gait() -> None:
    gait: GaitProtocol = GAIT
    assert gait.startup_time == pytest.approx(gait.gait_period * 2.0 + GAIT.stand_time)


def test_a_cycle_repeats_itself() -> None:
    t = walking(GAIT, 1.0)
    one, next_one = GAIT.feet(t), GAIT.feet(t + GAIT.gait_period)
    np.testing.assert_allclose(one.position, next_one.position, atol=1e-12)


def test_half_a_cycle_later_the_feet_have_changed_sides() -> None:
    t = walking(GAIT, 1.0)
    one = GAIT.feet(t).position
    other = GAIT.feet(t + GAIT.gait_period / 2.0).position[:, ::-1]
    np.testing.assert_allclose(one, other * [1.0, -1.0, 1.0], atol=1e-12)


def test_a_standing_foot_goes_back_at_the_walking_speed_and_stays_level() -> None:
    feet = GAIT.feet(walking(GAIT))
    speed = np.diff(feet.position, axis=0) / STEP
    standing = ~feet.swing[1:] & ~feet.swing[:-1]
    expected = -2.0 * GAIT.step_length / GAIT.gait_period
    np.testing.assert_allclose(speed[..., 0][standing], expected, atol=1e-9)
    np.testing.assert_allclose(speed[..., 2][standing], 0.0, atol=1e-9)


def test_both_feet_sway_together() -> None:
    apart = np.ptp(GAIT.feet(walking(GAIT)).position[..., 1], axis=1)
    np.testing.assert_allclose(apart, GAIT.step_width, atol=1e-12)


def test_position_and_speed_are_continuous() -> None:
    t = np.arange(0.0, GAIT.startup_time + GAIT.gait_period, STEP)
    position = GAIT.feet(t).position
    speed = np.diff(position, axis=0) / STEP
    assert np.abs(speed).max() < 2.0  # m/s, so that no jump hides in the steps below
    after_start = t[2:] > GAIT.startup_time + 2 * STEP
    acceleration = np.diff(speed, axis=0)[after_start] / STEP
    assert np.abs(acceleration).max() < 40.0  # m/s^2; a jump of 0.1 m/s would be 1000


def test_feet_are_a_step_apart_in_the_middle_of_double_support() -> None:
    feet = GAIT.feet(np.array([GAIT.startup_time, GAIT.startup_time + GAIT.gait_period / 2.0]))
    apart = feet.position[:, 0, 0] - feet.position[:, 1, 0]
    np.testing.assert_allclose(apart, [GAIT.step_length, -GAIT.step_length], atol=1e-12)
    assert not feet.swing.any()


def test_the_foot_is_lifted_by_step_height_and_only_while_it_swings() -> None:
    feet = GAIT.feet(walking(GAIT))
    height = feet.position[..., 2] + GAIT.hip_height
    assert height.max() == pytest.approx(GAIT.step_height, abs=1e-6)
    assert height.min() == pytest.approx(0.0, abs=1e-12)
    assert height[~feet.swing].max() < 1e-12


@settings(max_examples=20, deadline=None)
@given(both=st.floats(0.0, 0.8))
def test_double_support_lasts_as_long_as_is_asked(both: float) -> None:
    gait = dataclasses.replace(GAIT, double_support_ratio=both)
    swing = gait.feet(walking(gait)).swing
    assert not swing.all(axis=1).any()
    assert np.mean(~swing.any(axis=1)) == pytest.approx(both, abs=0.002)


def test_it_stands_before_it_walks_and_counts_steps_from_then_on() -> None:
    t = np.array([0.0, GAIT.stand_time, GAIT.startup_time, GAIT.startup_time + GAIT.gait_period])
    feet = GAIT.feet(t)
    np.testing.assert_allclose(feet.position[0], feet.position[1], atol=1e-12)
    assert feet.step_index.tolist() == [-1, -1, 0, 2]
    assert np.isnan(feet.phase).tolist() == [True, True, False, False]


def test_no_step_and_no_lift_is_standing() -> None:
    still = Gait(step_length=0.0, step_height=0.0, lateral_sway=0.0)
    position = still.feet(walking(still)).position
    np.testing.assert_allclose(position, np.broadcast_to(position[0], position.shape), atol=1e-15)


def test_flow_can_take_every_pose_of_its_default_walk() -> None:
    t = np.arange(0.0, Gait().startup_time + Gait().gait_period, 0.002)
    assert Robot().joint_targets(Gait().feet(t)).shape == (len(t), 25)


def test_every_parameter_says_where_its_default_comes_from() -> None:
    for item in parameters(Gait):
        assert item.source.startswith("assumption"), item.name
