"""A leg known by nothing but the lines its joints turn about: forward and inverse kinematics.

No link frames and no Denavit-Hartenberg table: the axes of all joints as lines in space when every
angle is zero, and where the sole is then. Any order and direction of axes will do, five joints as
well as six, and where along its line a joint is drawn makes no difference. The forward map is the
product of exponentials [LynchPark2017, eq. 4.14], its Jacobian the space Jacobian at the sole
[LynchPark2017, eq. 5.11]; the inverse is found by damped least squares [Wampler1986], for all
instants at once.

References:
    LynchPark2017: Lynch and Park, Modern Robotics, Cambridge University Press, 2017.
    Wampler1986: Wampler, Manipulator inverse kinematic solutions based on vector formulations and
        damped least-squares methods, IEEE Transactions on Systems, Man and Cybernetics, 1986.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.transforms import vector_rotation

DAMPING = 1e-3  # m; far below what a leg's axes move its sole by a radian, so it slows nothing
LONGEST_STEP = 0.5  # rad in one iteration; linearised further a leg folds the wrong way
ITERATIONS = 60
SETTLED = 1e-12  # rad; a smaller step moves no sole by what a float can tell
TURN = 0.2  # m a radian: how far a wrong turn of the sole weighs beside a wrong place


class SolePoses(NamedTuple):
    """Poses of a sole in the frame of the axes: position (n, 3) in [m], rotation (n, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray


class LegSolution(NamedTuple):
    """What inverse kinematics found.

    Attributes:
        angles: Within the limits, in [rad]. Shape (n, joints).
        misplaced: Distance of the sole from where it should be, in [m]. Shape (n,).
        misturned: Angle by which it is turned wrongly, in [rad], turns that are not held left out.
            Shape (n,).
    """

    angles: np.ndarray
    misplaced: np.ndarray
    misturned: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class AxisLeg:
    """A chain of revolute joints from a body to its sole.

    Attributes:
        axes: Unit vectors along the joints' axes at zero angles, from the body down, in the body's
            frame. Shape (joints, 3).
        points: A point on each of these lines, in [m]. Shape (joints, 3).
        sole: Position of the sole at zero angles, in [m]. Shape (3,).
        rotation: Rotation of the sole at zero angles. Shape (3, 3).
        limits: Lower and upper angle of each joint, in [rad]; infinite where there is none. Shape
            (joints, 2).
        holds: Whether the leg holds the sole's roll, pitch and yaw; one of five joints leaves one
            of them over, and puts the sole in its place all the same.
    """

    axes: np.ndarray
    points: np.ndarray
    sole: np.ndarray
    rotation: np.ndarray
    limits: np.ndarray
    holds: tuple[bool, bool, bool] = (True, True, True)

    def forward(self, angles: np.ndarray) -> SolePoses:
        """Pose of the sole for angles in [rad]. Shape (n, joints)."""
        position, turned, _, _ = self._walked(angles)
        return SolePoses(position, turned)

    def jacobian(self, angles: np.ndarray) -> np.ndarray:
        """Velocity of the sole, then its angular velocity, per joint's. Shape (n, 6, joints).

        Both in the body's frame, in [m/rad] and [-].
        """
        position, _, axes, points = self._walked(angles)
        return np.swapaxes(_screws(position, axes, points), 1, 2)

    def inverse(self, wanted: SolePoses, start: np.ndarray) -> LegSolution:
        """Angles that bring the sole to poses, or as near as the limits and the joints allow.

        Of several solutions the one that damped steps from `start` lead to.

        Args:
            wanted: Poses of the sole.
            start: Angles to set out from, in [rad]; they decide which way a knee bends. Shape
                (joints,) or (n, joints).
        """
        n = len(wanted.position)
        angles = np.array(np.broadcast_to(start, (n, len(self.axes))), dtype=float)
        left = np.arange(n)  # instants that still move
        for _ in range(ITERATIONS):
            step = self._step(angles[left], SolePoses(*(part[left] for part in wanted)))
            moved = np.clip(angles[left] + step, *self.limits.T)
            going = np.abs(moved - angles[left]).max(axis=1) > SETTLED
            angles[left] = moved
            left = left[going]
            if not len(left):
                break
        reached = self.forward(angles)
        wrong = self._wrong_turn(wanted.rotation, reached.rotation)
        misplaced = np.linalg.norm(wanted.position - reached.position, axis=1)
        return LegSolution(angles, misplaced, np.linalg.norm(wrong, axis=1))

    def _wrong_turn(self, wanted: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Rotation vectors to wanted rotations, in the soles' frames, as far as held. (n, 3)."""
        turn = _rotation_vector(np.swapaxes(reached, 1, 2) @ wanted)
        return turn * np.array(self.holds, dtype=float)

    def _step(self, angles: np.ndarray, wanted: SolePoses) -> np.ndarray:
        """One damped step towards poses, in [rad]. Shape (n, joints)."""
        position, turned, axes, points = self._walked(angles)
        rows = _screws(position, axes, points)
        # A turn is weighed in the sole's frame, since the one that is not held is the sole's.
        rows[:, :, 3:] = rows[:, :, 3:] @ turned * (TURN * np.array(self.holds, dtype=float))
        turn = TURN * self._wrong_turn(wanted.rotation, turned)
        error = np.concatenate([wanted.position - position, turn], axis=1)
        pull = np.einsum("njk,nk->nj", rows, error)
        free = self._free(angles, pull)
        rows = rows * free[:, :, None]
        square = rows @ np.swapaxes(rows, 1, 2) + DAMPING**2 * np.eye(len(self.axes))
        step = np.linalg.solve(square, (pull * free)[:, :, None])[:, :, 0]
        longest = np.abs(step).max(axis=1, keepdims=True)
        return step * np.minimum(1.0, LONGEST_STEP / np.maximum(longest, LONGEST_STEP))

    def _free(self, angles: np.ndarray, pull: np.ndarray) -> np.ndarray:
        """Which joints may move: not those at a limit that the error pulls beyond it."""
        lower, upper = self.limits.T
        return ~(((angles <= lower) & (pull < 0.0)) | ((angles >= upper) & (pull > 0.0)))

    def _walked(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Position and rotation of the sole, and each joint's axis and point where they now are."""
        n, joints = angles.shape
        axes, points = np.empty((n, joints, 3)), np.empty((n, joints, 3))
        turned = np.broadcast_to(np.eye(3), (n, 3, 3))
        moved = np.zeros((n, 3))
        for k in range(joints):
            axes[:, k] = turned @ self.axes[k]
            points[:, k] = turned @ self.points[k] + moved
            turned = turned @ vector_rotation(tuple(self.axes[k]), angles[:, k])
            moved = points[:, k] - turned @ self.points[k]
        return turned @ self.sole + moved, turned @ self.rotation, axes, points


def _screws(position: np.ndarray, axes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Velocity and angular velocity of the sole per joint's, in [m] and [-]. Shape (n, joints, 6).

    Args:
        position: Of the sole, in [m]. Shape (n, 3).
        axes: Of the joints. Shape (n, joints, 3).
        points: On these axes, in [m]. Shape (n, joints, 3).
    """
    return np.concatenate([np.cross(axes, position[:, None, :] - points), axes], axis=2)


def _rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Axis times angle of rotations, in [rad]. Shapes (n, 3, 3) to (n, 3).

    Accurate for small turns, where the inverse ends; a half turn has no unique axis.
    """
    skew = 0.5 * np.stack(
        [
            rotation[:, 2, 1] - rotation[:, 1, 2],
            rotation[:, 0, 2] - rotation[:, 2, 0],
            rotation[:, 1, 0] - rotation[:, 0, 1],
        ],
        axis=1,
    )
    sine = np.linalg.norm(skew, axis=1)
    cosine = 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    scale = np.divide(angle, sine, out=np.ones_like(sine), where=sine > 0.0)
    return skew * scale[:, None]
