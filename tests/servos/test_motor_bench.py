"""Every shipped servo on a bench, in Bullet: one joint that it turns, a load on it, no robot.

The bench asks what the servo's file claims: torque at rest, torque at speed, the limit, the speed
without load; for a link as light as a finger and one as heavy as a leg, at three time steps.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.model import Box, Joint, Link, Tree
from gaitlab.model.servo import Servo
from gaitlab.model.soles import Sole
from gaitlab.model.urdf import urdf
from gaitlab.plugins import names
from gaitlab.servos.files import load_servo
from gaitlab.servos.law import torque_limit
from gaitlab.simulation.bullet.motors import Motors
from gaitlab.simulation.bullet.world import (
    VELOCITY_CONTROL,
    WORLD_FRAME,
    BulletClient,
    indices,
    links,
    mobility,
    new_world,
    pybullet,
)
from gaitlab.simulation.simulate import simulate

SERVOS = tuple(names("servo"))
RATIOS = (0.05, 1.0, 15.0, 60.0)  # damping dt / inertia at 2 ms; no shipped joint has more than 50
HELD = 1e6  # kg m^2
TOLERANCE = 0.01  # what the bench allows a servo to differ from its file


class Reading(NamedTuple):
    """Mean over the last part of a run: speed [rad/s] and torque [N m]."""

    speed: float
    torque: float


def clean(name: str) -> Servo:
    """The servo without rounding, play and delay, which have tests of their own."""
    return replace(load_servo(name), resolution=0.0, backlash=0.0, latency=0.0)


def inertias(servo: Servo) -> list[float]:
    """Inertias to turn, in [kg m^2], from a leg's to a finger's for a servo of this strength."""
    return [servo.stall_torque / servo.no_load_speed * 0.002 / ratio for ratio in RATIOS]


def bench(
    servo: Servo,
    inertia: float,
    *,
    target: float,
    load: float = 0.0,
    held: bool = False,
    dt: float = 0.002,
    seconds: float | None = None,
) -> Reading:
    """Let a servo turn a link against a load.

    Args:
        servo: The servo.
        inertia: Of the link about the joint, in [kg m^2].
        target: Where the servo is sent, in [rad].
        load: Torque on the link, in [N m].
        held: Tie the link to a mass that it cannot move, which the servo knows nothing of, as the
            ground holds the foot of a standing leg.
        dt: Time step, in [s].
        seconds: How long; long enough for the motor's own time constant when left out.
    """
    client = new_world(50)
    client.setTimeStep(dt)
    client.setGravity(0.0, 0.0, 0.0)
    size = float(np.sqrt(6.0 * (HELD if held else inertia)))  # of a cube of 1 kg
    joint = Joint(name="joint", axis="y", lower=-1e6, upper=1e6, servo=None)
    cube = Box(size=(size, size, size), centre=(0.0, 0.0, 0.0))
    here = (0.0, 0.0, 0.0)
    tree = Tree(
        (
            Link(name="stand", parent=None, origin=here, joint=None, mass=1.0, box=cube),
            Link(name="link", parent="stand", origin=here, joint=joint, mass=1.0, box=cube),
        )
    )
    body = loaded(client, tree)
    index = indices(client, body).joint["joint"]
    client.setJointMotorControl2(body, index, VELOCITY_CONTROL, force=0.0)
    client.changeDynamics(body, index, jointDamping=0.0, maxJointVelocity=1e4)
    free = mobility(client, body, [index])
    assert free[0, 0] * (HELD if held else inertia) == pytest.approx(1.0)
    loose = np.full((1, 1), 1.0 / inertia)
    motors = Motors([servo], np.ones(1), dt, loose)
    constant = inertia * servo.no_load_speed / servo.stall_torque
    ticks = int((seconds or max(0.6, 12.0 * constant)) / dt)
    speeds, torques = [], []
    for _ in range(ticks):
        state = client.getJointState(body, index)
        speed, torque = motors.drive(
            *(np.array([x]) for x in (target, state[0], state[1], state[3]))
        )
        client.setJointMotorControl2(
            body, index, VELOCITY_CONTROL, targetVelocity=speed[0], force=torque[0]
        )
        client.applyExternalTorque(body, index, (0.0, load, 0.0), WORLD_FRAME)
        client.stepSimulation()
        after = client.getJointState(body, index)
        speeds.append(after[1]), torques.append(after[3])
    client.disconnect()
    last = slice(-max(1, ticks // 4), None)
    return Reading(float(np.mean(speeds[last])), float(np.mean(torques[last])))


def loaded(client: BulletClient, tree: Tree) -> int:
    """A tree without feet, its first link fixed to the world."""
    sole = Sole(length=0.1, width=0.1, heel=0.05, height=0.05, kind="studs")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bench.urdf"
        file.write_text(urdf(tree, sole, ()), encoding="utf-8")
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        body = int(client.loadURDF(str(file), useFixedBase=True, flags=flags))
    for link in links(client, body):
        client.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0)
    return body


@pytest.mark.parametrize("name", SERVOS)
def test_a_free_joint_reaches_the_speed_without_load(name: str) -> None:
    servo = clean(name)
    for sign, inertia in product((1.0, -1.0), inertias(servo)):
        reading = bench(servo, inertia, target=sign * 1e5)
        full = sign * servo.no_load_speed * servo.supply / servo.voltage
        assert reading.speed == pytest.approx(full, rel=TOLERANCE)
        assert abs(reading.torque) <= TOLERANCE * servo.stall_torque


@pytest.mark.parametrize("name", SERVOS)
def test_at_speed_the_torque_lies_on_the_torque_speed_line(name: str) -> None:
    servo = clean(name)
    for share, inertia in product((0.2, 0.5), inertias(servo)):
        load = -share * torque_limit(servo)
        reading = bench(servo, inertia, target=1e5, load=load)
        line = servo.stall_torque * (1.0 - reading.speed / servo.no_load_speed)
        assert reading.torque == pytest.approx(-load, rel=TOLERANCE)
        assert line == pytest.approx(-load, rel=TOLERANCE)


@pytest.mark.parametrize("name", SERVOS)
def test_a_driven_joint_brakes_as_the_line_goes_on(name: str) -> None:
    """A load that turns the joint faster than it would turn alone."""
    servo = clean(name)
    load = 0.3 * torque_limit(servo)
    for inertia in inertias(servo):
        reading = bench(servo, inertia, target=1e5, load=load)
        line = servo.stall_torque * (1.0 - reading.speed / servo.no_load_speed)
        assert line == pytest.approx(-load, rel=TOLERANCE)


@pytest.mark.parametrize("name", SERVOS)
def test_at_rest_the_torque_is_that_of_the_position_error(name: str) -> None:
    servo = clean(name)
    stiffness = servo.stall_torque / servo.no_load_speed * servo.position_gain
    error = 0.5 * torque_limit(servo) / stiffness
    for inertia in inertias(servo):
        held = bench(servo, inertia, target=error, held=True)
        assert held.torque == pytest.approx(stiffness * error, rel=TOLERANCE)
        # And a load that nothing holds but the servo hangs at the error that answers it.
        hanging = bench(servo, inertia, target=error, load=-stiffness * error, seconds=1.5)
        assert hanging.torque == pytest.approx(stiffness * error, rel=TOLERANCE)
        assert abs(hanging.speed) <= TOLERANCE * servo.no_load_speed


@pytest.mark.parametrize("name", SERVOS)
def test_the_limit_is_reached_and_not_passed(name: str) -> None:
    servo = clean(name)
    for inertia in inertias(servo):
        held = bench(servo, inertia, target=1e3, held=True)
        assert held.torque == pytest.approx(torque_limit(servo), rel=TOLERANCE)


def test_the_law_does_not_hang_on_the_time_step() -> None:
    servo = clean("mx_64")
    load = -0.4 * torque_limit(servo)
    for inertia in inertias(servo):
        steps = (1e-3, 2e-3, 4e-3)
        speeds = [bench(servo, inertia, target=1e5, load=load, dt=dt).speed for dt in steps]
        np.testing.assert_allclose(speeds, speeds[0], rtol=TOLERANCE)


@pytest.mark.long
def test_no_shipped_robot_shakes_on_its_servos() -> None:
    """Standing still, torques settle: what shakes from tick to tick is under 2 % of the limit."""
    seen = set()
    for planned in plan(load_experiment("all_robots", ["seeds=1"])).trials():
        trial = planned.trial
        if trial.robot.name in seen:
            continue
        seen.add(trial.robot.name)
        horizon = replace(trial.horizon, time=0.5)
        log = simulate(replace(trial, horizon=horizon))
        torque = log.driven_table("torque")
        limits = np.array([limit for limit in log.header.torque_limits if limit > 0.0])
        # A tick that goes against the one before and the one after it is shaking, not motion.
        jump = np.diff(torque, axis=0) / limits
        shaking = np.minimum(np.abs(jump[1:]), np.abs(jump[:-1])) * (jump[1:] * jump[:-1] < 0.0)
        assert shaking.mean(axis=0).max() < 0.02, (trial.robot.name, shaking.mean(axis=0))
    assert len(seen) == 5
