"""How a robot stands when it is about to walk, and the natural measures that its walk scales with.

Knees bent so that hip and ankle are some 0.92 of the leg's length apart, soles as far apart as at
zero angles, the centre of mass over the middle of the soles. A robot's natural period is that of a
pendulum as long as its centre of mass is high, its sway that of a linear inverted pendulum which
steps in place [Kajita2001].

References:
    Kajita2001: Kajita, Kanehiro, Kaneko, Yokoi and Hirukawa, The 3D linear inverted pendulum mode,
        IEEE/RSJ International Conference on Intelligent Robots and Systems, 2001.
"""

from __future__ import annotations

from math import cosh, pi, sqrt
from typing import NamedTuple

import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model.gait import FeetPoses
from gaitlab.model.robot import Robot
from gaitlab.model.tree import Link, LinkPoses, unit_axis

EXTENSION = 0.92  # of thigh and shank, from hip to ankle
EXTENSIONS = (EXTENSION, 0.88, 0.84, 0.8, 0.95, 0.97)  # that are tried, the first that leaves room
PITCHES = 0.9  # of an axis along the lateral one
GAP = 0.01  # m between the soles, at least
ROUNDS = 8  # of putting the centre of mass over the soles
SETTLED = 1e-5  # m


class Stance(NamedTuple):
    """A robot that stands, ready to walk.

    Attributes:
        leg_length: From the hip to the sole of a straight leg, in [m].
        hip_height: Of the hips over the soles, in [m].
        step_width: Between the ankles, in [m].
        com_offset: Of the hips ahead of the ankles, in [m].
        com_height: Of the centre of mass over the soles, in [m].
        sole_apart: Between the centres of the soles, in [m].
    """

    leg_length: float
    hip_height: float
    step_width: float
    com_offset: float
    com_height: float
    sole_apart: float

    @property
    def natural_period(self) -> float:
        """Of a pendulum as long as the centre of mass is high, in [s]."""
        return 2.0 * pi * sqrt(self.com_height / GRAVITY)

    def sway(self, period: float) -> float:
        """Of the centre of mass of a pendulum that steps in place in such a period, in [m].

        p (1 - 1 / cosh(omega T / 4)), p the soles' distance from the middle [Kajita2001].
        """
        omega = sqrt(GRAVITY / self.com_height)
        return 0.5 * self.sole_apart * (1.0 - 1.0 / cosh(omega * period / 4.0))


def stance_of(robot: Robot, extension: float = EXTENSION) -> Stance:
    """How a robot stands.

    Args:
        robot: The robot.
        extension: From hip to ankle, as a share of thigh and shank.

    Raises:
        Infeasible: If it cannot stand so.
    """
    zero = np.zeros((1, len(robot.tree.joints)))
    poses = robot.tree.poses(np.zeros((1, 3)), np.eye(3)[None], zero)
    ankle = poses.position[0, robot.tree.index(robot.feet[0])]
    hips = -robot.hip_offset()
    sole = robot.sole
    straight, bent, under = _lengths(robot, hips, poses, extension)
    across = max(2.0 * float(ankle[1]), sole.width + GAP - 2.0 * sole.outward)
    height, offset, com = bent + under, 0.0, 0.0
    middle = sole.centre_of(0)[0]
    for _ in range(ROUNDS):
        joints = robot.joint_targets(standing_feet(height, across, offset))
        here = robot.tree.poses(np.zeros((1, 3)), np.eye(3)[None], joints)
        com_x, _, com_z = robot.tree.centre_of_mass(here)[0]
        com = float(com_z) - hips + height
        wrong = float(com_x) + offset - middle
        offset -= wrong
        if abs(wrong) < SETTLED:
            break
    return Stance(straight + under, height, across, offset, com, across + 2.0 * sole.outward)


def standing_feet(hip_height: float, step_width: float, com_offset: float) -> FeetPoses:
    """Both feet level on the ground, over one instant."""
    sides = np.array([0.5, -0.5]) * step_width
    position = np.array([[[-com_offset, side, -hip_height] for side in sides]])
    still = np.zeros((1, 2))
    return FeetPoses(
        position=position,
        heading=still,
        trunk_pitch=np.zeros(1),
        ankle_pitch=still,
        knee_only=still,
        swing=np.zeros((1, 2), dtype=bool),
        phase=np.full(1, np.nan),
        step_index=np.full(1, -1),
    )


def _chain(robot: Robot) -> list[Link]:
    """Links of the left leg, from the hip down."""
    tree, chain = robot.tree, list[Link]()
    link = tree.links[tree.index(robot.feet[0])]
    while link.parent is not None:
        chain.insert(0, link)
        link = tree.links[tree.index(link.parent)]
    return chain


def _lengths(
    robot: Robot, hips: float, zero: LinkPoses, extension: float
) -> tuple[float, float, float]:
    """From hip to ankle of a straight and of a bent leg, and from there to the sole, in [m].

    A leg without three joints that pitch stays as it is at zero angles.

    Args:
        robot: The robot.
        hips: Height of the hips in the trunk's frame, in [m].
        zero: Poses of its links at zero angles.
        extension: Of the bent leg.
    """
    position, rotation = zero.position[0], zero.rotation[0]
    chain = [(robot.tree.index(link.name), link.joint) for link in _chain(robot)]
    foot = chain[-1][0]
    pitching = [
        position[k]
        for k, joint in chain
        if joint is not None and abs((rotation[k] @ unit_axis(joint.axis))[1]) > PITCHES
    ]
    if len(pitching) < 3:
        straight = hips - float(position[foot, 2])
        return straight, straight, robot.sole.height
    hip, knee, ankle = pitching[-3:]
    thigh, shank = (np.linalg.norm((b - a)[[0, 2]]) for a, b in ((hip, knee), (knee, ankle)))
    straight = float(thigh + shank)
    over = float(rotation[foot, :, 2] @ (ankle - position[foot]))
    return straight, extension * straight, over + robot.sole.height
