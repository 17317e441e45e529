"""Bullet itself: a quiet import, a world, a robot in it. The one file that imports pybullet.

Facts about Bullet that decide correctness stand beside the calls they concern.

References:
    Bullet: Coumans and Bai, PyBullet, a Python module for physics simulation, 2016-2021.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gaitlab.errors import GaitlabError
from gaitlab.log import GRAVITY
from gaitlab.model import Robot, Vector, gantry_of, self_collision_of
from gaitlab.model.clearance import links_apart, lower_legs, shape_of
from gaitlab.model.urdf import SHELL, urdf

STDOUT, STDERR = 1, 2
# Groups of what meets what. Bullet lets two meet if either's mask has the other's group, so that a
# plane's mask has to leave the shells out as well.
GROUND, OTHERS, LEFT, RIGHT, LEFT_SHELL, RIGHT_SHELL = (1 << bit for bit in range(6))
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
MASS_TOLERANCE = 1e-6  # kg; Bullet has to carry exactly the mass that the robot states


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

VELOCITY_CONTROL, WORLD_FRAME = pybullet.VELOCITY_CONTROL, pybullet.WORLD_FRAME
POSITION_CONTROL, JOINT_GEAR = pybullet.POSITION_CONTROL, pybullet.JOINT_GEAR


def new_world(solver_iterations: int, gravity: Vector = (0.0, 0.0, -GRAVITY)) -> BulletClient:
    """A world of its own with gravity, in [m/s^2], and nothing in it."""
    with _quiet(STDOUT):
        client = BulletClient(pybullet.DIRECT)
    client.setGravity(*gravity)
    client.setPhysicsEngineParameter(
        numSolverIterations=solver_iterations,
        deterministicOverlappingPairs=1,
        enableConeFriction=1,
        enableFileCaching=0,  # files are cached by name otherwise
    )
    return client


def add_plane(client: BulletClient, z: float) -> int:
    """A level plane at a height in [m]; its friction is 1 because frictions multiply."""
    shape = client.createCollisionShape(pybullet.GEOM_PLANE)
    plane = client.createMultiBody(0, shape, basePosition=[0.0, 0.0, z])
    client.changeDynamics(plane, -1, lateralFriction=1.0)
    client.setCollisionFilterGroupMask(plane, -1, GROUND, OTHERS | LEFT | RIGHT)
    return int(plane)


def place_base(
    client: BulletClient, body: int, position: Sequence[float], quaternion: Sequence[float]
) -> None:
    """Put a robot where its trunk link frame is so, in [m] and xyzw.

    Bullet's base pose is that of the principal axes of inertia in the centre of mass.
    """
    local, principal = client.getDynamicsInfo(body, -1)[3:5]
    if principal == UPRIGHT:
        centre, _ = client.multiplyTransforms(position, quaternion, local, UPRIGHT)
        turned = quaternion
    else:
        centre, turned = client.multiplyTransforms(position, quaternion, local, principal)
    client.resetBasePositionAndOrientation(body, centre, turned)


def turn_of_principal_axes(client: BulletClient, body: int) -> tuple[float, ...] | None:
    """From the trunk's principal axes to its link frame, xyzw; None where they are parallel."""
    x, y, z, w = client.getDynamicsInfo(body, -1)[4]
    return None if (x, y, z, w) == UPRIGHT else (-x, -y, -z, w)


def links(client: BulletClient, body: int) -> range:
    """Link indices of a body, the base (-1) included."""
    return range(-1, client.getNumJoints(body))


def add_robot(client: BulletClient, robot: Robot, friction: float) -> int:
    """The robot, undamped and with its motors off.

    Raises:
        GaitlabError: If Bullet's robot weighs other than the robot should.
    """
    body = _load(client, robot)
    for link in links(client, body):
        # Two calls: a link's friction is dropped without a word when damping comes with it.
        client.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0)
        client.changeDynamics(body, link, lateralFriction=friction)
        if link >= 0:  # Bullet drives every joint of a loaded robot to rest unless told not to
            client.setJointMotorControl2(body, link, VELOCITY_CONTROL, force=0.0)
    return body


def _load(client: BulletClient, robot: Robot) -> int:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{robot.name}.urdf"
        hung = gantry_of(robot) != "none"
        tree = robot.tree
        shells = {foot: shape_of(robot, tree.index(foot)) for foot in robot.feet}
        text = urdf(tree, robot.sole, robot.feet, on_gantry=hung, shells=shells)
        file.write_text(text, encoding="utf-8")
        # Without the second flag no link of a body ever meets another, whatever its groups say.
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION
        body = int(client.loadURDF(str(file), flags=flags, useFixedBase=hung))
    mass = sum(client.getDynamicsInfo(body, link)[0] for link in links(client, body))
    if abs(mass - robot.tree.mass) > MASS_TOLERANCE:
        raise GaitlabError(f"Bullet loaded {mass} kg, the robot has {robot.tree.mass} kg")
    return body


def let_legs_meet(
    client: BulletClient, body: int, robot: Robot, found: Indices, joints: np.ndarray
) -> None:
    """Which links of a robot meet: its lower legs each other, and all but the shells the ground.

    With the robot's option `self_collision` also any two links that are apart where it starts, at
    `joints`, in [rad].
    """
    tree = robot.tree
    # The trunk is the base, or what the gantry's last joint carries.
    index = {link.name: found.link.get(link.name, -1) for link in tree.links}
    for link in links(client, body):
        client.setCollisionFilterGroupMask(body, link, OTHERS, GROUND)
    other_leg = (RIGHT | RIGHT_SHELL, LEFT | LEFT_SHELL)
    for side, leg in enumerate(lower_legs(robot)):
        for name in (tree.links[k].name for k in leg):
            if name not in robot.feet:
                mask = GROUND | other_leg[side]
                client.setCollisionFilterGroupMask(body, index[name], (LEFT, RIGHT)[side], mask)
        shell = index[robot.feet[side]] = found.link[f"{robot.feet[side]}{SHELL}"]
        group = (LEFT_SHELL, RIGHT_SHELL)[side]
        client.setCollisionFilterGroupMask(body, shell, group, other_leg[side])
    if not self_collision_of(robot):
        return
    for first, second in links_apart(robot, joints):
        pair = (index[tree.links[first].name], index[tree.links[second].name])
        client.setCollisionFilterPair(body, body, *pair, 1)


class Indices(NamedTuple):
    """Bullet's indices of the parts of a body.

    Attributes:
        joint: Index of every joint by name, those of a gantry among them.
        link: Index of every link by name, but for the base.
    """

    joint: Mapping[str, int]
    link: Mapping[str, int]


def indices(client: BulletClient, body: int) -> Indices:
    """Indices of a body's joints and links."""
    info = [client.getJointInfo(body, index) for index in range(client.getNumJoints(body))]
    joint = {row[1].decode(): index for index, row in enumerate(info)}
    return Indices(joint, {row[12].decode(): index for index, row in enumerate(info)})


def mobility(client: BulletClient, body: int, joints: Sequence[int]) -> np.ndarray:
    """Inverse of a body's mass matrix in its present pose, at some of its joints.

    How fast joints start to turn, in [rad/s], under unit impulses on them, in [N m s], while all
    others are free. Gears and contacts are left out, so it is the most it can be.

    Args:
        client: The world.
        body: The robot.
        joints: Bullet's indices of the joints that are looked at.

    Returns:
        In [1/(kg m^2)]. Shape (joints, joints).
    """
    info = (client.getJointInfo(body, index) for index in range(client.getNumJoints(body)))
    moving = [row[0] for row in info if row[2] != pybullet.JOINT_FIXED]
    angles = [client.getJointState(body, index)[0] for index in moving]
    mass = np.array(client.calculateMassMatrix(body, angles))
    # The six of a free base come first.
    at = len(mass) - len(moving) + np.array([moving.index(joint) for joint in joints], dtype=int)
    inverse: np.ndarray = np.linalg.inv(mass)[np.ix_(at, at)]
    return inverse
