import dataclasses
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.gaits.eros import Gait, deceleration_increments, heel_pitch
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import get_path, parameters
from gaitlab.robots.eros import Robot

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "eros.json").read_text())
TOLERANCE = 1e-9  # m and degrees, digits of the reference vectors
LAWS = ("log_tail", "log_front", "linear")

VARIANTS = [
    Gait(step_length=length, x_law=x_law, landing_deceleration=law, tick_increment=increment)
    for length, x_law, law, increment in itertools.product(
        (-0.05, 0.0, 0.04), ("printed", "quarter"), ("none", "log_tail"), np.radians((4.0, 4.5))
    )
]
every_gait = pytest.mark.parametrize("gait", VARIANTS)


def cycle_times(gait: Gait, cycles: float = 1.0) -> np.ndarray:
    """Control ticks of the first cycles at full amplitude."""
    ticks = round(cycles * gait.gait_period / gait.control_period)
    return gait.startup_time + np.arange(ticks) * gait.control_period


def whole_walk(gait: Gait) -> np.ndarray:
    """Every control tick from standing through two cycles at full amplitude."""
    end = gait.startup_time + 2.0 * gait.gait_period
    return np.arange(round(end / gait.control_period)) * gait.control_period


def from_step_one(gait: Gait, lifting_ticks: int) -> FeetPoses:
    """A cycle that starts with the paper's step 1, the left landing: three steps in."""
    half = round(gait.gait_period / gait.control_period) // 2
    return gait.feet(cycle_times(gait) + (half + lifting_ticks) * gait.control_period)


@pytest.mark.parametrize("case", GOLDEN["trajectory"]["cases"])
def test_trajectory_equals_the_reference(case: dict[str, Any]) -> None:
    gait = Gait(
        step_length=case["X"],
        lateral_sway=case["Ysw"],
        step_height=case["lift"],
        hip_height=-case["z0"] - Robot().hip_offset(),
        step_width=case["y0_leg_a"] - case["y0_leg_b"],
        tick_increment=np.radians(case["T_mn_deg"]),
        x_law=case["law"],
    )
    assert gait.gait_period == pytest.approx(case["n_ticks"] * gait.control_period)
    feet = from_step_one(gait, case["n_ticks"] // 4)
    in_trunk = feet.position - [0.0, 0.0, Robot().hip_offset()]
    for sample in case["samples"]:
        expected = [sample["leg_a"], sample["leg_b"]]
        np.testing.assert_allclose(in_trunk[sample["tick"]], expected, atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["landing_deceleration"]["cases"])
def test_landing_deceleration_equals_the_reference(case: dict[str, Any]) -> None:
    increment = np.radians(case["T_mn_deg"])
    increments = deceleration_increments(case["kind"], increment, case["n"], case["C_DC"])
    np.testing.assert_allclose(np.degrees(increments), case["T_mn_DC_deg"], atol=TOLERANCE)
    gait = Gait(
        step_length=0.024,
        lateral_sway=0.025,
        tick_increment=increment,
        landing_deceleration=case["kind"],
        deceleration_areas=case["n"],
        deceleration_gain=case["C_DC"],
    )
    landing, lifting = case["ticks_per_step"][:2]
    assert gait.gait_period == pytest.approx(sum(case["ticks_per_step"]) * gait.control_period)
    sway = from_step_one(gait, lifting).position[:landing, 0, 1] - 0.5 * gait.step_width
    angle = np.arccos(np.clip(sway / gait.lateral_sway, -1.0, 1.0))
    np.testing.assert_allclose(np.degrees(angle), case["T_deg_step1"], atol=1e-6)


@pytest.mark.parametrize("case", GOLDEN["heel_strike"]["cases"])
@pytest.mark.parametrize("mode", ["add", "literal"])
def test_heel_strike_equals_the_reference(case: dict[str, Any], mode: str) -> None:
    gain = case["C_H_mm_per_deg"] / 1000.0 * 180.0 / np.pi
    pitch = heel_pitch(np.array(case["dz_mm"] / 1000.0), gain, limit=1.0)
    level = np.radians(case["theta5_ik_deg"])
    hip_pitch = -level - np.radians(case["knee_deg"])
    share = 1.0 if mode == "literal" else 0.0
    found = np.degrees(level + share * hip_pitch + pitch)
    assert found == pytest.approx(case[f"theta5_{mode}_deg"], abs=TOLERANCE)


@every_gait
def test_no_axis_moves_faster_than_its_amplitude_times_the_increment(gait: Gait) -> None:
    position = gait.feet(whole_walk(gait)).position
    # While an amplitude grows from 0 to 1 in a cycle, that growth comes on top.
    growth = gait.control_period / gait.gait_period
    amplitude = np.array([abs(gait.step_length) / 2.0, gait.lateral_sway, gait.step_height])
    bound = amplitude * (gait.tick_increment + growth) + 1e-12
    assert np.all(np.abs(np.diff(position, axis=0)) <= bound)
    full = gait.feet(cycle_times(gait, 2.0)).position
    assert np.all(np.abs(np.diff(full, axis=0)) <= amplitude * gait.tick_increment + 1e-12)


@every_gait
def test_the_cycle_closes_exactly(gait: Gait) -> None:
    feet = gait.feet(cycle_times(gait, 2.0))
    first, second = np.split(feet.position, 2)
    np.testing.assert_array_equal(first, second)


@every_gait
def test_right_foot_repeats_the_left_half_a_cycle_later(gait: Gait) -> None:
    position = gait.feet(cycle_times(gait)).position
    later = np.roll(position, len(position) // 2, axis=0)
    mirrored = later[:, ::-1] * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(position, mirrored, atol=1e-15)


@every_gait
def test_feet_are_a_step_length_apart_in_double_support(gait: Gait) -> None:
    position = gait.feet(cycle_times(gait)).position
    half = len(position) // 2
    apart = position[[half - 1, -1], 1, 0] - position[[half - 1, -1], 0, 0]
    np.testing.assert_allclose(apart, [gait.step_length, -gait.step_length], atol=1e-15)
    np.testing.assert_allclose(position[[half - 1, -1], :, 2], -gait.hip_height, atol=1e-15)


@every_gait
def test_the_swing_foot_rises_to_the_step_height_and_the_other_stays_down(gait: Gait) -> None:
    feet = gait.feet(cycle_times(gait))
    lift = feet.position[..., 2] + gait.hip_height
    np.testing.assert_allclose(lift.max(axis=0), gait.step_height, atol=1e-15)
    assert np.all(lift[~feet.swing] <= 1e-15)
    assert np.all(lift[feet.swing] > 0.0)
    assert not np.any(feet.swing.all(axis=1))


@every_gait
def test_the_trunk_sways_over_the_standing_foot(gait: Gait) -> None:
    feet = gait.feet(cycle_times(gait))
    sway = feet.position[:, 0, 1] - 0.5 * gait.step_width
    left_alone = feet.swing[:, 1]
    assert np.all(sway[left_alone] < 1e-15)  # feet move right of the trunk: it is over the left
    assert np.all(sway[feet.swing[:, 0]] > -1e-15)
    assert sway.max() == pytest.approx(gait.lateral_sway)


def test_quarter_law_touches_down_at_rest_and_printed_law_does_not() -> None:
    for law, slowest in (("quarter", True), ("printed", False)):
        gait = Gait(x_law=law, tick_increment=np.radians(1.0))
        feet = gait.feet(cycle_times(gait))
        x = feet.position[: len(feet.phase) // 2, 1, 0]
        speed = np.abs(np.diff(x))
        assert bool(speed[-1] < 0.02 * speed.max()) is slowest


def test_the_startup_stands_then_ramps_without_a_jump() -> None:
    gait = Gait(step_length=0.06, trunk_pitch=0.1, com_offset=0.01)
    t = whole_walk(gait)
    feet = gait.feet(t)
    standing = t < gait.stand_time - 1e-9
    still = feet.position[standing]
    assert np.all(still == still[0])
    in_place = t < gait.stand_time + gait.gait_period - 1e-9
    level = Gait(step_length=0.06, com_offset=0.01).feet(t)
    np.testing.assert_allclose(level.position[in_place][..., 0], -0.01, atol=1e-15)
    assert level.position[~in_place][..., 0].max() == pytest.approx(0.03 - 0.01)
    largest = np.abs(np.diff(feet.position, axis=0)).max()
    walking = np.abs(np.diff(feet.position[t > gait.startup_time], axis=0)).max()
    # While the steps grow, half a step's growth in one tick comes on top.
    growth = 0.5 * gait.step_length * gait.control_period / gait.gait_period
    assert largest <= walking + growth


def test_sway_and_height_grow_in_place_before_the_steps_do() -> None:
    gait = Gait(step_length=0.06)
    ranges = []
    for cycle in range(4):
        start = gait.stand_time + cycle * gait.gait_period
        # The last quarter is left out: a growing cycle ends at full amplitude.
        t = np.linspace(start, start + 0.75 * gait.gait_period - 1e-6, 500)
        ranges.append(np.ptp(gait.feet(t).position, axis=(0, 1)))
    in_place, growing, full, later = ranges
    assert in_place[0] == 0.0 < growing[0] < full[0]
    assert 0.0 < in_place[2] < growing[2] == full[2]
    np.testing.assert_array_equal(full, later)


@every_gait
def test_phase_and_step_index_start_with_full_amplitude(gait: Gait) -> None:
    t = whole_walk(gait)
    feet = gait.feet(t)
    before = t < gait.startup_time - 1e-9
    assert np.all(np.isnan(feet.phase[before]))
    assert np.all(feet.step_index[before] == -1)
    phase, step = feet.phase[~before], feet.step_index[~before]
    assert phase[0] == 0.0
    assert np.all((phase >= 0.0) & (phase < 1.0))
    assert np.all(np.isin(np.diff(step), (0, 1)))
    assert (step[0], step[-1]) == (0, 3)
    expected = (t[~before] - gait.startup_time) / gait.gait_period % 1.0
    np.testing.assert_allclose((phase - expected + 0.5) % 1.0, 0.5, atol=1e-9)
    np.testing.assert_array_equal(step % 2, (phase >= 0.5).astype(int))


def test_a_footstep_begins_when_a_foot_lifts_the_right_one_first() -> None:
    gait = Gait()
    feet = gait.feet(cycle_times(gait))
    np.testing.assert_array_equal(feet.swing[feet.step_index == 0, 0], False)
    np.testing.assert_array_equal(feet.swing[feet.step_index == 1, 1], False)
    assert feet.swing[0, 1]
    assert feet.swing[np.flatnonzero(feet.step_index == 1)[0], 0]


def test_a_target_is_held_until_the_next_control_tick() -> None:
    gait = Gait(heel_strike="add")
    ticks = whole_walk(gait)
    start = gait.feet(ticks)
    for share in (0.2, 0.5, 0.99):
        held = gait.feet(ticks + share * gait.control_period)
        for field in dataclasses.fields(FeetPoses):
            np.testing.assert_array_equal(getattr(held, field.name), getattr(start, field.name))
    fine = gait.feet(np.arange(len(ticks) * 5) * (gait.control_period / 5.0))
    np.testing.assert_array_equal(fine.position, np.repeat(start.position, 5, axis=0))


def test_instants_are_independent_of_each_other() -> None:
    gait = Gait(heel_strike="literal", landing_deceleration="linear")
    t = np.random.default_rng(13).uniform(0.0, 6.0, size=200)
    together = gait.feet(t)
    alone = np.concatenate([gait.feet(t[k : k + 1]).position for k in range(len(t))])
    np.testing.assert_array_equal(together.position, alone)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("areas", "gain"), [(2, 0.3), (5, 0.7), (10, 0.95)])
def test_deceleration_falls_from_full_speed_to_what_the_gain_leaves(
    law: str, areas: int, gain: float
) -> None:
    increments = deceleration_increments(law, 0.07, areas, gain)
    assert increments[0] == pytest.approx(0.07)
    assert increments[-1] == pytest.approx(0.07 * (1.0 - gain))
    assert np.all(np.diff(increments) < 0.0)


def test_log_tail_keeps_more_speed_than_linear_and_log_front_less() -> None:
    tail, linear, front = (
        deceleration_increments(law, 0.07, 6, 0.7).mean()
        for law in ("log_tail", "linear", "log_front")
    )
    assert tail > linear > front


@pytest.mark.parametrize("law", LAWS)
def test_deceleration_without_gain_changes_nothing(law: str) -> None:
    slowed = Gait(landing_deceleration=law, deceleration_gain=0.0)
    t = whole_walk(Gait())
    np.testing.assert_allclose(slowed.feet(t).position, Gait().feet(t).position, atol=1e-15)


@pytest.mark.parametrize("x_law", ["printed", "quarter"])
@pytest.mark.parametrize("law", LAWS)
def test_only_landings_are_slowed(law: str, x_law: str) -> None:
    plain, slowed = Gait(x_law=x_law), Gait(x_law=x_law, landing_deceleration=law)
    lift = round(plain.gait_period / plain.control_period) // 4
    one, other = plain.feet(cycle_times(plain)), slowed.feet(cycle_times(slowed))
    np.testing.assert_array_equal(one.position[:lift], other.position[:lift])
    assert slowed.gait_period > plain.gait_period


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("degrees", [4.0, 5.0, 6.0, 7.3])
def test_the_matched_control_lasts_as_long_and_is_even(law: str, degrees: float) -> None:
    slowed = Gait(landing_deceleration=law, tick_increment=np.radians(degrees))
    even = dataclasses.replace(slowed, match_period_of_deceleration=True)
    assert even.gait_period == slowed.gait_period
    sway = even.feet(cycle_times(even)).position[:, 0, 1] - 0.5 * even.step_width
    phase = 2.0 * np.pi * (np.arange(len(sway)) + 1) / len(sway)
    # Lift and landing differ by at most one tick, which is how far the phase may be off.
    off = np.pi / (len(sway) - 1)
    np.testing.assert_allclose(
        sway, -even.lateral_sway * np.sin(phase), atol=even.lateral_sway * off
    )


def test_no_deceleration_to_match_leaves_the_gait_as_it_is() -> None:
    gait = Gait(tick_increment=np.radians(4.0))  # does not divide 90 degrees
    matched = dataclasses.replace(gait, match_period_of_deceleration=True)
    t = whole_walk(gait)
    np.testing.assert_array_equal(matched.feet(t).position, gait.feet(t).position)


@pytest.mark.parametrize("mode", ["none", "add", "literal"])
@pytest.mark.parametrize("sign", [-1, 0, 1])
def test_heel_strike_touches_the_moving_foot_alone(mode: str, sign: int) -> None:
    gait = Gait(heel_strike=mode, push_off_sign=sign)
    feet = gait.feet(whole_walk(gait))
    assert np.all(feet.ankle_pitch[~feet.swing] == 0.0)
    assert np.all(feet.knee_only[~feet.swing] == 0.0)
    assert np.any(feet.ankle_pitch != 0.0) is np.bool_(mode != "none")
    assert np.any(feet.knee_only != 0.0) is np.bool_(mode == "literal")


def test_heel_strike_added_between_level_feet_is_the_level_ankle() -> None:
    feet = Gait(heel_strike="add", step_height=0.0).feet(cycle_times(Gait()))
    assert np.all(feet.ankle_pitch == 0.0)
    assert np.all(feet.knee_only == 0.0)


def test_added_heel_strike_is_the_height_difference_over_the_gain() -> None:
    gait = Gait(heel_strike="add", heel_gain=0.3)
    feet = gait.feet(cycle_times(gait))
    z = feet.position[..., 2]
    for foot in (0, 1):
        swing = feet.swing[:, foot]
        expected = -(z[swing, foot] - z[swing, 1 - foot]) / 0.3
        np.testing.assert_allclose(feet.ankle_pitch[swing, foot], expected, atol=1e-15)


def test_toe_up_stops_at_its_limit() -> None:
    gait = Gait(heel_strike="add", heel_gain=0.02, toe_up_limit=0.2)
    assert gait.feet(cycle_times(gait)).ankle_pitch.min() == -0.2


@pytest.mark.parametrize("mode", ["add", "literal"])
def test_push_off_sign_turns_the_lift_and_never_the_landing(mode: str) -> None:
    up, level, down = (Gait(heel_strike=mode, push_off_sign=sign) for sign in (1, 0, -1))
    t = cycle_times(up)
    lift = slice(0, len(t) // 4)
    late = slice(len(t) // 4 + len(t) // 12, len(t) // 2)
    right = [gait.feet(t).ankle_pitch[:, 1] for gait in (up, level, down)]
    np.testing.assert_array_equal(right[0][lift], -right[2][lift])
    assert np.all(right[1][lift] == 0.0)
    assert np.all(right[0][lift] < 0.0)
    for other in right[1:]:
        np.testing.assert_allclose(other[late], right[0][late], atol=1e-15)


@pytest.mark.parametrize("sign", [-1, 0, 1])
def test_literal_heel_strike_is_the_published_law_in_mid_landing(sign: int) -> None:
    gait, robot = Gait(heel_strike="literal", push_off_sign=sign, step_height=0.01), Robot()
    feet = gait.feet(cycle_times(gait))
    joints = robot.joint_targets(feet)
    quarter = len(joints) // 4
    k = quarter + quarter // 2  # the right foot, 45 degrees into its landing
    difference = feet.position[k, 1, 2] - feet.position[k, 0, 2]
    knee, ankle_pitch = joints[k, 9], joints[k, 10]
    assert ankle_pitch == pytest.approx(-(difference / gait.heel_gain + knee), abs=1e-12)


@pytest.mark.parametrize(("mode", "sign"), list(itertools.product(["add", "literal"], [-1, 0, 1])))
def test_the_ankle_moves_without_a_jump_and_lands_level(mode: str, sign: int) -> None:
    gait = Gait(heel_strike=mode, push_off_sign=sign, tick_increment=np.radians(1.0))
    feet, robot = gait.feet(whole_walk(gait)), Robot()
    joints = robot.joint_targets(feet)
    plain = robot.joint_targets(Gait(tick_increment=np.radians(1.0)).feet(whole_walk(gait)))
    added = (joints - plain)[:, [4, 10]]
    # Toe-up of at most 25 degrees comes or goes within 30 of T's degrees, one a tick.
    assert np.abs(np.diff(added, axis=0)).max() < np.radians(2.0)
    assert np.all(np.abs(added[~feet.swing]) == 0.0)


def test_a_leaning_trunk_keeps_the_feet_level_and_in_place() -> None:
    upright, leaning = Gait(), Gait(trunk_pitch=0.2)
    t = whole_walk(upright)
    one, other = upright.feet(t), leaning.feet(t)
    assert np.all(other.trunk_pitch == 0.2)
    c, s = np.cos(0.2), np.sin(0.2)
    back = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    np.testing.assert_allclose(other.position @ back.T, one.position, atol=1e-15)


def test_default_gait_is_feasible_for_the_robot_forwards_and_backwards() -> None:
    for step_length in (-0.06, 0.0, 0.06):
        gait = Gait(step_length=step_length)
        joints = Robot().joint_targets(gait.feet(whole_walk(gait)))
        assert joints.shape == (len(whole_walk(gait)), 20)


def test_every_parameter_has_a_default_within_its_range_and_a_source() -> None:
    for parameter in parameters(Gait):
        kind = parameter.source.split(":")[0]
        assert kind in ("published", "assumption", "reconstruction"), parameter.name
        value = get_path(Gait(), parameter.name)
        if parameter.low is not None and parameter.high is not None:
            assert parameter.low <= value <= parameter.high
