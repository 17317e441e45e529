"""The straight-legged strides: what every walk of them keeps, and what the printed ones break."""

from __future__ import annotations

import json
from dataclasses import replace
from math import asin, cos
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.errors import WrongValue
from gaitlab.gaits.biped import Gait
from gaitlab.gaits.biped_bent_knee import Gait as BentKnee
from gaitlab.kinematics.belt_leg import ankle_position, stride_angles
from gaitlab.model.gait import Gait as GaitProtocol
from gaitlab.parameters import parameters

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "biped.json").read_text())
DEFAULT: GaitProtocol = Gait()
ONE = Gait(full_strides=1, stand_time=0.0)
PRINTED = replace(ONE, ending="printed")
WINDOW = 1e-13  # s, either side of an instant
SETS = [(0.20, 0.30, 0.05), (0.15, 0.25, 0.03), (0.30, 0.40, 0.05), (0.0, 0.30, 0.02)]


def made(step_length: float, segment: float, step_height: float, **changes: object) -> Gait:
    """A walk of one full stride, with the printed ending unless told otherwise."""
    lengths = {"step_length": step_length, "segment": segment, "step_height": step_height}
    return replace(PRINTED, **(lengths | changes))


def world(gait: Gait, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hips (n, 2) and ankles (n, 2, 2), forward and up, from supporting ankles that stay put."""
    ankle = ankle_position(gait.joint_motion(t).position, gait.segment)
    swing = gait.feet(t).swing
    hips, spot = np.empty((len(t), 2)), np.zeros((2, 2))
    support = 0
    for k in range(len(t)):
        landed = int(np.argmax(~swing[k])) if swing[k].any() else support
        if landed != support:
            spot[landed] = spot[support] - ankle[k, support] + ankle[k, landed]
            support = landed
        hips[k] = spot[support] - ankle[k, support]
    return hips, hips[:, None] + ankle


@pytest.mark.parametrize("name", ["walk_n_full_1", "walk_n_full_2"])
def test_the_walk_agrees_with_the_reference_vectors(name: str) -> None:
    case = GOLDEN[name]
    gait = replace(PRINTED, full_strides=case["params"]["n_full"])
    motion = gait.joint_motion(np.array(case["t"]))
    for letter, quantity in zip("pva", motion, strict=True):
        for leg in (0, 1):
            for part in (0, 1):
                wanted = case[f"{letter}{leg + 1}{part + 1}"]
                np.testing.assert_allclose(quantity[:, leg, part], wanted, atol=1e-8)


@pytest.mark.parametrize(("step_length", "segment", "step_height"), SETS)
@pytest.mark.parametrize("ending", ["corrected", "late", "printed"])
def test_every_joint_is_continuous_up_to_the_acceleration(
    step_length: float, segment: float, step_height: float, ending: str
) -> None:
    gait = made(step_length, segment, step_height, ending=ending, full_strides=2)
    vias = {via.time for leg in gait.vias for via in leg}
    between = np.linspace(0.0, gait.duration, 2001)  # blends begin and end at some of these too
    t = np.sort(np.concatenate([between, np.array(sorted(vias)) * gait.half_stride]))
    before, after = gait.joint_motion(t - WINDOW), gait.joint_motion(t + WINDOW)
    for name, bound in (("position", 1e-8), ("velocity", 1e-9), ("acceleration", 1e-5)):
        assert np.abs(getattr(after, name) - getattr(before, name)).max() <= bound


@given(st.integers(0, 4), st.sampled_from(SETS))
@settings(max_examples=20)
def test_hips_and_feet_advance_alike_and_end_upright(full_strides: int, lengths: tuple) -> None:
    gait = made(*lengths, full_strides=full_strides)
    t = np.linspace(0.0, gait.duration, 800 * (full_strides + 1) + 1)
    hips, ankles = world(gait, t)
    advance = gait.step_length * (full_strides + 1)
    np.testing.assert_allclose(hips[-1], [advance, 2.0 * gait.segment], atol=1e-9)
    np.testing.assert_allclose(ankles[-1], [[advance, 0.0]] * 2, atol=1e-9)
    np.testing.assert_allclose(gait.joint_motion(t[-1:]).position, 0.0, atol=1e-12)


def test_every_via_point_is_a_full_stop() -> None:
    for leg in PRINTED.vias:
        at = np.array([via.time for via in leg]) * PRINTED.half_stride
        index = PRINTED.vias.index(leg)
        motion = PRINTED.joint_motion(at)
        np.testing.assert_allclose(motion.velocity[:, index], 0.0, atol=1e-12)
        np.testing.assert_allclose(motion.acceleration[:, index], 0.0, atol=1e-9)


def test_the_hips_travel_on_a_straight_leg_and_rise_on_the_spot() -> None:
    t = np.linspace(1.0, 3.0, 401)
    motion = PRINTED.joint_motion(t).position[:, 1]  # the right leg supports the full stride
    travelling = t >= 2.0
    np.testing.assert_allclose(motion[travelling, 0], motion[travelling, 1], atol=1e-12)
    rising = ankle_position(motion[~travelling], PRINTED.segment)
    np.testing.assert_allclose(rising[:, 0], 0.0, atol=1e-12)


@pytest.mark.parametrize(("step_length", "segment", "step_height"), SETS[:3])
def test_starting_and_full_strides_stay_above_the_floor(
    step_length: float, segment: float, step_height: float
) -> None:
    gait = made(step_length, segment, step_height)
    t = np.linspace(0.0, gait.duration - gait.half_stride, 3001)
    assert world(gait, t)[1][..., 1].min() > -1e-9


@pytest.mark.parametrize("case", GOLDEN["ending_stride_clearance"])
def test_the_printed_ending_stride_digs_into_the_floor(case: dict) -> None:
    gait = made(case["S"], case["l"], case["h"], speed_ratio=case["k_swing"])
    if (case["k_support"], case["k_swing"]) == (1.2, 2.0):
        gait = replace(gait, ending="corrected")
    elif case["lift_fraction"] == 0.8:
        gait = replace(gait, ending="late")
    t = np.linspace(3.0, 4.0, 2001)
    lowest = world(gait, np.concatenate([np.linspace(0.0, 3.0, 3001), t]))[1][-2001:, :, 1].min()
    assert lowest == pytest.approx(case["min_foot_z"], abs=case["tolerance"])


@pytest.mark.parametrize("ending", ["corrected", "late"])
def test_a_corrected_ending_stride_clears_the_floor(ending: str) -> None:
    gait = replace(ONE, ending=ending)
    lowest = world(gait, np.linspace(0.0, 4.0, 4001))[1][..., 1].min()
    assert lowest > -1e-5  # m; the sole leaves and meets the floor at a grazing angle


def test_the_peaks_are_those_of_the_reference() -> None:
    found, wanted = (
        PRINTED.joint_motion(np.linspace(0.0, 4.0, 4001)),
        GOLDEN["walk_extrema_n_full_1"],
    )
    for leg in (0, 1):
        for part in (0, 1):
            name = f"{leg + 1}{part + 1}"
            speed = np.abs(found.velocity[:, leg, part]).max()
            assert speed == pytest.approx(wanted["peak_abs_velocity"][name], abs=1e-5)
            strongest = np.abs(found.acceleration[:, leg, part]).max()
            assert strongest == pytest.approx(wanted["peak_abs_acceleration"][name], abs=1e-3)


def test_the_printed_end_of_the_walk_leaves_a_foot_in_the_air() -> None:
    theta = asin(0.2 / 0.6)
    printed = ankle_position(np.array([theta, -theta]), 0.3)[1] + 0.6
    assert printed == pytest.approx(0.6 * (1.0 - cos(theta)))
    assert printed == pytest.approx(GOLDEN["strides"][0]["foot_float_if_printed_end"], abs=1e-8)


def test_the_printed_sign_of_a_full_strides_lift_puts_the_foot_far_ahead() -> None:
    psi = stride_angles(0.2, 0.05, 0.3, lift="printed").lift
    assert ankle_position(np.array([psi, psi]), 0.3)[0] == pytest.approx(0.26, abs=0.005)
    assert ankle_position(np.array([psi, -psi]), 0.3)[0] == pytest.approx(0.0, abs=1e-15)


def test_swing_phase_and_step_index_tell_the_strides() -> None:
    gait = replace(ONE, stand_time=1.0, full_strides=3)
    t = np.array([0.5, 1.5, 2.5, 3.5, 4.5, 6.5, 8.5, 9.5])
    feet = gait.feet(t)
    still, left, right = [False, False], [True, False], [False, True]
    wanted = [still, right, left, left, right, left, right, still]
    np.testing.assert_array_equal(feet.swing, wanted)
    np.testing.assert_array_equal(feet.step_index, [-1, -1, 0, 0, 1, 2, 3, 0])
    np.testing.assert_allclose(feet.phase[[2, 4]], [0.125, 0.625], atol=1e-9)
    assert np.isnan(feet.phase[:2]).all()


def test_the_mean_speed_is_two_steps_a_period() -> None:
    gait = replace(ONE, full_strides=6)
    t = np.linspace(0.0, gait.startup_time + 2.0 * gait.gait_period, 9001)
    hips = world(gait, t)[0][:, 0]
    walked = hips[-1] - hips[np.searchsorted(t, gait.startup_time)]
    assert walked == pytest.approx(4.0 * gait.step_length, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"step_length": 0.6}, "reach less than 0.6 m: shorten step_length"),
        ({"step_length": 0.1, "step_height": 0.6}, "0.5979 m over the ankle.*lower step_height"),
    ],
)
def test_a_stride_too_large_for_the_leg_is_refused_with_what_is_allowed(
    change: dict, words: str
) -> None:
    with pytest.raises(WrongValue, match=words):
        Gait(**change)


def test_every_parameter_says_where_its_default_comes_from() -> None:
    for cls in (Gait, BentKnee):
        for parameter in parameters(cls):
            assert parameter.source.startswith(("assumption", "published")), parameter.name


def test_bent_knees_keep_the_hips_level_and_the_supporting_foot_in_place() -> None:
    gait = BentKnee(stand_time=0.0)
    t = gait.gait_period + np.linspace(0.0, gait.gait_period / 2.0, 1001)[:-1]
    feet = gait.feet(t)
    assert feet.swing[:, 1].all()
    assert not feet.swing[:, 0].any()
    hips = -feet.position[:, 0, 0]  # seen from the supporting foot
    np.testing.assert_allclose(np.diff(hips, 2), 0.0, atol=1e-12)
    assert hips[-1] - hips[0] == pytest.approx(gait.step_length, rel=0.01)
    np.testing.assert_allclose(feet.position[:, 0, 2], -gait.hip_height, atol=1e-12)
    lift = feet.position[:, 1, 2] + gait.hip_height
    assert lift.max() == pytest.approx(gait.step_height, abs=1e-6)
    assert lift.min() > -1e-12
    assert np.ptp(feet.position[:, 1, 0] + hips) == pytest.approx(2.0 * gait.step_length, rel=1e-3)


def test_bent_knee_feet_and_their_speed_are_continuous_over_the_walk() -> None:
    gait = BentKnee()
    t = np.linspace(0.0, 14.0, 14001)
    position = gait.feet(t).position
    speed = np.diff(position, axis=0) / (t[1] - t[0])
    assert np.abs(np.diff(position, axis=0)).max() < 1e-3
    assert np.abs(np.diff(speed, axis=0)).max() < 1e-3


def test_both_gaits_have_the_same_speed_for_the_same_words() -> None:
    shared = {"step_length": 0.15, "gait_period": 3.0}
    straight, bent = Gait(**shared), BentKnee(**shared)
    assert straight.step_length / straight.gait_period == bent.step_length / bent.gait_period
