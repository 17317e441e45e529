"""The leg on belts: inverse of its forward kinematics, postures of a stride."""

from __future__ import annotations

import json
from math import acos, asin, cos, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.belt_leg import (
    ankle_position,
    segment_angles,
    stride_angles,
    within_reach,
)

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "biped.json").read_text())
SEGMENT = 0.3


def bent(n: int) -> np.ndarray:
    """Thigh and shank of legs with the knee forward. Shape (n, 2)."""
    random = np.random.default_rng(4)
    thigh = random.uniform(-1.0, 1.2, n)
    return np.stack([thigh, thigh - random.uniform(0.01, 2.0, n)], axis=-1)


def test_inverse_kinematics_inverts_the_forward_kinematics() -> None:
    angles = bent(10_000)
    ankle = ankle_position(angles, SEGMENT)
    np.testing.assert_allclose(segment_angles(ankle, SEGMENT), angles, atol=1e-9)
    assert within_reach(ankle, SEGMENT).all()


def test_a_straight_leg_is_found_although_it_is_singular() -> None:
    angles = np.repeat(np.linspace(-0.8, 0.8, 41)[:, None], 2, axis=1)
    ankle = ankle_position(angles, SEGMENT)
    assert within_reach(ankle, SEGMENT).all()
    # The root of a rounding error of the distance is what the angles lose there.
    np.testing.assert_allclose(segment_angles(ankle, SEGMENT), angles, atol=1e-7)


def test_a_longer_way_is_out_of_reach() -> None:
    assert not within_reach(np.array([0.0, -2.001 * SEGMENT]), SEGMENT)


def test_moving_the_thigh_alone_leaves_the_shank_upright() -> None:
    before, after = ankle_position(np.array([[0.0, 0.0], [0.4, 0.0]]), SEGMENT)
    knee = SEGMENT * np.array([np.sin(0.4), -np.cos(0.4)])
    np.testing.assert_allclose(after - knee, before / 2.0, atol=1e-15)


@pytest.mark.parametrize("case", GOLDEN["strides"])
def test_the_postures_agree_with_the_reference_vectors(case: dict) -> None:
    lengths = case["S"], case["h"], case["l"]
    exact, printed = stride_angles(*lengths), stride_angles(*lengths, lift="printed")
    found = [exact.touchdown, exact.lift, printed.lift, exact.ending_thigh, exact.ending_shank]
    names = ("theta", "psi_exact", "psi_printed", "end_phi1", "end_phi2")
    np.testing.assert_allclose(found, [case[name] for name in names], atol=1e-8)


@given(st.floats(0.02, 0.3), st.floats(0.01, 0.1))
def test_the_exact_lift_is_the_height_asked_for_and_the_printed_one_a_little_less(
    step_length: float, step_height: float
) -> None:
    theta = asin(step_length / (2.0 * SEGMENT))
    hips = 2.0 * SEGMENT * cos(theta / 2.0)
    lifts = [
        hips - 2.0 * SEGMENT * cos(stride_angles(step_length, step_height, SEGMENT, lift).lift)
        for lift in ("exact", "printed")
    ]
    assert lifts[0] == pytest.approx(step_height, abs=1e-12)
    assert 0.97 * step_height - 0.01 * step_length < lifts[1] < step_height


def test_the_lift_of_a_step_on_the_spot_is_hand_made() -> None:
    found = stride_angles(0.0, 0.3, SEGMENT)
    assert found.lift == pytest.approx(acos(0.5)) == pytest.approx(pi / 3.0)
    assert (found.touchdown, found.ending_thigh + found.ending_shank) == (0.0, 0.0)
