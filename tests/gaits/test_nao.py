import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.gaits.nao import Gait, lateral_profile
from gaitlab.kinematics.slanted_leg import geometric_angles
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import get_path, parameters
from gaitlab.robots.nao import Robot

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "nao.json").read_text())
TOLERANCE = 1e-8  # m and rad, digits of the reference vectors
PAPER_LEG = 0.2  # m, thigh and tibia of the paper
PROFILES = ("sinsin", "sin", "foot", "printed")
VARIANTS = [
    Gait(lateral_profile=profile, step_length=length)
    for profile in PROFILES
    for length in (-0.03, 0.0, 0.05)
]
every_gait = pytest.mark.parametrize("gait", VARIANTS)


def paper_gait(case: dict[str, Any], **changes: Any) -> Gait:
    """A gait with the paper's symbols; the soles stand in for the ankles."""
    return Gait(
        step_length=case["s"] / 2.0,
        step_height=case["H"],
        lateral_sway=case["F"],
        hip_height=PAPER_LEG - case["h"],
        gait_period=2.0 * case["T"],
        **changes,
    )


def whole_walk(gait: Gait, dt: float = 0.002) -> np.ndarray:
    return np.arange(round((gait.startup_time + 2.0 * gait.gait_period) / dt)) * dt


def ankles(feet: FeetPoses, at: int) -> tuple[np.ndarray, np.ndarray]:
    return feet.position[at, 0], feet.position[at, 1]


@pytest.mark.parametrize("case", GOLDEN["gait_local"])
def test_a_step_equals_the_reference(case: dict[str, Any]) -> None:
    gait = paper_gait(case, lateral_profile=case["profile"])
    number = 0 if case["stance"] == "L" else 1
    t = gait.startup_time + number * case["T"] + case["tau"]
    standing, swinging = ankles(gait.feet(np.array([t])), 0)
    if case["stance"] == "R":
        standing, swinging = swinging, standing
    side = 1.0 if case["stance"] == "L" else -1.0
    np.testing.assert_allclose(swinging - standing, case["swing"], atol=TOLERANCE)
    # The reference counts the hips across from the line midway between the feet.
    hips = -standing + [0.0, side * gait.step_width / 2.0, 0.0]
    np.testing.assert_allclose(hips, case["hip"], atol=TOLERANCE)


@pytest.mark.parametrize("case", GOLDEN["gait_global"])
def test_walking_and_its_joints_equal_the_reference(case: dict[str, Any]) -> None:
    gait = Gait(gait_period=2.0, hip_height=PAPER_LEG - 0.018)
    feet = gait.feet(np.array([gait.startup_time + case["t"]]))
    for foot, (name, hip) in enumerate((("left", 0.05), ("right", -0.05))):
        ankle = feet.position[0, foot] - [0.0, hip, 0.0]
        np.testing.assert_allclose(ankle, case[f"r_{name}"], atol=TOLERANCE)
        angles, joints = geometric_angles(ankle, 0.1, 0.1), case[f"q_{name}"]
        found = (angles.hip_roll, angles.hip_pitch, angles.knee_pitch, angles.ankle_pitch)
        names = ("HipRoll", "HipPitch", "KneePitch", "AnklePitch")
        np.testing.assert_allclose(found, [joints[k] for k in names], atol=2e-8)


@pytest.mark.parametrize("profile", PROFILES)
def test_lateral_profile_equals_the_reference(profile: str) -> None:
    reference = GOLDEN["lateral_profile"][profile]
    at = np.array([float(x) for x in reference["values"]])
    found = lateral_profile(profile, at)
    np.testing.assert_allclose(found, list(reference["values"].values()), atol=TOLERANCE)
    peak = lateral_profile(profile, np.linspace(0.0, 1.0, 100_001))
    assert peak.max() == pytest.approx(reference["max"], abs=1e-8)
    assert np.argmax(peak) / 100_000 == pytest.approx(reference["at"], abs=1e-4)


@pytest.mark.parametrize("profile", PROFILES[:3])
def test_the_corrected_profiles_are_even_about_the_middle_and_reach_one(profile: str) -> None:
    x = np.linspace(0.0, 1.0, 201)
    f = lateral_profile(profile, x)
    np.testing.assert_allclose(f, f[::-1], atol=1e-12)
    assert f[100] == pytest.approx(1.0)
    assert f[0] == pytest.approx(0.0, abs=1e-12)


@every_gait
def test_the_swing_foot_is_never_below_ground_and_the_standing_foot_always_on_it(
    gait: Gait,
) -> None:
    feet = gait.feet(whole_walk(gait))
    height = feet.position[..., 2] + gait.hip_height
    assert height.min() > -1e-12
    assert height.max() == pytest.approx(gait.step_height, abs=1e-6)
    np.testing.assert_allclose(height[~feet.swing], 0.0, atol=1e-12)
    assert not np.any(feet.swing.all(axis=1))


@every_gait
def test_right_steps_mirror_left_steps(gait: Gait) -> None:
    t = gait.startup_time + np.linspace(0.0, 0.499, 100) * gait.gait_period
    first, second = gait.feet(t), gait.feet(t + gait.gait_period / 2.0)
    mirror = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(second.position, mirror * first.position[:, ::-1], atol=1e-12)
    np.testing.assert_array_equal(second.swing, first.swing[:, ::-1])


@every_gait
def test_no_foot_jumps_not_even_where_the_walk_begins(gait: Gait) -> None:
    dt = 0.002
    moved = np.abs(np.diff(gait.feet(whole_walk(gait, dt)).position, axis=0)).max(axis=(0, 1))
    # The fastest that sines of these amplitudes can move in a tick; sinsin is pi/2 sines deep.
    rate = 2.0 * np.pi / gait.gait_period * dt
    bound = rate * np.array([abs(gait.step_length), 2.5 * gait.lateral_sway, 2 * gait.step_height])
    assert np.all(moved <= bound + 1e-12)


@every_gait
def test_feet_stand_still_on_the_ground_and_the_body_advances_a_step_length_a_step(
    gait: Gait,
) -> None:
    t = whole_walk(gait)
    position, swing = gait.feet(t).position, gait.feet(t).swing
    # The standing foot moves back under the hips by as much as the hips advance.
    standing = np.where(swing[:, :1], position[:, 1], position[:, 0])[:, 0]
    same = np.all(swing[1:] == swing[:-1], axis=1)
    advance = np.where(same, -np.diff(standing), 0.0)
    walking = t[1:] >= gait.startup_time
    expected = 2.0 * gait.step_length / gait.gait_period * (t[-1] - gait.startup_time)
    assert advance[walking].sum() == pytest.approx(expected, abs=1e-4)


@every_gait
def test_exchanges_are_without_speed_along_x_and_z(gait: Gait) -> None:
    exchange = gait.startup_time + gait.gait_period / 2.0
    at = gait.feet(exchange + np.array([-1e-6, 0.0, 1e-6])).position
    np.testing.assert_allclose(np.diff(at[..., 0::2], axis=0), 0.0, atol=1e-10)


def test_feet_are_a_step_length_apart_at_the_exchange() -> None:
    gait = Gait()
    left, right = ankles(gait.feet(np.array([gait.startup_time])), 0)
    assert left[0] - right[0] == pytest.approx(gait.step_length)


def test_it_stands_still_first_and_then_takes_a_half_step_with_the_left_foot() -> None:
    gait = Gait()
    feet = gait.feet(np.array([0.0, gait.stand_time - 0.002, gait.stand_time + 0.3]))
    np.testing.assert_array_equal(feet.position[0], feet.position[1])
    np.testing.assert_allclose(feet.position[0, :, 0], 0.0)
    assert feet.swing.tolist() == [[False, False], [False, False], [True, False]]
    assert np.all(np.isnan(feet.phase))
    assert np.all(feet.step_index == -1)


def test_phase_and_steps_count_from_the_start_of_the_walk() -> None:
    gait = Gait()
    t = gait.startup_time + np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * gait.gait_period
    feet = gait.feet(t)
    np.testing.assert_allclose(feet.phase, [0.0, 0.25, 0.5, 0.75, 0.0], atol=1e-9)
    assert feet.step_index.tolist() == [0, 0, 1, 1, 2]
    assert np.all(gait.feet(np.linspace(0.0, 30.0, 5001)).phase[2000:] < 1.0)


def test_all_fifteen_settings_of_the_paper_are_within_the_limits_of_the_joints() -> None:
    settings = [{"hip_height": 0.24809 - h} for h in (0.021, 0.020, 0.019, 0.018, 0.017)]
    settings += [{"lateral_sway": f} for f in (0.059, 0.057, 0.055, 0.053, 0.051)]
    settings += [{"step_length": s / 2.0} for s in (0.08, 0.09, 0.10, 0.11, 0.12)]
    for setting in settings:
        gait = Gait(**setting)
        joints = Robot().joint_targets(gait.feet(whole_walk(gait, 0.01)))
        np.testing.assert_array_equal(joints[:, [0, 6]], 0.0)  # no hip yaw-pitch is needed
        assert np.abs(joints[:, [1, 7]]).max() < np.radians(21.5)


def test_every_parameter_has_a_default_within_its_range_and_a_source() -> None:
    for parameter in parameters(Gait):
        kind = parameter.source.split(":")[0]
        assert kind in ("published", "assumption", "reconstruction"), parameter.name
        value = get_path(Gait(), parameter.name)
        if parameter.low is not None and parameter.high is not None:
            assert parameter.low <= value <= parameter.high
