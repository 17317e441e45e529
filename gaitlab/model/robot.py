"""What gaitlab asks of a robot, what it may have beside that, and how it stands at the start."""

from __future__ import annotations

from typing import Literal, NamedTuple, Protocol

import numpy as np

from gaitlab.kinematics.transforms import axis_rotation, quaternion_of
from gaitlab.model.gait import FeetPoses
from gaitlab.model.soles import Sole
from gaitlab.model.tree import Coupling, Tree

Gantry = Literal["none", "planar", "level"]
GANTRY_PITCH = "gantry_pitch"  # what the joint is called that lets the trunk pitch or holds it


class Robot(Protocol):
    """A robot: a frozen dataclass called `Robot` in a file of its own in `gaitlab/robots`.

    It may have three more members. With `self_collision` true, arms, trunk and thighs collide with
    each other too, and not just the two lower legs. `couplings`, a tuple of `Coupling`, ties joints
    together; a joint that only follows has no servo. `gantry` is a rig that helps the robot to
    stand: `planar` holds it against lateral motion, roll and yaw, `level` against pitch too, and
    the log then carries the rig's joint `gantry_pitch`, whose torque is the balancing moment that
    the rig supplied.
    """

    @property
    def name(self) -> str:
        """Name of the file."""

    @property
    def feet(self) -> tuple[str, str]:
        """Names of the left and the right foot link."""

    @property
    def tree(self) -> Tree:
        """Links in file order, the trunk first."""

    @property
    def sole(self) -> Sole:
        """The sole of the left foot; the right one mirrors it."""

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, in [rad]. Shape (n, joints in tree's order).

        Raises:
            Infeasible: If a target is out of reach or beyond a joint limit; names the limb, the
                first such index, what was found and what is allowed.
        """

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""


def couplings_of(robot: Robot) -> tuple[Coupling, ...]:
    """Gears and belts of a robot; most have none."""
    couplings: tuple[Coupling, ...] = getattr(robot, "couplings", ())
    return couplings


def self_collision_of(robot: Robot) -> bool:
    """Whether links other than the lower legs collide with each other; most robots leave it off."""
    return bool(getattr(robot, "self_collision", False))


def gantry_of(robot: Robot) -> Gantry:
    """Rig that helps a robot to stand; `none` for a robot on its own."""
    gantry: Gantry = getattr(robot, "gantry", "none")
    return gantry


class Start(NamedTuple):
    """Where a robot starts.

    Attributes:
        joints: Positions of all joints, in [rad]. Shape (joints,).
        position: Trunk link frame, world frame, in [m]. Shape (3,).
        quaternion: Its orientation, xyzw. Shape (4,).
        targets: What the servos were sent before, in [rad]. Shape (joints,).
    """

    joints: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    targets: np.ndarray


def standing(robot: Robot, joints: np.ndarray, *, gap: float) -> Start:
    """A robot on level soles; its trunk leans as its joints say, and does not turn.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
        gap: Height of the soles over the base, in [m]; of the lower one should they differ.
    """
    at, here = np.array(joints, dtype=float), np.zeros((1, 3))
    feet = [robot.tree.index(foot) for foot in robot.feet]
    level = robot.tree.poses(here, np.eye(3)[None], at[None])
    upright = _levelling(level.rotation[0, feet, :, 2].mean(axis=0))
    soles = [
        level.position[0, k] + level.rotation[0, k] @ np.array(robot.sole.centre_of(side))
        for side, k in enumerate(feet)
    ]
    lowest = min(float(upright[2] @ sole) for sole in soles)
    return Start(at, np.array([0.0, 0.0, gap - lowest]), quaternion_of(upright), at)


def _levelling(normal: np.ndarray) -> np.ndarray:
    """The rotation without yaw that turns a direction upright. Shape (3, 3)."""
    x, y, z = normal
    roll = np.arctan2(y, z)
    return axis_rotation("y", -np.arctan2(x, np.hypot(y, z))) @ axis_rotation("x", roll)
