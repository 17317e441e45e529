"""ZMP of a walk as it is planned: point masses that follow the commanded joints exactly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.body import Robot
from gaitlab.log import GRAVITY
from gaitlab.motion import Gait


class PlannedZmp(NamedTuple):
    """A planned step on the left foot, from the middle between the feet and its ankle, in [m].

    Attributes:
        furthest_out: Largest y of the ZMP, from the line midway between the feet.
        hindmost: Smallest x of the ZMP from the standing ankle.
        foremost: Largest x of it.
        com_out: Largest y of the centre of mass.
    """

    furthest_out: float
    hindmost: float
    foremost: float
    com_out: float


def planned_zmp(robot: Robot, gait: Gait, samples: int = 200) -> PlannedZmp:
    """ZMP of the first full-amplitude step, from central differences; derived here.

    Args:
        robot: The robot.
        gait: A gait whose phase 0 starts a step on the left foot.
        samples: Instants a step.
    """
    dt = gait.gait_period / 2.0 / samples
    t = gait.startup_time + gait.gait_period + np.arange(-1, samples + 2) * dt
    feet = gait.feet(t)
    # The standing foot jumps to the other side at an exchange: count from the left sole, which
    # is the standing one in the step and the one that has just landed or lifts around it.
    left = _left_sole(feet.position[:, 0], feet.swing[:, 0])
    trunk = np.array([0.0, 0.0, robot.hip_offset()]) - left
    joints = robot.joint_targets(feet)
    poses = robot.tree.poses(trunk, np.tile(np.eye(3), (len(t), 1, 1)), joints)
    zmp = _zmp(robot, poses.position, poses.rotation, dt)
    half = 0.5 * abs(feet.position[0, 0, 1] - feet.position[0, 1, 1])
    out = robot.tree.centre_of_mass(poses)[1:-1, 1] + half
    return PlannedZmp(
        float(zmp[:, 1].max() + half),
        float(zmp[:, 0].min()),
        float(zmp[:, 0].max()),
        float(out.max()),
    )


def _left_sole(position: np.ndarray, swing: np.ndarray) -> np.ndarray:
    """Left sole seen from the hips, held to the ground in the instants when it swings."""
    standing = position.copy()
    standing[swing, 2] = position[~swing, 2][0]
    return standing


def _zmp(robot: Robot, position: np.ndarray, rotation: np.ndarray, dt: float) -> np.ndarray:
    """ZMP on the ground of the links as point masses, in [m]. Shape (n - 2, 2)."""
    mass = np.array([link.mass for link in robot.tree.links])[:, None]
    centre = np.array([link.box.centre for link in robot.tree.links])
    at = position + np.einsum("nlij,lj->nli", rotation, centre)
    acceleration = (at[2:] - 2.0 * at[1:-1] + at[:-2]) / dt**2
    now, lift = at[1:-1], acceleration[..., 2:] + GRAVITY
    moment = (mass * (lift * now[..., :2] - now[..., 2:] * acceleration[..., :2])).sum(axis=1)
    total: np.ndarray = moment / (mass * lift).sum(axis=1)
    return total
