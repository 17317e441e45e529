"""What the servos are sent: inverse kinematics of the feet, and what the gait sets itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.model import Robot, require_limits
from gaitlab.model.gait import FeetPoses, Gait
from gaitlab.model.servo import Servo
from gaitlab.plugins import suggestion


@runtime_checkable
class JointGait(Protocol):
    """A gait that says where the joints shall be; where the feet are then, its robot says.

    It has `feet_on` in the place of a gait's `feet`, and a `hip_height` of 0 if that, too, follows
    from the joints.
    """

    def feet_on(self, robot: Robot, t: np.ndarray) -> FeetPoses:
        """Foot poses and joints that a robot is commanded at the instants t, in [s]. Shape (n,).

        All of a robot's joints are among `joints`.
        """


def feet_of(gait: Gait | JointGait, robot: Robot, t: np.ndarray) -> FeetPoses:
    """What a gait means a robot's feet to do at the instants t, in [s]. Shape (n,)."""
    return gait.feet_on(robot, t) if isinstance(gait, JointGait) else gait.feet(t)


def hip_height_of(gait: Gait, robot: Robot) -> float:
    """Height of the hip axes over the lower sole as a robot starts to walk, in [m]."""
    if not isinstance(gait, JointGait) or gait.hip_height:
        return gait.hip_height
    return -float(gait.feet_on(robot, np.array([gait.startup_time])).position[0, :, 2].min())


@runtime_checkable
class Particular(Protocol):
    """A gait that does not suit every robot, and says so before anything runs."""

    def require_playable(self, robot: Robot, servos: Sequence[Servo]) -> None:
        """Refuse a robot that cannot walk it; servos come in the order of the robot's tree.

        Raises:
            GaitlabError: What stands in the way.
        """


def require_playable(gait: Gait, robot: Robot, servos: Sequence[Servo]) -> None:
    """Refuse a gait that the robot cannot walk, if the gait can tell.

    Raises:
        GaitlabError: What stands in the way.
    """
    if isinstance(gait, Particular):
        gait.require_playable(robot, servos)


def joint_commands(robot: Robot, feet: FeetPoses) -> np.ndarray:
    """Joint positions of a whole gait, in [rad]. Shape (n, joints in the tree's order).

    Raises:
        Infeasible: If a foot is out of reach, a joint beyond its limit, or the robot lacks a joint
            that the gait sets.
    """
    given = feet.joints
    if given and all(joint.name in given for joint in robot.tree.joints):
        commands = np.stack([given[joint.name] for joint in robot.tree.joints], axis=-1)
        require_limits("gait", robot.tree.joints, commands)
        return commands
    targets = robot.joint_targets(feet)
    if not given:
        return targets
    column = {joint.name: index for index, joint in enumerate(robot.tree.joints)}
    commands = targets.copy()
    for name, position in given.items():
        if name not in column:
            reason = f"the robot has no joint called {name!r}{suggestion(name, column)}"
            raise Infeasible(limb=name, tick=0, reason=reason)
        commands[:, column[name]] = position
    set_joints = [robot.tree.joints[column[name]] for name in given]
    require_limits("gait", set_joints, np.stack(list(given.values()), axis=-1))
    return commands
