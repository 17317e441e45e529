"""Amplitude and RMS of the trunk's rocking."""

from __future__ import annotations

from math import isnan, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.metrics import measure
from gaitlab.metrics.balance import pitch_amplitude, pitch_rms
from tests.synthetic import HEADER, fall, sine, walk

SIX = radians(6.0)
# rad, the peak of a sine of 160 rows a period lies up to half a row from the next row
PEAK = SIX * (1.0 - np.cos(np.pi / 160.0)) + 1e-7


@pytest.mark.parametrize("offset", [0.0, 0.2, -0.3])
def test_a_sine_of_six_degrees_has_an_amplitude_of_six_degrees(offset):
    found = measure(walk(pitch=sine(SIX, offset=offset), roll=sine(SIX / 2.0, offset=offset)))
    assert found["pitch_amplitude"] == pytest.approx(SIX, abs=PEAK)
    assert found["roll_amplitude"] == pytest.approx(SIX / 2.0, abs=PEAK)
    assert found["pitch_cycles"] == 4
    assert found["pitch_settled"] is True


@given(st.floats(0.01, 0.5), st.floats(-0.2, 0.2))
def test_amplitude_is_proportional_and_blind_to_lean(scale, lean):
    one, other = walk(pitch=sine(0.1)), walk(pitch=sine(0.1 * scale, offset=lean))
    assert pitch_amplitude(other) == pytest.approx(scale * pitch_amplitude(one), abs=1e-6)


def test_the_first_two_cycles_do_not_count():
    def settling(walked):
        return np.where(walked < 2.0 * HEADER.gait_period, 0.5, SIX) * np.sin(
            2 * np.pi * walked / 0.8
        )

    assert pitch_amplitude(walk(pitch=settling)) == pytest.approx(SIX, abs=PEAK)


def test_the_fall_itself_is_not_measured():
    def toppling(walked):
        return sine(SIX)(walked) + 3.0 * np.maximum(walked - 4.0, 0.0)

    found = measure(walk(pitch=toppling))
    assert found["fell"] is True
    assert found["pitch_amplitude"] == pytest.approx(SIX, abs=PEAK)
    assert found["pitch_rms"] == pytest.approx(SIX / np.sqrt(2.0), rel=0.2)
    assert found["pitch_settled"] is True


def test_too_few_cycles_are_used_and_flagged():
    found = measure(walk(pitch=sine(SIX), cycles=3.0))
    assert found["pitch_amplitude"] == pytest.approx(SIX, abs=PEAK)
    assert (found["pitch_cycles"], found["pitch_settled"]) == (3, False)


def test_an_early_fall_leaves_no_amplitude():
    found = measure(fall(at=0.2))
    assert isnan(found["pitch_amplitude"])
    assert isnan(found["roll_amplitude"])
    assert isnan(found["pitch_rms"])
    assert (found["pitch_cycles"], found["pitch_settled"]) == (0, False)


@pytest.mark.parametrize("trend", [0.0, 0.03])
def test_rms_of_a_sine_is_its_amplitude_over_root_two_whatever_its_trend(trend):
    log = walk(pitch=lambda w: 0.1 + trend * w + sine(SIX)(w), cycles=12.0)
    # A line through whole periods of a sine takes a little of it along, less the more there are.
    assert pitch_rms(log) == pytest.approx(SIX / np.sqrt(2.0), rel=0.01)


@given(st.floats(-0.5, 0.5), st.floats(-0.03, 0.03))
def test_a_steady_lean_has_no_rms(lean, trend):
    log = walk(pitch=lambda w: lean + trend * w)
    assert pitch_rms(log) == pytest.approx(0.0, abs=1e-7)
