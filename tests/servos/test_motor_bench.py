"""Every shipped servo on a bench, in each engine: one joint that it turns, a load on it, no robot.

The bench asks what the servo's file claims: torque at rest, torque at speed, the limit, the speed
without load; for a link as light as a finger and one as heavy as a leg, at three time steps.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.model import Box, Gantry, Joint, Link, Tree, standing
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineName, EngineSettings
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
from gaitlab.simulation.mujoco.engine import MujocoEngine
from gaitlab.simulation.simulate import simulate
from gaitlab.surfaces.files import load_surface
from tests.driven import drive, each_engine
from tests.ground.bench import STILL

SERVOS = tuple(names("servo"))
RATIOS = (0.05, 1.0, 15.0, 60.0)  # damping dt / inertia at 2 ms; no shipped joint has more than 50
HELD = 1e6  # kg m^2
HEAVY = 1e4  # kg m^2, which no servo moves in a tenth of a second
HIGH = 500.0  # m
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
    engine: EngineName = "bullet",
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
        engine: Which one turns it.
    """
    constant = inertia * servo.no_load_speed / servo.stall_torque
    ticks = int((seconds or max(0.6, 12.0 * constant)) / dt)
    if engine == "mujoco":
        turned = in_mujoco(servo, inertia, target, load, held, dt, ticks)
    else:
        turned = in_bullet(servo, inertia, target, load, held, dt, ticks)
    return Reading(*turned[-max(1, ticks // 4) :].mean(axis=0).tolist())


def in_mujoco(
    servo: Servo, inertia: float, target: float, load: float, held: bool, dt: float, ticks: int
) -> np.ndarray:
    """Speed and torque of each tick; nothing but the trial's own loop. Shape (ticks, 2)."""
    axles = Axles(HEAVY if held else inertia)
    ticks = min(ticks, 50) if held else ticks
    targets = np.full((ticks, 2), target)
    start = standing(axles, np.zeros(2), gap=HIGH)._replace(targets=targets[0])
    engine = MujocoEngine(
        axles, load_surface("hard_floor"), (servo, servo), start=start,
        settings=EngineSettings(name="mujoco", dt=dt), spread=STILL, seed=0,
    )  # fmt: skip
    engine._data.qfrc_applied[3:] = load
    return drive(engine, targets, gantry=True).joints[:, 1:, 0]


@dataclass(frozen=True)
class Axles:
    """Two links that turn about their centres on a stand that a gantry keeps level, falling."""

    inertia: float
    gantry: Gantry = "level"
    name: str = "axles"
    feet: tuple[str, str] = ("left_link", "right_link")
    sole: Sole = Sole(length=0.1, width=0.1, heel=0.05, height=0.05, kind="studs")  # noqa: RUF009

    @cached_property
    def tree(self) -> Tree:
        cube = Box(size=(0.1, 0.1, 0.1), centre=(0.0, 0.0, 0.0))
        stand = Link(
            name="stand", parent=None, origin=(0.0, 0.0, 0.0), joint=None, mass=1.0, box=cube,
        )  # fmt: skip
        links = [
            Link(
                name=name, parent="stand", origin=(0.0, y, 0.0), mass=1.0, box=cube,
                joint=Joint(name=f"{name}_axle", axis="y", lower=-1e6, upper=1e6, servo="mx_64"),
                inertia=(self.inertia, self.inertia, self.inertia),
            )
            for name, y in zip(self.feet, (1.0, -1.0), strict=True)
        ]  # fmt: skip
        return Tree((stand, *links))

    def joint_targets(self, feet: object) -> np.ndarray:
        raise NotImplementedError

    def hip_offset(self) -> float:
        return 0.0


def in_bullet(
    servo: Servo, inertia: float, target: float, load: float, held: bool, dt: float, ticks: int
) -> np.ndarray:
    """Speed and torque of each tick. Shape (ticks, 2)."""
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
    turned = []
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
        turned.append((after[1], after[3]))
    client.disconnect()
    return np.array(turned)


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


@each_engine
@pytest.mark.parametrize("name", SERVOS)
def test_a_free_joint_reaches_the_speed_without_load(name: str, engine: EngineName) -> None:
    servo = clean(name)
    for sign, inertia in product((1.0, -1.0), inertias(servo)):
        reading = bench(servo, inertia, target=sign * 1e5, engine=engine)
        full = sign * servo.no_load_speed * servo.supply / servo.voltage
        assert reading.speed == pytest.approx(full, rel=TOLERANCE)
        assert abs(reading.torque) <= TOLERANCE * servo.stall_torque


@each_engine
@pytest.mark.parametrize("name", SERVOS)
def test_at_speed_the_torque_lies_on_the_torque_speed_line(name: str, engine: EngineName) -> None:
    servo = clean(name)
    for share, inertia in product((0.2, 0.5), inertias(servo)):
        load = -share * torque_limit(servo)
        reading = bench(servo, inertia, target=1e5, load=load, engine=engine)
        line = servo.stall_torque * (1.0 - reading.speed / servo.no_load_speed)
        assert reading.torque == pytest.approx(-load, rel=TOLERANCE)
        assert line == pytest.approx(-load, rel=TOLERANCE)


@each_engine
@pytest.mark.parametrize("name", SERVOS)
def test_a_driven_joint_brakes_as_the_line_goes_on(name: str, engine: EngineName) -> None:
    """A load that turns the joint faster than it would turn alone."""
    servo = clean(name)
    load = 0.3 * torque_limit(servo)
    for inertia in inertias(servo):
        reading = bench(servo, inertia, target=1e5, load=load, engine=engine)
        line = servo.stall_torque * (1.0 - reading.speed / servo.no_load_speed)
        assert line == pytest.approx(-load, rel=TOLERANCE)


@each_engine
@pytest.mark.parametrize("name", SERVOS)
def test_at_rest_the_torque_is_that_of_the_position_error(name: str, engine: EngineName) -> None:
    servo = clean(name)
    stiffness = servo.stall_torque / servo.no_load_speed * servo.position_gain
    error = 0.5 * torque_limit(servo) / stiffness
    for inertia in inertias(servo):
        held = bench(servo, inertia, target=error, held=True, engine=engine)
        assert held.torque == pytest.approx(stiffness * error, rel=TOLERANCE)
        # And a load that nothing holds but the servo hangs at the error that answers it.
        load = -stiffness * error
        hanging = bench(servo, inertia, target=error, load=load, seconds=1.5, engine=engine)
        assert hanging.torque == pytest.approx(stiffness * error, rel=TOLERANCE)
        assert abs(hanging.speed) <= TOLERANCE * servo.no_load_speed


@each_engine
@pytest.mark.parametrize("name", SERVOS)
def test_the_limit_is_reached_and_not_passed(name: str, engine: EngineName) -> None:
    servo = clean(name)
    for inertia in inertias(servo):
        held = bench(servo, inertia, target=1e3, held=True, engine=engine)
        assert held.torque == pytest.approx(torque_limit(servo), rel=TOLERANCE)


@each_engine
def test_the_law_does_not_hang_on_the_time_step(engine: EngineName) -> None:
    servo = clean("mx_64")
    load = -0.4 * torque_limit(servo)
    for inertia in inertias(servo):
        steps = (1e-3, 2e-3, 4e-3)
        turning = (
            bench(servo, inertia, target=1e5, load=load, dt=dt, engine=engine) for dt in steps
        )
        speeds = [reading.speed for reading in turning]
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
