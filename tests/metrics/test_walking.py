"""Distance, drift, speed and footsteps of a robot that glides."""

from __future__ import annotations

from math import isnan

import numpy as np
import pytest

from gaitlab.metrics import measure
from tests.synthetic import HEADER, fall, header, walk

ROW = HEADER.dt / HEADER.gait_period  # gait periods
FLOAT32 = 1e-6  # m, rounding of positions of a few metres


@pytest.mark.parametrize("step_length", [0.04, -0.04])
@pytest.mark.parametrize("speed", [0.03, 0.1])
def test_a_glider_covers_speed_times_time(step_length, speed):
    direction = np.sign(step_length)
    found = measure(walk(header(step_length=step_length), cycles=5.0, speed=direction * speed))
    assert found["walked_time"] == pytest.approx(4.0)
    assert found["distance"] == pytest.approx(4.0 * speed, abs=FLOAT32)
    assert found["walking_speed"] == pytest.approx(speed, abs=FLOAT32)
    assert found["slip_ratio"] == pytest.approx(speed / 0.1, abs=1e-5)


def test_distance_ends_with_the_fall():
    found = measure(fall(at=2.0, speed=0.05))
    assert found["distance"] == pytest.approx(0.05 * found["walked_time"], abs=FLOAT32)
    assert found["walked_time"] == pytest.approx(found["time_to_fall"], abs=1.5 * HEADER.dt)


def test_the_wrong_way_is_negative():
    found = measure(walk(speed=-0.1))
    assert found["distance"] < 0.0
    assert found["slip_ratio"] == pytest.approx(-1.0, abs=1e-5)
    assert found["distance_before_fall"] == 0.0
    assert isnan(found["cost_of_transport"])


def test_distance_before_fall_keeps_the_farthest_point():
    found = measure(walk(trunk_x=lambda w: 0.3 * np.sin(np.clip(w, 0.0, None))))
    assert found["distance_before_fall"] == pytest.approx(0.3, abs=1e-5)
    assert found["distance"] == pytest.approx(0.3 * np.sin(4.8), abs=1e-5)


def test_distance_before_fall_is_at_most_the_run_of_six_metres():
    found = measure(walk(speed=2.0))
    assert found["distance"] == pytest.approx(9.6, abs=1e-5)
    assert found["distance_before_fall"] == 6.0


def test_a_fall_in_the_start_up_covers_nothing():
    found = measure(fall(at=-0.9))
    assert found["distance_before_fall"] == 0.0
    assert isnan(found["distance"])


def test_slip_is_not_defined_without_a_command():
    assert isnan(measure(walk(header(step_length=0.0), speed=0.1))["slip_ratio"])


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_drift_to_the_left_is_positive(heading):
    left = np.array([-np.sin(heading), np.cos(heading)])
    drift = {
        f"trunk_{a}": lambda w, s=s: 0.02 * s * np.maximum(w, 0.0)
        for a, s in zip("xy", left, strict=True)
    }
    found = measure(walk(heading=heading, **drift))
    assert found["lateral_drift"] == pytest.approx(0.02 * 4.8, abs=FLOAT32)
    assert found["distance"] == pytest.approx(0.0, abs=FLOAT32)


def test_drift_is_measured_across_the_heading_at_the_end_of_the_start_up():
    found = measure(walk(speed=0.0, trunk_y=lambda w: 5.0 + 0.0 * w))
    assert found["lateral_drift"] == pytest.approx(0.0, abs=FLOAT32)


@pytest.mark.parametrize("rate", [0.1, -0.1, 2.0])
def test_heading_drift_counts_whole_turns(rate):
    def yaw(walked):
        return (3.0 + rate * walked + np.pi) % (2.0 * np.pi) - np.pi

    found = measure(walk(yaw=yaw, speed=0.0))
    assert found["heading_drift"] == pytest.approx(rate * 4.8, abs=2.0 * abs(rate) * HEADER.dt)
    assert found["heading_error"] == found["heading_drift"], "no turn is commanded"


@pytest.mark.parametrize(
    ("cycles", "footsteps"), [(1.0, 2), (5.0, 10), (4.8, 9), (0.4, 0), (5.0 - ROW, 10)]
)
def test_footsteps_are_two_a_cycle(cycles, footsteps):
    assert measure(walk(cycles=cycles))["footsteps"] == footsteps
