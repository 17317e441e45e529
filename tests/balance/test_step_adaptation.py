"""Laws of the steps that grow shorter and higher while a walk is uneasy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.balance import ankle_hip
from gaitlab.balance.step_adaptation import Balance
from gaitlab.gaits.eros import Gait
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Attitude
from gaitlab.model.strategies import JOINTS as STRATEGIES
from gaitlab.robots.eros import Robot

DT = 0.002  # s
CALM = Attitude(0.0, 0.0, 0.0, 0.0)
FEET = Gait(step_length=0.05).feet(np.arange(0.0, 4.0, DT))
JOINTS = Balance.joints
angles = st.floats(-0.3, 0.3)
attitudes = st.builds(Attitude, angles, angles, angles, angles)
ticks = st.integers(0, len(FEET.phase) - 1)
ALONE = Balance(  # balance does nothing; everything that is felt is unease
    **dict.fromkeys(
        ("ankle_pitch_gain", "ankle_pitch_damping", "ankle_roll_gain", "ankle_roll_damping"), 0.0
    ),
    filter_time=0.0,
    start=0.0,
    tilt_weight=100.0,
    rate_weight=20.0,
)


def corrections(balance: Balance, tick: int, felt: Attitude) -> dict[str, float]:
    lean = float(FEET.trunk_pitch[tick])
    felt = felt._replace(pitch=felt.pitch + lean)
    controller = balance.controller(FEET, DT)
    return dict(zip(JOINTS, controller.correction(tick, felt), strict=True))


def targets(balance: Balance, tick: int, felt: Attitude) -> tuple[Robot, np.ndarray]:
    """Joint targets of the gait with the corrections."""
    robot = Robot()
    names = [joint.name for joint in robot.tree.joints]
    found = robot.joint_targets(FEET.at(tick))[0]
    for name, turn in corrections(balance, tick, felt).items():
        found[names.index(name)] += turn
    return robot, found


def legs(balance: Balance, tick: int, felt: Attitude) -> np.ndarray:
    """How far each leg's ankle is ahead of its hip and below it, and the pitch of its sole, from
    the three pitch joints of two links of equal length. Shape (2, 3).
    """
    robot, found = targets(balance, tick, felt)
    names = [joint.name for joint in robot.tree.joints]
    rows = []
    for side in ("left", "right"):
        hip, knee, ankle = (
            found[names.index(f"{side}_{joint}")] for joint in ("hip_pitch", "knee", "ankle_pitch")
        )
        thigh, shank = robot.leg.thigh, robot.leg.shank
        ahead = -thigh * np.sin(hip) - shank * np.sin(hip + knee)
        below = thigh * np.cos(hip) + shank * np.cos(hip + knee)
        rows.append((ahead, below, hip + knee + ankle))
    return np.array(rows)


@given(ticks, attitudes)
def test_at_ease_it_is_the_balance_of_ankle_and_hip(tick: int, felt: Attitude) -> None:
    gains = replace(ALONE, ankle_pitch_gain=0.3, hip_roll_gain=0.2, start=5.0, tilt_weight=0.0)
    felt = felt._replace(pitch_rate=0.0, roll_rate=0.0)
    plain = ankle_hip.Balance(
        **{name: getattr(gains, name) for name in ankle_hip.Balance.__dataclass_fields__}
    )
    lean = float(FEET.trunk_pitch[tick])
    expected = plain.controller(FEET, DT).correction(tick, felt._replace(pitch=felt.pitch + lean))
    found = corrections(gains, tick, felt)
    assert [found[name] for name in STRATEGIES] == list(expected)
    assert found["left_knee"] == found["right_knee"] == 0.0


@given(ticks)
def test_who_is_not_disturbed_walks_as_the_gait_means(tick: int) -> None:
    wild = replace(ALONE, shortening=1.0, lifting=0.6)
    assert set(corrections(wild, tick, CALM).values()) <= {0.0, -0.0}


@given(ticks)
def test_wholly_uneasy_and_shortened_the_robot_steps_in_place(tick: int) -> None:
    """The feet stay below the hips as they stood, but for what the sole, which keeps its angle, is
    behind the leg that is turned: the height of the ankle over it, of the whole leg's.
    """
    asked = replace(ALONE, shortening=1.0)
    meant = legs(replace(asked, shortening=0.0), tick, CALM)
    found = legs(asked, tick, Attitude(0.1, 0.0, 0.0, 0.0))
    stood = legs(asked, 0, CALM)
    ankle = Robot().sole.height / float(-FEET.position[tick, :, 2].max())
    ahead = np.abs(FEET.position[tick, :, 0] - FEET.position[0, :, 0])
    left = np.abs(found[:, 0] - stood[:, 0])
    assert (left <= 1.1 * ankle * ahead + 1e-9).all()
    np.testing.assert_allclose(found[:, 2], meant[:, 2], atol=1e-12)


@given(ticks, st.floats(0.01, 0.5))
def test_only_a_raised_foot_is_lifted_and_its_sole_keeps_its_angle(tick: int, bend: float) -> None:
    asked = replace(ALONE, shortening=0.0, lifting=bend)
    meant, found = (legs(asked, tick, felt) for felt in (CALM, Attitude(0.1, 0.0, 0.0, 0.0)))
    height = FEET.position[tick, :, 2]
    for leg in range(2):
        raised = height[leg] - height.min() > 1e-9
        lifted = meant[leg, 1] - found[leg, 1]
        assert lifted > 0.0 if raised else lifted == 0.0
    np.testing.assert_allclose(found[:, 2], meant[:, 2], atol=1e-12)


@given(ticks, attitudes)
def test_the_mirrored_walk_is_answered_by_the_mirrored_correction(tick: int, felt) -> None:
    gains = replace(ALONE, shortening=0.5, lifting=0.3, step_roll_gain=0.2)
    flipped = FeetPoses(
        position=FEET.position[:, ::-1] * (1.0, -1.0, 1.0),
        heading=-FEET.heading[:, ::-1],
        trunk_pitch=FEET.trunk_pitch,
        ankle_pitch=FEET.ankle_pitch[:, ::-1],
        knee_only=FEET.knee_only[:, ::-1],
        swing=FEET.swing[:, ::-1],
        phase=FEET.phase,
        step_index=FEET.step_index,
    )
    one = dict(zip(JOINTS, gains.controller(FEET, DT).correction(tick, felt), strict=True))
    mirrored = felt._replace(roll=-felt.roll, roll_rate=-felt.roll_rate)
    other = gains.controller(flipped, DT).correction(tick, mirrored)
    for name, angle in zip(JOINTS, other, strict=True):
        across = name.replace("left", "r#").replace("right", "left").replace("r#", "right")
        sign = -1.0 if name.endswith("roll") else 1.0
        assert one[across] == pytest.approx(sign * angle, abs=1e-12)


def test_unease_rises_at_once_and_falls_with_its_time_constant() -> None:
    gains = replace(ALONE, lifting=0.3, calm_time=0.4)
    feet = replace(FEET, trunk_pitch=np.zeros_like(FEET.trunk_pitch))
    tick = int(np.argmax(feet.position[:, 0, 2]))  # the left foot at its highest
    controller, column = gains.controller(feet, DT), JOINTS.index("left_knee")
    bends = [controller.correction(tick, Attitude(0.1, 0.0, 0.0, 0.0))[column]]
    bends += [controller.correction(tick, CALM)[column] for _ in range(50)]
    spacing = gains.imu.spacing(DT)
    assert bends == pytest.approx(0.6 * np.exp(-np.arange(51) * spacing / 0.4), rel=1e-9)
