import csv
from importlib import resources

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.gaits.bioloid import JOINTS, SIDES, Gait
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import Gait as GaitProtocol
from gaitlab.parameters import parameters
from gaitlab.robots.bioloid import Robot

GAIT = Gait()
PROTOCOL: GaitProtocol = GAIT
ROBOT = Robot()


def whole_walk(gait: Gait, cycles: float = 2.0) -> np.ndarray:
    return np.arange(0.0, gait.startup_time + cycles * gait.gait_period, 0.002)


def published_poses() -> np.ndarray:
    """Table 2 in metres. Shape (5, left and right, 3)."""
    text = (
        resources.files("gaitlab.papers.printed").joinpath("bioloid_table2.csv").read_text("utf-8")
    )
    rows = list(csv.DictReader(text.splitlines()))
    return (
        np.array(
            [
                [
                    [float(row[f"{side} foot position {a} (cm)"]) for a in "XYZ"]
                    for side in ("Left", "Right")
                ]
                for row in rows
            ]
        )
        / 100.0
    )


def test_the_default_poses_are_the_published_ones() -> None:
    np.testing.assert_allclose(GAIT.targets, published_poses(), atol=1e-15)


def test_a_right_step_is_the_mirror_image_of_a_left_one() -> None:
    turned = GAIT.targets[:, ::-1] * [1.0, 1.0, -1.0]
    np.testing.assert_array_equal(GAIT.targets[[0, 3, 4, 1, 2]], turned)


def test_the_flat_law_keeps_both_soles_parallel_and_the_published_one_18_degrees_out() -> None:
    flat, published = GAIT.angles.lean, Gait(ankle_law="published").angles.lean
    np.testing.assert_allclose(flat[:, 0], flat[:, 1], atol=1e-14)
    out = np.degrees(published[:, 0] - published[:, 1])
    assert out[2] == pytest.approx(18.03, abs=0.01)  # step left
    assert out[4] == pytest.approx(-18.03, abs=0.01)  # step right


@pytest.mark.parametrize("coupling", ["planar", "spatial"])
def test_joints_that_it_sets_are_those_of_level_soles_but_for_roll_under_lean(
    coupling: str,
) -> None:
    feet = Gait(coupling=coupling).feet(whole_walk(GAIT))
    given = joint_commands(ROBOT, feet)[:, :10]
    level = ROBOT.joint_targets(feet)[:, :10]
    difference = np.abs(given - level).max(axis=0).reshape(2, 5)
    np.testing.assert_allclose(difference[:, :3], 0.0, atol=1e-12)  # hip and knee
    assert difference[:, 3:].max() < np.radians(1.0)  # the ankle neglects roll times lean


def test_targets_move_without_jumps_and_rest_in_the_poses() -> None:
    gait = Gait(pause_time=0.2)
    legs = joint_commands(ROBOT, gait.feet(whole_walk(gait)))[:, :10]
    largest = np.abs(np.diff(legs, axis=0)).max()
    fastest = 1.5 * np.abs(np.diff(gait._legs, axis=0)).max() / 0.4  # of a cubic, three halves
    assert largest <= 2.0 * fastest * gait.control_period
    ends = gait.startup_time + np.arange(4) * 0.6 + 0.5
    at_rest = joint_commands(ROBOT, gait.feet(ends))[:, :10].reshape(4, 2, 5)
    np.testing.assert_allclose(at_rest, gait._legs[[1, 2, 3, 4]], atol=1e-12)


def test_it_repeats_itself_every_period() -> None:
    t = GAIT.startup_time + np.arange(0.0, GAIT.gait_period, GAIT.control_period)
    one, other = (GAIT.feet(t + 1e-6 + k * GAIT.gait_period) for k in (0, 1))
    np.testing.assert_allclose(other.position, one.position, atol=1e-12)
    np.testing.assert_array_equal(other.swing, one.swing)
    np.testing.assert_array_equal(other.step_index, one.step_index + 2)
    np.testing.assert_allclose(other.phase, one.phase, atol=1e-9)


def test_the_start_up_ends_where_the_cycle_begins_and_is_not_measured() -> None:
    feet = GAIT.feet(whole_walk(GAIT))
    t = whole_walk(GAIT)
    before = t < GAIT.startup_time - 0.5 * GAIT.control_period
    after = t > GAIT.startup_time + GAIT.control_period
    assert np.all(np.isnan(feet.phase[before]))
    assert np.all(feet.step_index[before] == -1)
    assert np.all(np.isfinite(feet.phase[after]))


def test_standing_begins_with_a_level_trunk_over_level_soles() -> None:
    feet = GAIT.feet(np.zeros(1))
    assert feet.trunk_pitch[0] == pytest.approx(0.0, abs=1e-15)
    assert feet.position[0, :, 2] == pytest.approx(-GAIT.hip_height, abs=1e-12)
    names = [f"{side}_{joint}" for side in SIDES for joint in JOINTS]
    assert set(names) < set(feet.joints)


def test_only_one_foot_swings_at_a_time_left_first() -> None:
    feet = GAIT.feet(whole_walk(GAIT))
    assert not np.any(feet.swing.all(axis=1))
    first = np.argmax(feet.swing.any(axis=1))
    assert feet.swing[first].tolist() == [True, False]
    assert not feet.swing[: int(2.0 * GAIT.stand_time / 0.002) - 1].any()


def test_measured_stance_roll_turns_the_stance_ankle_alone() -> None:
    plain, measured = GAIT.angles.omega, Gait(stance_omega_sign=-1).angles.omega
    changed = np.argwhere(plain != measured).tolist()
    assert changed == [[1, 1], [3, 0]]  # right leg in lift left, left leg in lift right
    np.testing.assert_array_equal(measured[1, 1], -plain[1, 1])


def test_walking_backwards_puts_the_stepping_foot_behind() -> None:
    poses = Gait(step_length=-0.02).targets
    assert poses[2, 0, 0] - poses[2, 1, 0] == pytest.approx(-0.02, abs=1e-15)
    assert poses[2, 1, 1] < poses[2, 0, 1]  # the front foot stands higher in the leaning frame


def test_a_pose_out_of_reach_is_infeasible() -> None:
    with pytest.raises(Infeasible, match="the leg spans"):
        Gait(leg_drop=0.15).feet(np.zeros(1))


def test_every_parameter_says_where_its_default_comes_from() -> None:
    for parameter in parameters(Gait):
        assert parameter.source.startswith(("assumption", "published", "reconstruction"))
