"""The walk for any robot: smooth, feet that stay where they stand, and a mirror image of itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.gaits.walk import Gait
from gaitlab.model.gait import require_feet, require_walk
from gaitlab.model.stance import stance_of
from gaitlab.robots import bioloid, biped, eros, flow, nao

DT = 1e-3
WALKS = st.builds(
    Gait,
    step_length=st.floats(-0.1, 0.1),
    side_step=st.floats(-0.05, 0.05),
    turn=st.floats(-0.4, 0.4),
    gait_period=st.floats(0.4, 1.5),
    double_support_ratio=st.floats(0.0, 0.6),
    apex_phase=st.floats(0.3, 0.7),
    sway_phase=st.floats(-0.2, 0.2),
)


def times(gait: Gait, cycles: float = 3.0) -> np.ndarray:
    return np.arange(0.0, gait.startup_time + cycles * gait.gait_period, DT)


@given(WALKS)
def test_it_is_a_walk_and_stands_first(gait: Gait) -> None:
    t = times(gait)
    feet = gait.feet(t)
    require_walk(gait)
    require_feet(feet, len(t))
    standing = t <= gait.stand_time
    assert not feet.swing[standing].any()
    assert np.ptp(feet.position[standing], axis=0).max() < 1e-12


def largest_jump(gait: Gait, dt: float) -> np.ndarray:
    """By which an acceleration differs from one instant to the next. Shape (8,)."""
    feet = gait.feet(np.arange(0.0, gait.startup_time + 1.2 * gait.gait_period, dt))
    whole = np.concatenate([feet.position.reshape(-1, 6), feet.heading], axis=1)
    return np.abs(np.diff(whole, n=3, axis=0)).max(axis=0) / dt**2


@given(WALKS)
def test_targets_are_smooth_up_to_the_second_derivative(gait: Gait) -> None:
    """Closer instants have closer accelerations; a jump would stay as large as it is."""
    assert np.all(largest_jump(gait, DT / 4.0) < 0.5 * largest_jump(gait, DT) + 1e-3)


@given(WALKS)
def test_a_stance_foot_stays_where_it_is(gait: Gait) -> None:
    """Once at full amplitude, in a world through which the trunk goes at the commanded twist."""
    gait = replace(gait, lateral_sway=0.0, com_offset=0.0)
    t = gait.startup_time + np.arange(0.0, 2.0 * gait.gait_period, 0.01)
    feet = gait.feet(t)
    rate = 2.0 * np.array([gait.step_length, gait.side_step, gait.turn]) / gait.gait_period
    fine = np.linspace(0.0, t - t[0], 2001)  # the trunk's path, integrated
    yaw = rate[2] * fine
    path = np.trapezoid(
        np.stack([rate[0] * np.cos(yaw) - rate[1] * np.sin(yaw),
                  rate[0] * np.sin(yaw) + rate[1] * np.cos(yaw)], axis=-1),
        fine[..., None], axis=0,
    )  # fmt: skip
    c, s = np.cos(yaw[-1]), np.sin(yaw[-1])
    for foot in range(2):
        x, y = feet.position[:, foot, 0], feet.position[:, foot, 1]
        world = path + np.stack([c * x - s * y, s * x + c * y], axis=-1)
        facing = yaw[-1] + feet.heading[:, foot]
        stance = ~feet.swing[:, foot]
        both = stance[1:] & stance[:-1]
        assert np.abs(np.diff(world, axis=0)[both]).max(initial=0.0) < 1e-6
        assert np.abs(np.diff(facing)[both]).max(initial=0.0) < 1e-9
        assert feet.position[stance, foot, 2] == pytest.approx(-gait.hip_height)


@given(WALKS)
def test_half_a_period_later_it_is_its_own_mirror_image(gait: Gait) -> None:
    gait = replace(gait, side_step=0.0, turn=0.0)
    t = gait.startup_time + np.linspace(0.0, gait.gait_period, 50)
    now, later = gait.feet(t), gait.feet(t + gait.gait_period / 2.0)
    flip = np.array([1.0, -1.0, 1.0])
    assert np.allclose(later.position[:, ::-1] * flip, now.position, atol=1e-9)


@given(WALKS)
def test_the_mirrored_command_is_the_mirrored_walk_half_a_period_later(gait: Gait) -> None:
    other = replace(gait, side_step=-gait.side_step, turn=-gait.turn)
    t = gait.startup_time + np.linspace(0.0, gait.gait_period, 50)
    now, later = gait.feet(t), other.feet(t + gait.gait_period / 2.0)
    flip = np.array([1.0, -1.0, 1.0])
    assert np.allclose(later.position[:, ::-1] * flip, now.position, atol=1e-9)
    assert np.allclose(-later.heading[:, ::-1], now.heading, atol=1e-9)


@pytest.mark.parametrize("step_length", [0.05, -0.03])
def test_feet_are_a_step_length_apart_in_double_support(step_length: float) -> None:
    gait = Gait(step_length=step_length)
    feet = gait.feet(gait.startup_time + gait.gait_period * np.array([0.0, 0.5]))
    ahead = feet.position[:, 1, 0] - feet.position[:, 0, 0]
    assert ahead == pytest.approx([step_length, -step_length])


def test_the_apex_is_as_high_and_as_late_as_said() -> None:
    gait = Gait(apex_phase=0.4, double_support_ratio=0.2, step_height=0.05)
    t = gait.startup_time + np.linspace(0.0, 0.5, 5001) * gait.gait_period
    lift = gait.feet(t).position[:, 0, 2] + gait.hip_height
    swing = np.flatnonzero(gait.feet(t).swing[:, 0])
    assert lift.max() == pytest.approx(0.05)
    share = (np.argmax(lift) - swing[0]) / (swing[-1] - swing[0])
    assert share == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("robot", [eros, nao, bioloid, flow, biped], ids=lambda m: m.Robot.name)
def test_it_suits_every_shipped_robot(robot) -> None:
    """Scaled to its size it is within reach of the legs, steps sideways and round included."""
    made = robot.Robot()
    suited = Gait(**Gait.suited_to(made))
    ways = [{}]
    if suited.lateral_sway:  # legs that go sideways at all
        ways += [{"side_step": 0.3 * suited.step_length}]
    for way in ways:
        gait = replace(suited, **way)
        t = np.arange(0.0, gait.startup_time + gait.gait_period, 0.01)
        assert np.isfinite(made.joint_targets(gait.feet(t))).all()
    assert 0.3 < suited.gait_period / (2.0 * np.pi * np.sqrt(suited.hip_height / 9.81)) < 0.7
    assert suited.hip_height < stance_of(made).leg_length + 1e-9
