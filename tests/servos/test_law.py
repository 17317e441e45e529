"""Laws of the DC-motor servo, one tick at a time; test_motor_bench.py has it in Bullet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.model.servo import Servo
from gaitlab.servos.law import servo_row, torque_limit
from gaitlab.simulation.bullet.motors import drive, feedback, lags

SERVO = Servo(
    stall_torque=6.0, no_load_speed=6.6, voltage=12.0, supply=12.0, torque_limit=0.6,
    position_gain=60.0, latency=0.0, resolution=0.0, backlash=0.0, mass=0.1,
)  # fmt: skip
angles = st.floats(-2.0, 2.0)
speeds = st.floats(-12.0, 12.0)


def driven(
    servo: Servo, target: float, position: float = 0.0, velocity: float = 0.0
) -> tuple[float, float]:
    """Speed [rad/s] a servo heads for and torque [N m] it has, on a joint that nothing moves."""
    speed, torque = np.zeros(1), np.zeros(1)
    row = servo_row([servo], np.ones(1))
    memory = feedback(row.damping, np.full((1, 1), 1e-9), 0.002)
    memory.velocity[:], memory.load[:] = velocity, 0.0
    at, turning = np.array([position]), np.array([velocity])
    drive(row, memory, np.array([target]), at, turning, np.zeros(1), speed, torque)
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
def test_at_full_duty_the_torque_lies_on_the_torque_speed_line(velocity: float) -> None:
    servo = replace(SERVO, torque_limit=1.0)
    speed, bound = driven(servo, 2.0, 0.0, velocity)
    line = servo.stall_torque * (1.0 - velocity / servo.no_load_speed)
    expected = np.clip(line, -servo.stall_torque, servo.stall_torque)
    assert np.isclose(np.sign(speed - velocity) * bound, expected, atol=1e-6)


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


@given(st.floats(1e-5, 10.0), st.floats(1e-4, 4e-3), st.floats(-3.0, 3.0))
def test_a_free_joint_moves_by_the_implicit_step_of_the_law(
    inertia: float, dt: float, target: float
) -> None:
    """J (v' - v) / dt = damping (speed - v'), tick after tick, however light the link is."""
    servo = replace(SERVO, torque_limit=1.0)
    row = servo_row([servo], np.ones(1))
    memory = feedback(row.damping, np.full((1, 1), 1.0 / inertia), dt)
    position, velocity, applied = np.zeros(1), np.zeros(1), np.zeros(1)
    speed, bound = np.zeros(1), np.zeros(1)
    drive(row, memory, position, position, velocity, applied, speed, bound)
    for _ in range(20):
        drive(row, memory, np.array([target]), position, velocity, applied, speed, bound)
        torque = float(np.sign(speed - velocity)[0]) * bound
        expected = (velocity + memory.ratio * speed) / (1.0 + memory.ratio)
        within = np.abs(row.damping * (speed - expected)) < row.limit
        velocity, applied = velocity + torque * dt / inertia, torque
        assert not within or np.allclose(velocity, expected, atol=1e-6)
        position = position + velocity * dt


@given(st.integers(1, 8), st.integers(0, 1000))
def test_the_prediction_outweighs_whatever_shakes_the_joints(joints: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(joints, joints + 2)) * np.exp(rng.normal(0.0, 2.0, (joints, 1)))
    damping, mobility = rng.uniform(0.1, 5.0, joints), root @ root.T
    found = feedback(damping, mobility, 0.002)
    coupled = 0.002 * np.sqrt(np.outer(damping, damping)) * mobility
    spare = np.diag(2.0 / 3.0 + 4.0 / 3.0 * found.ratio) - coupled
    assert np.linalg.eigvalsh(spare)[0] >= -1e-9 * np.abs(coupled).max()
    assert np.all(found.ratio >= np.diag(coupled) * (1.0 - 1e-12))
    assert np.all((found.lead >= 0.0) & (found.lead < 1.0))


@given(st.floats(0.01, 400.0), st.floats(1e-4, 1.0))
def test_no_load_swings_up(ratio: float, lighter: float) -> None:
    """The loop of one joint whose load is as heavy as its own link, or heavier, dies out.

    Its state is v now and in the two ticks before, and the motor's torque over damping in those.
    """
    damping = np.ones(1)
    made = feedback(damping, np.full((1, 1), ratio / 0.002), 0.002)
    lead, kappa = float(made.lead[0]), ratio / (1.0 + ratio)
    load_now = np.array([1.0 / ratio, -1.0 / ratio, 0.0, -1.0, 0.0])
    load_before = np.array([0.0, 1.0 / ratio, -1.0 / ratio, 0.0, -1.0])
    ahead = load_now + lead * (load_now - load_before)
    torque = -(np.eye(5)[0] * (1.0 - kappa) + kappa * ahead)
    step = np.zeros((5, 5))
    step[0] = np.eye(5)[0] + ratio * lighter * torque
    step[1, 0] = step[2, 1] = step[4, 3] = 1.0
    step[3] = torque
    assert np.abs(np.linalg.eigvals(step)).max() < 1.0 + 1e-6


@pytest.mark.parametrize("ratio", [0.5, 3.0, 15.0, 60.0])
def test_a_heavily_loaded_joint_is_told_its_speed_as_late_as_stated(ratio: float) -> None:
    """Its speed is swung from outside; how late the torque follows it, r (1 - theta) ticks.

    The law asks for the speed at the end of the tick, which is one later than the one it is given.
    """
    servo = replace(SERVO, torque_limit=1.0)
    row, dt = servo_row([servo], np.ones(1)), 0.002
    mobility = np.full((1, 1), ratio / (row.damping[0] * dt))
    memory, ticks = feedback(row.damping, mobility, dt), 40_000
    omega = 0.02 / (1.0 + ratio)  # rad a tick
    speed, torque, fed = np.zeros(1), np.zeros(1), np.zeros(ticks)
    for k in range(ticks):
        turning = np.array([0.2 * np.sin(omega * k)])
        drive(row, memory, np.full(1, 2.0), np.zeros(1), turning, torque.copy(), speed, torque)
        fed[k] = speed[0] - torque[0] / row.damping[0]
    whole = round(2.0 * np.pi / omega)
    late = np.arange(ticks - whole * ((ticks // 2) // whole), ticks)
    phase = np.angle(np.sum(fed[late] * np.exp(-1j * omega * late)) * 1j)
    stated = lags(row.damping, mobility, dt)[0] / dt
    assert 1.0 - phase / omega == pytest.approx(stated, rel=0.03, abs=0.02)
