"""The physics engine: Bullet, a robot, its servos and the ground under it. Nothing else.

One world is built per trial and thrown away, so that equal trials give equal logs, bit for bit.
Facts about Bullet that decide correctness stand beside the calls they concern.

References:
    Bullet: Coumans and Bai, PyBullet, a Python module for physics simulation, 2016-2021.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gaitlab.body import Robot
from gaitlab.errors import GaitlabError
from gaitlab.log import GRAVITY
from gaitlab.randomness import randomness
from gaitlab.servos.bank import ServoBank
from gaitlab.servos.servo import Servo
from gaitlab.settings import EngineSettings, Spread
from gaitlab.surfaces.ground import Footprint, new_footprint, pile_for
from gaitlab.surfaces.press import press
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile
from gaitlab.urdf import urdf

STDOUT, STDERR = 1, 2


@contextmanager
def _quiet(*descriptors: int) -> Iterator[None]:
    """Bullet prints from C; what it says is kept off the program's own streams."""
    saved = {d: os.dup(d) for d in descriptors}
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for descriptor in descriptors:
            os.dup2(null, descriptor)
        yield
    finally:
        for descriptor, copy in saved.items():
            os.dup2(copy, descriptor)
            os.close(copy)
        os.close(null)


with _quiet(STDOUT, STDERR):
    import pybullet
    from pybullet_utils.bullet_client import BulletClient

PARKED = -1.0  # m, where a tangent plane waits while its foot is in the air
MASS_TOLERANCE = 1e-6  # kg; Bullet has to carry exactly the mass that the robot states


class TickState(NamedTuple):
    """The world at the end of a tick, as Bullet gives it.

    Attributes:
        position: Centre of mass of the trunk, in [m].
        quaternion: Orientation of the trunk, xyzw.
        velocity: Velocity of that centre, in [m/s].
        spin: Angular velocity of the trunk, world frame, in [rad/s].
        joints: Position [rad], velocity [rad/s] and torque [N m] of each joint. Shape (3, joints).
        contacts: Bullet's contact points, as its getContactPoints returns them. The robot is
            body A: link in field 3, point in 5, normal force up in 9, friction on it in 10 to 13.
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
        plough: Plough force on the left and the right foot in the last tick, world x and y, [N].
    """

    def __init__(
        self,
        robot: Robot,
        surface: Surface,
        servos: Sequence[Servo],
        *,
        pose: np.ndarray,
        height: float,
        settings: EngineSettings,
        spread: Spread,
        seed: int,
    ) -> None:
        """Build the world.

        Args:
            robot: The robot.
            surface: The ground.
            servos: One per joint, in the order of the robot's tree.
            pose: First joint positions, in [rad]. Shape (joints,).
            height: First height of the trunk link frame, in [m].
            settings: Time step and solver.
            spread: How far this replicate may differ from the nominal robot.
            seed: Seed of the replicate.
        """
        self._dt = settings.dt
        with _quiet(STDOUT):
            self._client = BulletClient(pybullet.DIRECT)
        self._streams = randomness(seed)
        self._world(settings)
        self._body = self._load(robot)
        self._joints, self.feet = self._indices(robot)
        self._place(pose, height, spread)
        self._touch(robot, surface, spread)
        gain = 1.0 + spread.servo_gain * self._streams.servo.uniform(-1.0, 1.0, len(servos))
        self._servos = ServoBank(servos, gain, settings.dt, pose)
        self._now: np.ndarray | None = None
        self._bind(robot, surface, spread)

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()

    def _world(self, settings: EngineSettings) -> None:
        client = self._client
        client.setGravity(0.0, 0.0, -GRAVITY)
        client.setTimeStep(settings.dt)
        client.setPhysicsEngineParameter(
            numSolverIterations=settings.solver_iterations,
            deterministicOverlappingPairs=1,
            enableConeFriction=1,
            enableFileCaching=0,  # files are cached by name otherwise
        )
        self._base = self._plane(0.0)

    def _plane(self, z: float) -> int:
        shape = self._client.createCollisionShape(pybullet.GEOM_PLANE)
        plane = self._client.createMultiBody(0, shape, basePosition=[0.0, 0.0, z])
        self._client.changeDynamics(plane, -1, lateralFriction=1.0)  # frictions multiply
        return int(plane)

    def _load(self, robot: Robot) -> int:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"{robot.name}.urdf"
            file.write_text(urdf(robot.tree, robot.sole, robot.feet))
            body = self._client.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        links = range(-1, self._client.getNumJoints(body))
        mass = sum(self._client.getDynamicsInfo(body, link)[0] for link in links)
        if abs(mass - robot.tree.mass) > MASS_TOLERANCE:
            raise GaitlabError(f"Bullet loaded {mass} kg, the robot has {robot.tree.mass} kg")
        return int(body)

    def _indices(self, robot: Robot) -> tuple[list[int], tuple[int, int]]:
        by_joint, by_link = {}, {}
        for index in range(self._client.getNumJoints(self._body)):
            info = self._client.getJointInfo(self._body, index)
            by_joint[info[1].decode()], by_link[info[12].decode()] = index, index
        left, right = (by_link[name] for name in robot.feet)
        return [by_joint[joint.name] for joint in robot.tree.joints], (left, right)

    def _place(self, pose: np.ndarray, height: float, spread: Spread) -> None:
        rng = self._streams.pose
        tilt = spread.tilt * rng.uniform(-1.0, 1.0, 2)
        offset = spread.position * rng.uniform(-1.0, 1.0, 2)
        for index, angle in zip(self._joints, pose, strict=True):
            self._client.resetJointState(self._body, index, float(angle))
        turn = self._client.getQuaternionFromEuler([*tilt, 0.0])
        local = self._client.getDynamicsInfo(self._body, -1)[3]
        # Bullet's base pose is that of the centre of mass; the robot turns about its link frame.
        centre, _ = self._client.multiplyTransforms(
            [*offset, height], turn, local, [0.0, 0.0, 0.0, 1.0]
        )
        self._client.resetBasePositionAndOrientation(self._body, centre, turn)

    def _touch(self, robot: Robot, surface: Surface, spread: Spread) -> None:
        draw = 1.0 + spread.friction * self._streams.friction.uniform(-1.0, 1.0)
        friction = surface.friction * surface.friction_scale * draw
        for link in range(-1, self._client.getNumJoints(self._body)):
            # Two calls: a link's friction is dropped without a word when damping comes with it.
            self._client.changeDynamics(self._body, link, linearDamping=0.0, angularDamping=0.0)
            self._client.changeDynamics(self._body, link, lateralFriction=friction)
            # Bullet drives every joint of a loaded robot to rest unless told not to.
            if link >= 0:
                self._client.setJointMotorControl2(
                    self._body, link, pybullet.VELOCITY_CONTROL, force=0.0
                )

    def _bind(self, robot: Robot, surface: Surface, spread: Spread) -> None:
        """Ground of this surface, and the handful of Bullet calls that a tick makes."""
        client = self._client
        self._step, self._motors = client.stepSimulation, client.setJointMotorControlArray
        self._joint_states, self._link_states = client.getJointStates, client.getLinkStates
        self._contact_points = client.getContactPoints
        self._base_pose, self._base_velocity = (
            client.getBasePositionAndOrientation,
            client.getBaseVelocity,
        )
        self._move_plane, self._soften = (
            client.resetBasePositionAndOrientation,
            client.changeDynamics,
        )
        self._push, self._twist = client.applyExternalForce, client.applyExternalTorque
        self.plough = [(0.0, 0.0), (0.0, 0.0)]
        self._soles: list[tuple[int, int, Footprint]] = []
        supports = len(robot.sole.supports())
        if isinstance(surface, SoftLayer):
            self._layer(surface, supports)
        elif isinstance(surface, TuftedPile | FibreMat):
            self._pile = pile_for(
                surface,
                robot.sole,
                weight=robot.tree.mass * GRAVITY,
                foot_mass=robot.tree.links[robot.tree.index(robot.feet[0])].mass,
                dt=self._dt,
                rng=self._streams.terrain,
                irregularity=spread.terrain,
            )
            self._soles = [
                (foot, self._own_plane(foot), new_footprint(supports)) for foot in self.feet
            ]

    def _layer(self, surface: SoftLayer, supports: int) -> None:
        plane = self._plane(surface.height)
        # Bullet's stiffness and damping hold per contact point and only when given together.
        self._client.changeDynamics(
            plane,
            -1,
            contactStiffness=surface.stiffness / supports,
            contactDamping=surface.damping / supports,
        )

    def _own_plane(self, foot: int) -> int:
        """A plane that only this foot meets."""
        plane = self._plane(PARKED)
        for link in range(-1, self._client.getNumJoints(self._body)):
            if link != foot:
                self._client.setCollisionFilterPair(self._body, plane, link, -1, 0)
        return plane

    def command(self, target: np.ndarray) -> None:
        """Send targets in [rad] to the servos; each acts after its latency. Shape (joints,)."""
        position, velocity, _ = self._read_joints()
        speed, torque = self._servos.drive(target, position, velocity)
        self._motors(
            self._body,
            self._joints,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speed,
            forces=torque,
        )

    def _read_joints(self) -> np.ndarray:
        """Positions, velocities and torques of the joints, read from Bullet once a tick."""
        if self._now is None:
            states = self._joint_states(self._body, self._joints)
            position, velocity, _, torque = zip(*states, strict=True)
            self._now = np.array((position, velocity, torque))
        return self._now

    def step(self) -> None:
        """Advance by one tick: the pile pushes back, then Bullet solves."""
        if self._soles:
            self._press()
        self._step()
        self._now = None

    def _press(self) -> None:
        # Without forward kinematics Bullet's link states are one step stale: negative damping.
        states = self._link_states(self._body, self.feet, 1, 1)
        for side, ((foot, plane, footprint), state) in enumerate(
            zip(self._soles, states, strict=True)
        ):
            centre, _, _, _, origin, quaternion, velocity, spin = state
            support = press(
                self._pile, footprint, origin, quaternion, centre, velocity, spin, self._dt
            )
            tilt_x, tilt_y = support.tilt
            self._move_plane(plane, support.point, (tilt_x / 2.0, tilt_y / 2.0, 0.0, 1.0))
            self.plough[side] = support.force
            if not support.active:
                continue
            self._soften(
                plane,
                -1,
                contactStiffness=support.stiffness,
                contactDamping=self._pile.relaxation_time * support.stiffness,
            )
            if support.force != (0.0, 0.0):
                world = pybullet.WORLD_FRAME
                self._push(self._body, foot, (*support.force, 0.0), centre, world)
                self._twist(self._body, foot, support.torque, world)

    def state(self) -> TickState:
        """The world as it is now."""
        position, quaternion = self._base_pose(self._body)
        velocity, spin = self._base_velocity(self._body)
        return TickState(
            position,
            quaternion,
            velocity,
            spin,
            self._read_joints(),
            self._contact_points(self._body),
        )
