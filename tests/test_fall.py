"""The fall rule: its three causes, its delays, and tick by tick as over whole arrays."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.log.columns import columns
from gaitlab.log.fall import CAUSES, FallDetector
from tests.synthetic import fall_causes

DT = 0.002
HEIGHT = 0.3
UPRIGHT, TILTED = cos(radians(44.9)), cos(radians(45.1))
HIGH, LOW = 0.601 * HEIGHT, 0.599 * HEIGHT


def streamed(upright, body_contact, trunk_height, dt=DT) -> list[int]:
    detector = FallDetector(dt, HEIGHT)
    ticks = zip(upright, body_contact, trunk_height, strict=True)
    return [detector.update(*tick) for tick in ticks]


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


@given(segments)
def test_a_fall_is_never_taken_back(parts):
    ticks = [part[:3] for part in parts for _ in range(part[3])]
    found = causes(*ticks)
    first = next((i for i, cause in enumerate(found) if cause), len(found))
    assert set(found[first:]) <= {found[-1]}


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


def test_causes_are_named_in_the_order_of_the_log_column():
    (doc,) = (column.doc for column in columns(()) if column.name == "fall_cause")
    words = [part.strip().split(" ", 1) for part in doc.split(",")]
    assert [int(code) for code, _ in words] == list(range(len(CAUSES)))
    assert [word.replace(" ", "_") for _, word in words[1:]] == list(CAUSES[1:])
