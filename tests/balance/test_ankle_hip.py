"""Laws of the ankle, hip and stepping strategy."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.balance.ankle_hip import Balance
from gaitlab.errors import WrongValue
from gaitlab.model.balance import require_joints
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Attitude
from gaitlab.model.strategies import JOINTS, stance_weights
from gaitlab.plugins import load_class

DT = 0.002  # s
STAND, LEFT_SWINGS, RIGHT_SWINGS = (False, False), (True, False), (False, True)
GAINS = [item.name for item in fields(Balance) if item.name.endswith(("gain", "damping"))]
OFF = Balance(**dict.fromkeys(GAINS, 0.0), filter_time=0.0, ankle_limit=1.0, hip_limit=1.0)
ALL = replace(OFF, **{name: 0.02 * (k + 1) for k, name in enumerate(GAINS)}, swing_level=0.4)
angles = st.floats(-0.3, 0.3)
attitudes = st.builds(Attitude, angles, angles, angles, angles)


def meant(swing: tuple[bool, bool], *, lean: float = 0.0, ticks: int = 200) -> FeetPoses:
    """Feet that stand or swing throughout; where they are does not matter to balance."""
    nothing = np.zeros((ticks, 2))
    return FeetPoses(
        position=np.zeros((ticks, 2, 3)),
        heading=nothing,
        trunk_pitch=np.full(ticks, lean),
        ankle_pitch=nothing,
        knee_only=nothing,
        swing=np.tile(swing, (ticks, 1)),
        phase=np.zeros(ticks),
        step_index=np.zeros(ticks, dtype=int),
    )


def corrections(
    balance: Balance, felt: Attitude, swing: tuple[bool, bool] = STAND, lean: float = 0.0
) -> dict[str, float]:
    controller = balance.controller(meant(swing, lean=lean), DT)
    return dict(zip(JOINTS, controller.correction(0, felt), strict=True))


@given(attitudes, st.sampled_from([STAND, LEFT_SWINGS, RIGHT_SWINGS]))
def test_no_gain_corrects_nothing(felt: Attitude, swing) -> None:
    assert set(corrections(OFF, felt, swing).values()) == {0.0}


@given(attitudes, st.sampled_from([STAND, LEFT_SWINGS, RIGHT_SWINGS]))
def test_a_mirrored_fall_is_answered_by_the_mirrored_correction(felt: Attitude, swing) -> None:
    one = corrections(ALL, felt, swing)
    mirrored = felt._replace(roll=-felt.roll, roll_rate=-felt.roll_rate)
    other = corrections(ALL, mirrored, swing[::-1])
    for name, angle in one.items():
        across = name.replace("left", "r#").replace("right", "left").replace("r#", "right")
        sign = -1.0 if name.endswith("roll") else 1.0
        assert other[across] == pytest.approx(sign * angle, abs=1e-12)


@given(attitudes, st.sampled_from([STAND, LEFT_SWINGS, RIGHT_SWINGS]))
def test_no_correction_is_larger_than_its_limit(felt: Attitude, swing) -> None:
    strong = replace(ALL, **dict.fromkeys(GAINS, 0.5), ankle_limit=0.02, hip_limit=0.03)
    for name, angle in corrections(strong, felt, swing).items():
        assert abs(angle) <= (0.02 if "ankle" in name else 0.03)


@given(attitudes, st.sampled_from([STAND, LEFT_SWINGS, RIGHT_SWINGS]))
def test_within_the_limits_corrections_are_proportional_to_what_is_felt(felt, swing) -> None:
    half = Attitude(*(0.5 * part for part in felt))
    whole, small = corrections(ALL, felt, swing), corrections(ALL, half, swing)
    assert list(small.values()) == pytest.approx([0.5 * a for a in whole.values()], abs=1e-12)


@pytest.mark.parametrize("axis", ["pitch", "roll"])
@pytest.mark.parametrize("felt", ["", "_rate"])
def test_positive_gains_act_against_the_fall(axis: str, felt: str) -> None:
    """A sole pressed down where the robot falls to, a trunk turned back, a foot swung there.

    Positive ankle pitch is toe down, ankle roll right edge down; positive hip pitch turns the leg
    back under the trunk, so the trunk back over a leg that stands.
    """
    kind = "damping" if felt else "gain"
    names = {f"{joint}_{axis}_{kind}": 0.1 for joint in ("ankle", "hip", "step")}
    falling = Attitude(0.0, 0.0, 0.0, 0.0)._replace(**{f"{axis}{felt}": 0.2})
    found = corrections(replace(OFF, **names), falling, RIGHT_SWINGS)
    assert found[f"left_ankle_{axis}"] == pytest.approx(0.02)
    assert found[f"left_hip_{axis}"] == pytest.approx(0.02)
    assert found[f"right_hip_{axis}"] == pytest.approx(-0.02)
    assert found[f"right_ankle_{axis}"] == 0.0
    others = [angle for name, angle in found.items() if axis not in name]
    assert set(others) == {0.0}


@given(attitudes)
def test_a_swing_sole_that_is_kept_level_turns_back_by_all_that_tilts_it(felt: Attitude) -> None:
    level = replace(OFF, swing_level=1.0, step_pitch_gain=0.3, step_roll_damping=0.1)
    found = corrections(level, felt, LEFT_SWINGS)
    for axis in ("pitch", "roll"):
        tilt = getattr(felt, axis) + found[f"left_hip_{axis}"] + found[f"left_ankle_{axis}"]
        assert tilt == pytest.approx(0.0, abs=1e-12)


def test_the_lean_that_the_gait_means_is_no_error() -> None:
    assert set(corrections(ALL, Attitude(0.2, 0.0, 0.0, 0.0), lean=0.2).values()) == {0.0}


def test_the_filter_follows_a_lasting_lean_and_smooths_a_jump() -> None:
    slow = replace(OFF, ankle_pitch_gain=1.0, filter_time=0.1)
    controller = slow.controller(meant(STAND), DT)
    upright, leaning = Attitude(0.0, 0.0, 0.0, 0.0), Attitude(0.1, 0.0, 0.0, 0.0)
    controller.correction(0, upright)
    column = JOINTS.index("left_ankle_pitch")
    rising = [controller.correction(0, leaning)[column] for _ in range(100)]
    share = 1.0 - np.exp(-(np.arange(100) + 1) * 0.01 / 0.1)  # readings 10 ms apart
    assert rising == pytest.approx(0.1 * share, rel=1e-9)


def test_a_leg_that_always_stands_or_swings_has_its_weight_throughout() -> None:
    swing = np.tile([True, False], (50, 1))
    np.testing.assert_array_equal(stance_weights(swing, 20), ~swing)


def test_a_leg_passes_from_stance_to_swing_in_the_blend_time() -> None:
    swing = np.repeat([[False, False], [True, False]], 50, axis=0)
    weights = stance_weights(swing, 20)
    np.testing.assert_array_equal(weights[:, 1], 1.0)
    falling = weights[:, 0]
    assert (np.diff(falling) <= 0.0).all()
    assert np.count_nonzero((falling > 0.0) & (falling < 1.0)) == 20
    np.testing.assert_array_equal(stance_weights(swing, 0), ~swing)


@pytest.mark.parametrize("name", ["eros", "nao", "flow", "bioloid"])
def test_robots_with_hips_and_ankles_can_balance(name: str) -> None:
    """The signs of a correction are those of right-handed joints."""
    robot = load_class("robot", name)()
    require_joints(Balance(), robot)
    axes = {joint.name: joint.axis for joint in robot.tree.joints}
    assert {axes[joint] for joint in JOINTS if joint.endswith("pitch")} == {"y"}
    assert {axes[joint] for joint in JOINTS if joint.endswith("roll")} == {"x"}


def test_a_robot_without_ankle_motors_is_refused_by_the_joints_it_lacks() -> None:
    with pytest.raises(WrongValue, match=r"left_ankle_pitch.*'biped' has no servo.*leave `bal"):
        require_joints(Balance(), load_class("robot", "biped")())
