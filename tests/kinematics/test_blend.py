"""Linear segments with quartic blends: continuity, mirror symmetry, limits on the speed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.errors import WrongValue
from gaitlab.kinematics.blend import blended_path, blended_segment, require_speed

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "biped.json").read_text())
WINDOW = 1e-13  # s, either side of an instant; a smooth motion stays below the bounds in it
RATIOS = st.floats(1.02, 2.0)


def segment(start: float, end: float, duration: float, ratio: float, t: np.ndarray):
    return blended_segment(t, start, end, duration, ratio * (end - start) / duration)


@pytest.mark.parametrize("case", GOLDEN["blend"])
def test_segments_agree_with_the_reference_vectors(case: dict) -> None:
    t = np.array(case["t"])
    motion = blended_segment(t, case["phi_i"], case["phi_f"], case["T"], case["omega"])
    for name, quantity in zip(("phi", "dphi", "ddphi"), motion, strict=True):
        np.testing.assert_allclose(quantity, case[name], atol=1e-8)


@given(st.floats(-1.5, 1.5), st.floats(0.05, 1.5), st.floats(0.2, 5.0), RATIOS)
def test_a_segment_starts_and_ends_at_rest(start, change, duration, ratio) -> None:
    t = np.array([0.0, duration])
    motion = segment(start, start + change, duration, ratio, t)
    np.testing.assert_allclose(motion.position, [start, start + change], atol=1e-12)
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.acceleration, 0.0, atol=1e-9)


@given(st.floats(0.25, 5.0), st.floats(1.05, 2.0), st.floats(-1.2, 1.2))
def test_position_velocity_and_acceleration_are_continuous(duration, ratio, change) -> None:
    blend = duration * (1.0 - 1.0 / ratio)
    joints = np.array([0.0, blend, duration / 2.0, duration - blend, duration])
    times, values = np.array([0.0, duration, 2.0 * duration]), np.array([0.1, 0.1 + change, 0.0])
    ratios = np.array([ratio, ratio])
    before = blended_path(joints - WINDOW, times, values, ratios)
    after = blended_path(joints + WINDOW, times, values, ratios)
    for name, bound in (("position", 1e-8), ("velocity", 1e-9), ("acceleration", 1e-5)):
        assert np.abs(getattr(after, name) - getattr(before, name)).max() <= bound


@given(RATIOS, st.floats(0.2, 5.0))
def test_velocity_and_acceleration_are_the_derivatives(ratio, duration) -> None:
    t = np.linspace(0.0, duration, 4001)
    motion = segment(-0.3, 0.5, duration, ratio, t)
    step = t[1] - t[0]
    for lower, upper in ((motion[0], motion[1]), (motion[1], motion[2])):
        numeric = np.gradient(lower, step)[2:-2]
        np.testing.assert_allclose(numeric, upper[2:-2], atol=0.02 * np.abs(upper).max())


@given(RATIOS, st.floats(0.2, 5.0))
def test_a_segment_run_backwards_is_the_segment_mirrored(ratio, duration) -> None:
    t = np.linspace(0.0, duration, 101)
    there, back = segment(0.2, 0.9, duration, ratio, t), segment(0.9, 0.2, duration, ratio, t)
    np.testing.assert_allclose(there.position, back.position[::-1], atol=1e-12)
    np.testing.assert_allclose(there.velocity, -back.velocity[::-1], atol=1e-12)


@given(RATIOS)
def test_the_peaks_are_those_of_the_closed_forms(ratio) -> None:
    t = np.linspace(0.0, 1.0, 20001)
    motion = segment(0.0, 1.0, 1.0, ratio, t)
    assert motion.velocity.max() == pytest.approx(ratio, rel=1e-9)
    peak = 1.5 * ratio**2 / (ratio - 1.0)
    assert np.abs(motion.acceleration).max() == pytest.approx(peak, rel=1e-3)


def test_before_and_after_the_path_the_ends_are_held() -> None:
    motion = blended_segment(np.array([-1.0, 3.0]), 0.2, 0.7, 1.0, 0.8)
    np.testing.assert_allclose(motion.position, [0.2, 0.7], atol=1e-15)
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-15)


def test_a_segment_that_goes_nowhere_stays() -> None:
    motion = blended_segment(np.linspace(0.0, 1.0, 11), 0.4, 0.4, 1.0, 0.0)
    np.testing.assert_array_equal(motion.position, 0.4)
    assert not motion.velocity.any()


@pytest.mark.parametrize("case", GOLDEN["omega_feasible"])
def test_a_speed_is_refused_outside_what_the_blends_allow(case: dict) -> None:
    change, duration = case["dphi"], case["T"]
    lowest, highest = case["omega_abs_open_lower"], case["omega_abs_closed_upper"]
    sign = np.sign(change)
    assert require_speed(change, duration, sign * highest) == pytest.approx(2.0)
    for speed in (lowest, 0.5 * lowest, 1.001 * highest, -1.5 * lowest, 0.0, float("nan")):
        with pytest.raises(WrongValue, match=f"{lowest:.6g} and not over {highest:.6g} rad/s"):
            require_speed(change, duration, sign * speed)


def test_a_ratio_without_blends_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(ValueError, match="ratio"):
        blended_path(np.zeros(1), np.array([0.0, 1.0]), np.zeros(2), np.array([1.0]))


def test_the_printed_first_blend_ends_at_five_times_the_speed() -> None:
    """With the printed plus sign the blend overshoots: 3 w + 2 w where w is wanted."""
    speed, blend, t = 0.8, 0.25, np.array([0.25])
    printed = 3.0 * speed * t**2 / blend**2 + 2.0 * speed * t**3 / blend**3
    ours = blended_segment(t, 0.0, 0.6, 1.0, 0.8).velocity
    assert printed[0] == pytest.approx(5.0 * ours[0])
