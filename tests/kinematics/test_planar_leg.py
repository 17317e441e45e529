import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.planar_leg import (
    Coupling,
    LegAngles,
    angles_of,
    ankle_position,
    joints_of,
    leg_angles,
)

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "bioloid.json").read_text())
TOLERANCE = 1e-6  # degrees and cm, digits of the reference vectors
LENGTHS = {"thigh": 0.075, "shank": 0.075}
UNEQUAL = {"thigh": 0.08, "shank": 0.07}
every_pose = pytest.mark.parametrize("case", GOLDEN["ik_table2"])


def targets(n: int = 10_000) -> np.ndarray:
    low, high = [-0.05, 0.06, -0.05], [0.06, 0.125, 0.05]
    return np.random.default_rng(3).uniform(low, high, size=(n, 3))


def metres(case: dict[str, Any]) -> np.ndarray:
    return np.array(case["xyz"]) / 100.0


@every_pose
def test_the_published_law_equals_the_reference(case: dict[str, Any]) -> None:
    angles = np.degrees(leg_angles(metres(case), **LENGTHS))
    expected = [case[name] for name in LegAngles._fields]
    np.testing.assert_allclose(angles, expected, atol=TOLERANCE)


@every_pose
def test_spatial_coupling_equals_the_reference(case: dict[str, Any]) -> None:
    angles = leg_angles(metres(case), coupling="spatial", **LENGTHS)
    names = ("alpha", "beta", "gamma", "theta")
    found = [np.degrees(getattr(angles, name)) for name in names]
    np.testing.assert_allclose(found, [case["ik3d"][name] for name in names], atol=TOLERANCE)


@every_pose
def test_the_flat_law_equals_the_reference(case: dict[str, Any]) -> None:
    for lean, name in ((0.0, "gamma_flat0"), (17.0, "gamma_for_flat_feet_lean_17")):
        angles = leg_angles(metres(case), ankle_law="flat", lean=np.radians(lean), **LENGTHS)
        assert np.degrees(angles.gamma) == pytest.approx(case[name], abs=TOLERANCE)


@every_pose
def test_the_published_law_leans_the_torso_by_alpha1(case: dict[str, Any]) -> None:
    lean = np.degrees(leg_angles(metres(case), **LENGTHS).lean)
    assert lean == pytest.approx(case["lean_if_gamma_eq7"], abs=TOLERANCE)


@pytest.mark.parametrize("coupling", get_args(Coupling))
@pytest.mark.parametrize("lengths", [LENGTHS, UNEQUAL])
def test_forward_kinematics_inverts_inverse_kinematics(
    coupling: Coupling, lengths: dict[str, float]
) -> None:
    given = targets()
    angles = leg_angles(given, coupling=coupling, **lengths)
    found = ankle_position(angles, coupling=coupling, **lengths)
    np.testing.assert_allclose(found, given, atol=1e-12)


def test_the_flat_law_holds_the_lean_whatever_the_target() -> None:
    lean = np.random.default_rng(4).uniform(-0.3, 0.3, size=10_000)
    angles = leg_angles(targets(), ankle_law="flat", lean=lean, **LENGTHS)
    np.testing.assert_allclose(angles.lean, lean, atol=1e-14)


def test_legs_mirror_each_other_under_the_other_sign_of_z() -> None:
    one = leg_angles(targets(500), **LENGTHS)
    other = leg_angles(targets(500) * [1.0, 1.0, -1.0], **LENGTHS)
    for name in ("alpha", "beta", "gamma"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.theta, -other.theta)
    np.testing.assert_array_equal(one.omega, -other.omega)


def test_an_ankle_behind_the_hip_has_a_negative_first_angle() -> None:
    behind, ahead = leg_angles([[-0.03, 0.11, 0.0], [0.03, 0.11, 0.0]], **LENGTHS).alpha
    reach = np.hypot(0.03, 0.11)
    assert ahead - behind == pytest.approx(2.0 * np.arctan2(0.03, 0.11), abs=1e-15)
    assert ahead + behind == pytest.approx(2.0 * np.arccos(reach / 0.15), abs=1e-12)


def test_joints_and_angles_are_inverse() -> None:
    joints = np.random.default_rng(5).uniform(-1.0, 1.0, size=(100, 5))
    np.testing.assert_array_equal(joints_of(angles_of(joints)), joints)


def test_a_target_out_of_reach_says_which_leg_and_what_it_spans() -> None:
    far = np.array([[0.0, 0.14, 0.0], [0.0, 0.151, 0.0]])
    with pytest.raises(
        Infeasible, match=r"0\.1510 m, the leg spans \[0\.0000, 0\.1500\]"
    ) as caught:
        leg_angles(far, limb="right_leg", **LENGTHS)
    assert (caught.value.limb, caught.value.tick) == ("right_leg", 1)


@pytest.mark.parametrize("target", [[np.nan, 0.1, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, 0.0]])
def test_no_direction_and_no_number_are_infeasible(target: list[float]) -> None:
    with pytest.raises(Infeasible):
        leg_angles(np.array(target), **LENGTHS)


def test_a_stretched_leg_is_within_reach() -> None:
    angles = leg_angles(np.array([0.09, 0.12, 0.0]), **LENGTHS)
    assert angles.beta == pytest.approx(0.0, abs=1e-7)
