"""Laws of the DC-motor servo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.servos import Servo
from gaitlab.servos.law import drive, servo_row, torque_limit

SERVO = Servo(
    stall_torque=6.0, no_load_speed=6.6, voltage=12.0, supply=12.0, torque_limit=0.6,
    position_gain=60.0, latency=0.0, resolution=0.0, backlash=0.0, mass=0.1,
)  # fmt: skip
angles = st.floats(-2.0, 2.0)
speeds = st.floats(-12.0, 12.0)


def driven(
    servo: Servo, target: float, position: float = 0.0, velocity: float = 0.0, dt: float = 0.002
) -> tuple[float, float]:
    """Speed [rad/s] the servo heads for and torque [N m] it has."""
    speed, torque = np.zeros(1), np.zeros(1)
    row = servo_row([servo], np.ones(1), dt)
    drive(row, np.array([target]), np.array([position]), np.array([velocity]), speed, torque)
    return float(speed[0]), float(torque[0])


@given(angles, angles, speeds)
def test_torque_stays_within_the_limit_and_speed_within_no_load(
    target: float, position: float, velocity: float
) -> None:
    speed, torque = driven(SERVO, target, position, velocity)
    assert 0.0 <= torque <= torque_limit(SERVO) + 1e-12
    assert abs(speed) <= SERVO.no_load_speed


@given(angles, angles, speeds)
def test_turning_everything_round_turns_the_answer_round(
    target: float, position: float, velocity: float
) -> None:
    speed, torque = driven(SERVO, target, position, velocity)
    mirrored = driven(SERVO, -target, -position, -velocity)
    assert mirrored == (-speed, torque)


@given(speeds)
def test_a_servo_that_drives_never_exceeds_its_torque_speed_line(velocity: float) -> None:
    velocity = abs(velocity)
    _, torque = driven(replace(SERVO, torque_limit=1.0), 2.0, 0.0, velocity)
    line = SERVO.stall_torque * (1.0 - velocity / SERVO.no_load_speed)
    assert torque <= max(line, 0.0) + 1e-12


def test_at_rest_the_torque_is_proportional_to_the_error_until_it_saturates() -> None:
    stiffness = SERVO.stall_torque / SERVO.no_load_speed * SERVO.position_gain
    for error in (0.01, 0.03):
        assert np.isclose(driven(SERVO, error)[1], stiffness * error)
    assert driven(SERVO, 1.0)[1] == torque_limit(SERVO)


def test_backlash_is_lost_motion_on_both_sides_of_the_target() -> None:
    loose = replace(SERVO, backlash=0.02)
    assert driven(loose, 0.009)[0] == 0.0
    assert driven(loose, -0.009)[0] == 0.0
    assert np.isclose(driven(loose, 0.03)[0], SERVO.position_gain * 0.02)


def test_resolution_rounds_target_and_encoder_to_counts() -> None:
    coarse = replace(SERVO, resolution=0.01)
    assert driven(coarse, 0.004)[0] == 0.0
    assert np.isclose(driven(coarse, 0.006)[0], SERVO.position_gain * 0.01)


def test_a_lower_battery_lowers_torque_and_speed_in_proportion() -> None:
    tired = replace(SERVO, supply=9.0)
    assert np.isclose(torque_limit(tired), 0.75 * torque_limit(SERVO))
    assert np.isclose(driven(tired, 2.0)[0], 0.75 * driven(SERVO, 2.0)[0])


def test_a_smaller_time_step_lets_more_velocity_feedback_through() -> None:
    """The implicit feedback tends to the motor's damping as the step vanishes."""
    damping = SERVO.stall_torque / SERVO.no_load_speed
    coarse, fine = (servo_row([SERVO], np.ones(1), dt).feedback[0] for dt in (2e-3, 1e-8))
    assert coarse < fine < damping
    assert np.isclose(fine, damping, rtol=1e-4)
