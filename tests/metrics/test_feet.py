"""Feet and ground: clearance, landings, plough force, ZMP margin."""

from __future__ import annotations

from math import isnan

import numpy as np
import pytest

from gaitlab.metrics import measure
from tests.synthetic import DUTY, fall, walk

FEET = ("left", "right")


def both(column: str, course) -> dict[str, object]:
    return {f"{side}_foot_{column}": course for side in FEET}


def level(height: float) -> dict[str, object]:
    """Soles that pass at one height and stand 10 mm deep."""
    courses = {}
    for foot, side in enumerate(FEET):

        def sink(walked, foot=foot):
            phase = (walked / 0.8 + 0.5 * foot) % 1.0
            return np.where((phase < DUTY) | (walked < 0.0), 0.01, -height)

        courses[f"{side}_foot_sink"] = sink
    return courses


@pytest.mark.parametrize("height", [0.02, 0.0, -0.008])
def test_clearance_is_the_height_of_the_sole_over_the_pile(height):
    assert measure(walk(**level(height)))["foot_clearance"] == pytest.approx(height, abs=1e-9)


def test_clearance_is_the_smallest_in_mid_swing():
    # A swing that rises as a half sine of 20 mm stands at its smallest at the ends of its middle.
    expected = 0.02 * np.sin(np.pi / 3.0)
    assert measure(walk())["foot_clearance"] == pytest.approx(expected, abs=5e-4)


def test_clearance_is_the_median_over_swings():
    heights = np.array([0.01, 0.09, 0.02, 0.08, 0.03, 0.0])

    def sink(walked):
        return -heights[np.clip(walked // 0.8, 0, 5).astype(int)]

    # The left foot completes five swings, the right one never leaves the ground.
    log = walk(left_foot_sink=sink, right_foot_normal_force=10.0)
    assert measure(log)["foot_clearance"] == pytest.approx(0.03)


def test_a_robot_that_never_steps_has_no_clearance_and_no_landing():
    found = measure(walk(**both("normal_force", 10.0)))
    assert isnan(found["foot_clearance"])
    assert isnan(found["toe_first_share"])


@pytest.mark.parametrize(
    ("front", "rear", "share"), [(3.0, 1.0, 1.0), (1.0, 3.0, 0.0), (1.0, 1.0, 0.0), (1.2, 1.0, 0.0)]
)
def test_a_landing_on_loaded_toes_is_toe_first(front, rear, share):
    loads = {}
    for side in ("left", "right"):
        loads |= both(f"fsr_front_{side}", front) | both(f"fsr_rear_{side}", rear)
    assert measure(walk(**loads))["toe_first_share"] == share


@pytest.mark.parametrize(("pitch", "share"), [(0.1, 1.0), (-0.1, 0.0), (0.005, 0.0)])
def test_a_landing_on_a_sole_that_points_down_is_toe_first(pitch, share):
    attitude = both("qy", np.sin(pitch / 2.0)) | both("qw", np.cos(pitch / 2.0))
    assert measure(walk(**attitude))["toe_first_share"] == share


def test_toes_of_one_foot_are_half_of_the_landings():
    found = measure(walk(right_foot_fsr_front_left=30.0, cycles=10.1))
    assert found["toe_first_share"] == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_plough_force_is_the_peak_of_either_foot_and_either_way(sign):
    peaks = {
        "left_foot_plough_force": lambda w: 3.0 * sign * (w > 1.0),
        "right_foot_plough_force": 2.0,
    }
    assert measure(walk(**peaks))["peak_plough_force"] == 3.0


def test_margin_of_a_ramp():
    def ramp(walked):
        return 0.04 * walked / 4.8 - 0.01

    found = measure(walk(zmp_margin=ramp))
    row = 0.04 / 960  # m, the ramp's rise in a row
    assert found["zmp_margin_min"] == pytest.approx(-0.01, abs=2.0 * row)
    assert found["zmp_margin_p5"] == pytest.approx(-0.008, abs=2.0 * row)
    assert found["zmp_inside_share"] == pytest.approx(
        0.725, abs=2.0 / 960
    )  # from 1 mm to 30 mm of 40


def test_ticks_in_flight_have_no_margin_and_do_not_count():
    hopping = walk(zmp_margin=lambda w: np.where(w > 2.4, np.nan, 0.01))
    found = measure(hopping)
    assert found["zmp_margin_min"] == pytest.approx(0.01)
    assert found["zmp_inside_share"] == 1.0


@pytest.mark.parametrize("margin", [0.0, -0.002, 0.0005])
def test_a_robot_on_an_edge_does_not_stand_inside(margin):
    assert measure(walk(zmp_margin=margin))["zmp_inside_share"] == 0.0


def test_feet_that_meet_as_the_robot_lies_are_no_gap_of_its_walk():
    first = fall(at=3.0)
    assert first.fall_index is not None
    down = float(first["time"][first.fall_index]) - first.header.startup_time

    def lying(walked):
        return np.where(walked > down - 0.001, -0.01, 0.02)

    assert measure(fall(at=3.0, feet_gap=lying))["feet_gap"] == pytest.approx(0.02)
    assert measure(walk(feet_gap=lying))["feet_gap"] == pytest.approx(-0.01)
