"""Bullet's own window, in which a recorded robot is shown; nothing is simulated in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from gaitlab.model import Robot, gantry_of
from gaitlab.simulation.bullet.world import BulletClient, add_robot, indices, place_base
from gaitlab.surfaces.surface import Surface

GREEN, GREY = (0.35, 0.55, 0.25, 0.45), (0.75, 0.72, 0.66, 1.0)
LENGTH, WIDTH = 8.0, 1.0  # m, of the ground that is shown
TILT, TURN = -12.0, 35.0  # degrees, as Bullet's camera wants them
NEAR = 3.0  # robot heights from the camera to the robot


class Window:
    """A window with a robot on a surface. Bullet ends the process if there is no screen."""

    def __init__(self, robot: Robot, surface: Surface, height: float) -> None:
        """Takes the robot, its ground, and the trunk's standing height in [m]."""
        self._client = BulletClient(pybullet.GUI)
        self._client.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0)
        self._slab(-0.02, 0.0, GREY)
        if surface.height > 0.0:
            self._slab(0.0, surface.height, GREEN)
        self._height, self._hung = height, gantry_of(robot) != "none"
        self._body = add_robot(self._client, robot, 1.0)
        found = indices(self._client, self._body)
        self._joints = [found.joint[joint.name] for joint in robot.tree.joints]
        rig = ("gantry_x", "gantry_z") if self._hung else ()
        self._rig = [found.joint[name] for name in rig]

    @property
    def open(self) -> bool:
        """Whether nobody has closed it."""
        return bool(self._client.isConnected())

    def show(self, position: np.ndarray, quaternion: np.ndarray, joints: Sequence[float]) -> None:
        """Put the robot there: trunk link frame in [m], xyzw, joints in [rad]."""
        client = self._client
        for index, angle in zip(self._joints, joints, strict=True):
            client.resetJointState(self._body, index, float(angle))
        if self._hung:
            for index, at in zip(self._rig, (position[0], position[2]), strict=True):
                client.resetJointState(self._body, index, float(at))
        else:
            place_base(client, self._body, position.tolist(), quaternion.tolist())
        target = [float(position[0]), float(position[1]), self._height]
        client.resetDebugVisualizerCamera(NEAR * self._height, TURN, TILT, target)

    def _slab(self, bottom: float, top: float, colour: tuple[float, ...]) -> None:
        half = [0.5 * LENGTH, 0.5 * WIDTH, 0.5 * (top - bottom)]
        shape = self._client.createVisualShape(
            pybullet.GEOM_BOX, halfExtents=half, rgbaColor=colour
        )
        self._client.createMultiBody(0, -1, shape, [0.0, 0.0, 0.5 * (top + bottom)])
