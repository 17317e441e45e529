"""The fall rule: its three causes, its delays, and tick by tick as over whole arrays."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.log.columns import columns
from gaitlab.log.course import Course
from gaitlab.log.fall import CAUSES
from gaitlab.simulation.ending import ARRIVED, GOES_ON, LOST, Ending
from tests.synthetic import fall_causes

DT = 0.002
HEIGHT = 0.3
UPRIGHT, TILTED = cos(radians(44.9)), cos(radians(45.1))
HIGH, LOW = 0.601 * HEIGHT, 0.599 * HEIGHT


def ending(dt: float = DT, startup: int = 0, distance: float = np.inf, **way: float) -> Ending:
    course = Course(**{"ahead": 0.1, **way})
    return Ending(dt=dt, standing_height=HEIGHT, startup=startup, distance=distance, course=course)


def trunk(upright: float, height: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    """A trunk that is pitched so far."""
    half = np.arccos(upright) / 2.0
    return np.array([x, y, height, 0.0, np.sin(half), 0.0, np.cos(half)])


def streamed(upright, body_contact, trunk_height, dt=DT) -> list[int]:
    """Cause at each tick; the trial ends with the first, and it stays."""
    rule, found = ending(dt), [GOES_ON]
    for tilt, touches, height in zip(upright, body_contact, trunk_height, strict=True):
        found.append(found[-1] or rule.after(trunk(tilt, height), touches))
    return found[1:]


def causes(*ticks: tuple[float, bool, float], dt: float = DT) -> list[int]:
    return streamed(*zip(*ticks, strict=True), dt=dt)


segments = st.lists(
    st.tuples(
        st.sampled_from([1.0, UPRIGHT, TILTED, -1.0]),
        st.booleans(),
        st.sampled_from([HEIGHT, HIGH, HIGH, LOW]),
        st.integers(1, 60),
    ),
    min_size=1,
    max_size=12,
)


@given(segments, st.sampled_from([0.001, 0.002, 0.003, 1 / 240]))
def test_detector_and_array_form_agree(parts, dt):
    upright, contact, height = (
        np.concatenate([np.full(part[3], part[i]) for part in parts]) for i in range(3)
    )
    expected = streamed(upright.tolist(), contact.tolist(), height.tolist(), dt)
    assert fall_causes(upright, contact, height, dt, HEIGHT).tolist() == expected


def test_tilt_is_a_fall_at_the_tick_that_completes_a_tenth_of_a_second():
    assert causes(*[(TILTED, False, HEIGHT)] * 50) == [0] * 49 + [1]


def test_body_contact_is_a_fall_at_the_tick_that_completes_a_twentieth_of_a_second():
    assert causes(*[(1.0, True, HEIGHT)] * 25) == [0] * 24 + [2]


def test_low_trunk_is_a_fall_at_once():
    assert causes((1.0, False, HIGH), (1.0, False, LOW)) == [0, 3]


@pytest.mark.parametrize(
    ("bad", "ticks"), [((TILTED, False, HEIGHT), 49), ((1.0, True, HEIGHT), 24)]
)
def test_an_interrupted_condition_starts_again(bad, ticks):
    good = (UPRIGHT, False, HIGH)
    assert not any(causes(*([bad] * ticks + [good]) * 3))


def test_a_robot_may_lean_by_less_than_45_degrees_for_ever():
    assert not any(causes(*[(UPRIGHT, False, HIGH)] * 1000))


def test_causes_of_the_same_tick_rank_tilt_then_contact_then_height():
    both = [(1.0, False, HEIGHT)] * 25 + [(1.0, True, HEIGHT)] * 25
    tilted = [(TILTED, contact, height) for _, contact, height in both]
    assert causes(*tilted[:-1], (TILTED, True, LOW))[-1] == 1
    assert causes(*both[:-1], (1.0, True, LOW))[-1] == 2


def test_duration_does_not_depend_on_the_time_step():
    for dt in (0.001, 0.002, 0.004, 0.005, 0.01, 1 / 1470):  # 0.1 * 1470 is a hair over 147
        ticks = causes(*[(TILTED, False, HEIGHT)] * 150, dt=dt).index(1) + 1
        assert ticks * dt == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("lost", [np.nan, np.inf])
@pytest.mark.parametrize("at", range(7))
def test_a_number_that_is_none_ends_the_trial_and_is_no_fall(lost: float, at: int) -> None:
    row = trunk(1.0, HEIGHT)
    row[at] = lost
    assert ending().after(row, False) == LOST


@pytest.mark.parametrize("ahead", [0.1, -0.1])
def test_a_trunk_arrives_as_far_from_where_the_walk_began_as_asked(ahead: float) -> None:
    rule = ending(startup=3, distance=0.5, ahead=ahead)
    way = [(0.2, 1.0), (0.0, 1.0), (0.1, 1.0), (0.59, 1.2), (-0.39, 0.8), (0.61, 1.2)]
    found = [rule.after(trunk(1.0, HEIGHT, x, y), False) for x, y in way]
    assert found == [GOES_ON] * 5 + [ARRIVED]


def test_a_fall_at_the_goal_is_a_fall() -> None:
    rule = ending(distance=0.1)
    rule.after(trunk(1.0, HEIGHT), False)
    assert rule.after(trunk(1.0, LOW, 1.0), False) == 3


def test_causes_are_named_in_the_order_of_the_log_column():
    (doc,) = (column.doc for column in columns(()) if column.name == "fall_cause")
    words = [part.strip().split(" ", 1) for part in doc.split(",")]
    assert [int(code) for code, _ in words] == list(range(len(CAUSES)))
    assert [word.replace(" ", "_") for _, word in words[1:]] == list(CAUSES[1:])
