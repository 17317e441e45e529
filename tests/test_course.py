"""Distances along a commanded way: what walks it as commanded is on it, wherever it goes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.log.course import Course
from gaitlab.simulation.ending import Ending, gone

SPEEDS, RATES = st.floats(-0.5, 0.5), st.floats(-2.0, 2.0)
T = np.linspace(0.0, 9.0, 400)


def walked(course: Course, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The way that a trunk goes at a constant twist: its exponential."""
    if not course.rate:
        return course.ahead * t, course.aside * t
    angle = course.rate * t
    s, v = np.sin(angle) / course.rate, (1.0 - np.cos(angle)) / course.rate
    return s * course.ahead - v * course.aside, v * course.ahead + s * course.aside


@given(SPEEDS, SPEEDS, RATES)
def test_what_goes_as_commanded_is_as_far_as_commanded_and_beside_nothing(ahead, aside, rate):
    course = Course(ahead=ahead, aside=aside, rate=rate if abs(rate) > 1e-3 else 0.0)
    along, across = course.of(*walked(course, T)).T
    if abs(course.speed) > 1e-3:
        assert along == pytest.approx(abs(course.speed) * T, abs=1e-6)
    assert across == pytest.approx(0.0, abs=1e-6)


@given(SPEEDS, SPEEDS, RATES)
def test_a_mirror_changes_the_side_and_nothing_else(ahead, aside, rate):
    there, here = (Course(ahead=ahead, aside=k * aside, rate=k * rate) for k in (-1.0, 1.0))
    x, y = np.cos(T) - 1.0, np.sin(2.0 * T)
    if abs(here.speed) > 1e-2:
        one, other = here.of(x, y), there.of(x, -y)
        assert other[:, 0] == pytest.approx(one[:, 0], abs=1e-6)
        assert other[:, 1] == pytest.approx(-one[:, 1], abs=1e-6)


@given(st.floats(0.05, 0.5), SPEEDS)
def test_a_turn_that_vanishes_leaves_the_line(ahead, aside):
    """Within what the arc leaves the line by over the length of the walk."""
    line = Course(ahead=ahead, aside=aside or 0.1)
    arc = Course(ahead=ahead, aside=aside or 0.1, rate=1e-6)
    x, y = 0.3 * T, 0.1 * T
    assert arc.of(x, y) == pytest.approx(line.of(x, y), abs=1e-3)


@given(st.floats(0.05, 0.5), RATES)
def test_one_point_after_another_is_all_points_at_once(ahead, rate):
    course = Course(ahead=ahead, aside=0.02, rate=rate)
    way = Ending(dt=0.01, standing_height=1.0, startup=0, distance=1.0, course=course).rule[5:]
    x, y = walked(course, T)
    so_far = 0.0
    for a, b in zip(x, y, strict=True):
        so_far = gone(way, a, b, so_far)
    assert so_far == pytest.approx(course.of(x, y)[-1, 0], abs=1e-6)


def test_straight_ahead_and_back_are_as_they_were() -> None:
    x, y = np.array([0.0, 1.0]), np.array([0.0, 0.5])
    assert np.array_equal(Course(ahead=0.1).of(x, y), [[0.0, 0.0], [1.0, 0.5]])
    assert np.array_equal(Course(ahead=-0.1).of(x, y), [[0.0, 0.0], [-1.0, 0.5]])
    assert np.array_equal(Course(ahead=0.0, rate=0.3).of(x, y), [[0.0, 0.0], [1.0, 0.5]])
