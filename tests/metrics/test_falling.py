"""Stable, stalled, fallen: when, why, and which way."""

from __future__ import annotations

from math import inf, isnan, nan

import numpy as np
import pytest

from gaitlab.metrics import measure
from tests.synthetic import HEADER, fall, header, walk

# s, from the first lean to 45 degrees at 3 rad/s, and the tenth of a second it must last
TOPPLING = np.pi / 4.0 / 3.0 + 0.1


def test_without_a_fall_nothing_is_said_of_one():
    found = measure(walk())
    assert (found["fell"], found["stable"], found["stable_strict"]) == (False, True, True)
    assert found["fall_cause"] is found["fall_direction"] is None
    assert isnan(found["time_to_fall"])
    assert isnan(found["fall_phase"])


@pytest.mark.parametrize("at", [0.5, 2.0, 3.3])
def test_time_to_fall_counts_from_the_end_of_the_start_up(at):
    found = measure(fall(at=at))
    assert (found["fell"], found["stable"], found["stable_strict"]) == (True, False, False)
    assert found["time_to_fall"] == pytest.approx(at + TOPPLING, abs=HEADER.dt)


@pytest.mark.parametrize("first", [0.0, 0.9, 1.0, 1.001, 2.0, 5.0, inf, nan])
@pytest.mark.parametrize("at", [-0.9, 0.5, 2.0])
def test_a_fall_is_one_in_standing_if_it_comes_before_the_first_step(at, first):
    log = fall(at=at, head=header(first_step_time=first))
    found = measure(log)
    fell_at = found["time_to_fall"] + HEADER.startup_time
    assert found["fell"]
    assert found["fell_standing"] == (fell_at < first + HEADER.dt / 2)


@pytest.mark.parametrize("first", [0.0, 1.0, inf, nan])
def test_who_stays_up_did_not_fall_standing(first):
    assert measure(walk(header(first_step_time=first)))["fell_standing"] is False


def test_the_row_that_ends_as_the_step_begins_is_still_standing():
    at = measure(fall(at=0.5))["time_to_fall"] + HEADER.startup_time
    found = [
        measure(fall(at=0.5, head=header(first_step_time=at + ticks * HEADER.dt)))["fell_standing"]
        for ticks in (-1, 0, 1)
    ]
    assert found == [False, True, True]


def test_time_to_fall_is_negative_in_the_start_up():
    found = measure(fall(at=-0.9))
    assert found["time_to_fall"] == pytest.approx(-0.9 + TOPPLING, abs=HEADER.dt)
    assert isnan(found["fall_phase"])
    assert (found["stable"], found["stable_strict"], found["stalled"]) == (False, False, False)


@pytest.mark.parametrize("heading", [0.0, 2.0, -3.1])
@pytest.mark.parametrize("direction", ["forward", "backward", "left", "right"])
def test_fall_direction_is_seen_by_the_robot(direction, heading):
    assert measure(fall(direction, heading=heading))["fall_direction"] == direction


def test_a_robot_that_turns_over_on_its_face_still_fell_forward():
    def over(walked):
        return 18.0 * np.maximum(walked - 2.0, 0.0)

    def turned(walked):  # as an attitude past 90 degrees reads: yaw and roll flip
        return np.where(over(walked) > np.pi / 2.0, np.pi, 0.0)

    log = walk(
        pitch=lambda w: np.where(over(w) > np.pi / 2.0, np.pi - over(w), over(w)),
        roll=turned,
        yaw=turned,
    )
    assert abs(log["yaw"][log.fall_index]) > 3.0
    assert measure(log)["fall_direction"] == "forward"


def test_a_roll_that_is_larger_than_the_pitch_decides():
    lean = {"pitch": lambda w: 1.4 * np.maximum(w - 3.0, 0.0)}
    assert measure(fall("right", **lean))["fall_direction"] == "right"


@pytest.mark.parametrize(
    ("cause", "courses"),
    [
        ("tilt", {"pitch": lambda w: np.where(w > 2.0, 1.0, 0.0)}),
        ("body_contact", {"body_contact": lambda w: w > 2.0}),
        ("low_trunk", {"trunk_z": lambda w: np.where(w > 2.0, 0.17, 0.3)}),
    ],
)
def test_fall_cause_names_the_part_of_the_rule(cause, courses):
    assert measure(walk(**courses))["fall_cause"] == cause


def test_fall_phase_is_the_phase_at_the_fall():
    found = measure(fall())
    turns = found["time_to_fall"] / HEADER.gait_period
    assert found["fall_phase"] == pytest.approx(turns % 1.0, abs=HEADER.dt / HEADER.gait_period)


@pytest.mark.parametrize(("share", "stalled"), [(0.49, True), (0.51, False), (-1.0, True)])
@pytest.mark.parametrize("step_length", [0.04, -0.04])
def test_a_robot_stalls_below_half_of_the_commanded_distance(share, stalled, step_length):
    head = header(step_length=step_length)
    found = measure(walk(head, speed=share * head.commanded_speed))
    assert (found["stalled"], found["stable"], found["stable_strict"]) == (
        stalled,
        True,
        not stalled,
    )


def test_a_fallen_robot_has_not_stalled():
    found = measure(fall(speed=0.0))
    assert (found["stalled"], found["stable_strict"]) == (False, False)


@pytest.mark.parametrize("speed", [0.0, -0.01, 0.01])
def test_a_robot_told_to_step_on_the_spot_only_has_to_stay_up(speed):
    found = measure(walk(header(step_length=0.0), speed=speed))
    assert (found["stalled"], found["stable"], found["stable_strict"]) == (False, True, True)


@pytest.mark.parametrize("at", [0.5, 2.0])
def test_upright_time_is_the_walked_time_of_a_robot_that_fell(at):
    found = measure(fall(at=at))
    assert found["upright_time"] == found["walked_time"] > 0.0


def test_upright_time_is_all_that_was_asked_for_without_a_fall():
    asked = HEADER.horizon_time
    assert measure(walk())["upright_time"] == asked > measure(walk())["walked_time"]


def test_upright_time_is_never_longer_than_asked_for():
    assert measure(fall(at=2.0, head=header(horizon_time=1.0)))["upright_time"] == 1.0


def test_upright_time_of_a_fall_in_the_start_up_is_zero():
    assert measure(fall(at=-0.9))["upright_time"] == 0.0
