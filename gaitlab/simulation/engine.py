"""A robot on its servos and its ground, commanded and read tick by tick.

One world is built per trial and thrown away, so that equal trials give equal logs, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model import Robot, Start, couplings_of, gantry_of
from gaitlab.model.randomness import randomness
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineSettings, Spread
from gaitlab.servos.bank import ServoBank, steps_in, unequally_late
from gaitlab.simulation.bullet import (
    VELOCITY_CONTROL,
    Indices,
    add_plane,
    add_robot,
    indices,
    let_legs_meet,
    mobility,
    new_world,
    place_base,
    turn_of_principal_axes,
)
from gaitlab.simulation.couplings import add_couplings
from gaitlab.simulation.gantry import Rig
from gaitlab.simulation.grass import PileUnderFeet, add_layer
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile

NONE, ORIGIN = ((0.0, 0.0), (0.0, 0.0)), (0.0, 0.0, 0.0)
SLOP = 1e-5  # m, by which Bullet lets bodies overlap; put down without it they fall for a tick


class TickState(NamedTuple):
    """The world at the end of a tick, as Bullet gives it.

    Attributes:
        position: Centre of mass of the trunk, in [m].
        quaternion: Orientation of the trunk, xyzw.
        velocity: Velocity of that centre, in [m/s].
        spin: Angular velocity of the trunk, world frame, in [rad/s].
        joints: Position [rad], velocity [rad/s] and torque [N m] of each joint, the pitch of a
            gantry last. Shape (3, joints).
        contacts: Bullet's contact points with the ground, as its getContactPoints returns them. The
            robot is body A: link in field 3, point in 5, normal force up in 9, friction on it in 10
            to 13.
    """

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    velocity: tuple[float, float, float]
    spin: tuple[float, float, float]
    joints: np.ndarray
    contacts: Sequence[tuple]


class Engine:
    """A robot standing on a surface, ready to be commanded tick by tick.

    Attributes:
        feet: Bullet's link indices of the left and the right foot.
    """

    def __init__(
        self,
        robot: Robot,
        surface: Surface,
        servos: Sequence[Servo],
        *,
        start: Start,
        settings: EngineSettings,
        spread: Spread,
        seed: int,
    ) -> None:
        """Build the world.

        Args:
            robot: The robot.
            surface: The ground.
            servos: One per driven joint, in the order of the robot's tree.
            start: Where the robot stands; on a pile it is lifted to where that carries it.
            settings: Time step and solver.
            spread: How far this replicate may differ from the nominal robot.
            seed: Seed of the replicate.
        """
        self._streams = randomness(seed)
        self._client = new_world(settings.solver_iterations)
        add_plane(self._client, 0.0)
        self._body = add_robot(self._client, robot, self._friction(surface, spread))
        found = indices(self._client, self._body)
        let_legs_meet(self._client, self._body, robot, found, start.joints)
        self._principal = turn_of_principal_axes(self._client, self._body)
        self._find(robot, found)
        kind = gantry_of(robot)
        self._rig = None if kind == "none" else Rig(self._client, self._body, found, kind)
        self._place(start, lift=-SLOP)
        gain = 1.0 + spread.servo_gain * self._streams.servo.uniform(-1.0, 1.0, len(servos))
        servos = unequally_late(servos, spread.servo_latency, self._streams.servo)
        loose = mobility(self._client, self._body, self._joints)
        tied = {name for gear in couplings_of(robot) for name in (gear.leader, gear.follower)}
        names = [joint.name for joint in robot.tree.joints if joint.servo is not None]
        geared = [k for k, name in enumerate(names) if name in tied]
        self._steps = steps_in(servos, loose, self._leg_joints(robot), geared, settings.dt)
        dt = settings.dt / self._steps
        self._client.setTimeStep(dt)
        add_couplings(self._client, self._body, couplings_of(robot), found.joint, dt=dt)
        self._servos = ServoBank(servos, gain, dt, start.targets[self._driven], loose)
        self._pile = self._grow(robot, surface, dt, spread)
        if self._pile is not None:
            sunk = self._pile.settle(robot.tree.mass * GRAVITY)
            self._place(start, lift=sunk - SLOP)
        self._now: np.ndarray | None = None
        self._target = start.targets[self._driven]
        self._spent: np.ndarray | float = 0.0
        self._bind()

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()

    @property
    def plough(self) -> Sequence[tuple[float, float]]:
        """Plough force on the left and the right foot in the last tick, world x and y, in [N]."""
        return NONE if self._pile is None else self._pile.plough

    @property
    def push(self) -> Sequence[tuple[float, float]]:
        """All that pushed the feet sideways beside the contacts in the last tick, likewise."""
        return NONE if self._pile is None else self._pile.push

    def _find(self, robot: Robot, found: Indices) -> None:
        """Bullet's indices of the feet, of all joints, and of those that servos drive."""
        left, right = (found.link[name] for name in robot.feet)
        self.feet = left, right
        self._all_joints = [found.joint[joint.name] for joint in robot.tree.joints]
        driven = np.flatnonzero(robot.tree.driven)
        self._joints = [self._all_joints[k] for k in driven]
        every = len(driven) == len(self._all_joints) and gantry_of(robot) == "none"
        self._driven: slice | np.ndarray = slice(None) if every else driven

    def _leg_joints(self, robot: Robot) -> list[int]:
        """Which of the driven joints carry the feet."""
        tree, chain = robot.tree, set[str]()
        for foot in robot.feet:
            link = tree.links[tree.index(foot)]
            while link.joint is not None and link.parent is not None:
                chain.add(link.joint.name)
                link = tree.links[tree.index(link.parent)]
        driven = [joint.name for joint in tree.joints if joint.servo is not None]
        return [k for k, name in enumerate(driven) if name in chain]

    def _friction(self, surface: Surface, spread: Spread) -> float:
        draw = 1.0 + spread.friction * self._streams.friction.uniform(-1.0, 1.0)
        return float(surface.friction * surface.friction_scale * draw)

    def _place(self, start: Start, lift: float) -> None:
        client, (joints, position, turn, _) = self._client, start
        x, y, z = position.tolist()
        for index, angle in zip(self._all_joints, joints, strict=True):
            client.resetJointState(self._body, index, float(angle))
        if self._rig is not None:
            self._rig.place(x, z + lift, 2.0 * float(np.arctan2(turn[1], turn[3])))
            return
        place_base(client, self._body, (x, y, z + lift), turn.tolist())

    def _grow(
        self, robot: Robot, surface: Surface, dt: float, spread: Spread
    ) -> PileUnderFeet | None:
        """What stands on the base; a rigid floor is the base itself."""
        if isinstance(surface, SoftLayer):
            add_layer(self._client, surface, len(robot.sole.supports()))
        if not isinstance(surface, TuftedPile | FibreMat):
            return None
        return PileUnderFeet(
            self._client,
            self._body,
            self.feet,
            robot,
            surface,
            dt=dt,
            irregularity=spread.terrain,
            rng=self._streams.terrain,
        )

    def _bind(self) -> None:
        """The Bullet calls of a tick, looked up once."""
        client = self._client
        self._step, self._motors = client.stepSimulation, client.setJointMotorControlArray
        self._joint_states, self._contact_points = client.getJointStates, client.getContactPoints
        self._base_pose = client.getBasePositionAndOrientation
        self._base_velocity = client.getBaseVelocity
        self._read = list(self._all_joints)
        if self._rig is not None:
            self._read.append(self._rig.pitch)

    def command(self, target: np.ndarray) -> None:
        """Send targets in [rad] to the servos; each acts after its latency. Shape (joints,)."""
        self._target = target[self._driven]

    def _drive(self) -> None:
        """What the servos do in the coming step of Bullet."""
        position, velocity, applied = self._read_joints()[:, self._driven]
        speed, torque = self._servos.drive(self._target, position, velocity, applied)
        self._motors(
            self._body, self._joints, VELOCITY_CONTROL, targetVelocities=speed, forces=torque
        )

    def _read_joints(self) -> np.ndarray:
        """Positions, velocities and torques of the joints, read from Bullet once a tick."""
        if self._now is None:
            states = self._joint_states(self._body, self._read)
            position, velocity, _, torque = zip(*states, strict=True)
            self._now = np.array((position, velocity, torque))
        return self._now

    def step(self) -> None:
        """Advance by one tick: servos drive, the pile pushes back, then Bullet solves.

        A tick that is too long for the servos is several steps; its torque is their mean.
        """
        self._spent = 0.0
        for _ in range(self._steps):
            self._drive()
            if self._pile is not None:
                self._pile.press()
            self._step()
            self._now = None
            if self._steps > 1:
                self._spent = self._spent + self._read_joints()[2] / self._steps

    def state(self) -> TickState:
        """The world as it is now."""
        joints, body = self._read_joints(), self._body
        if self._steps > 1 and isinstance(self._spent, np.ndarray):
            joints = np.array((joints[0], joints[1], self._spent))
        contacts = [point for point in self._contact_points(body) if point[2] != body]
        if self._rig is not None:
            return TickState(*self._rig.trunk(), joints, contacts)
        position, quaternion = self._base_pose(self._body)
        if self._principal is not None:
            _, quaternion = self._client.multiplyTransforms(
                ORIGIN, quaternion, ORIGIN, self._principal
            )
        velocity, spin = self._base_velocity(self._body)
        return TickState(position, quaternion, velocity, spin, joints, contacts)
