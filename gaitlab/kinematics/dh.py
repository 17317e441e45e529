"""Standard Denavit-Hartenberg chains, batched over leading axes: a head and an arm of FLoW's paper.

A row turns and shifts along the old z, then shifts and turns along the new x, the distal form of
[Yanto] eq. (1), which is right as printed. Its columns are n, o, a, P in that order.

The head is a pan-tilt one whose zero looks straight up the neck. The printed forward kinematics (5)
to (7) has parallel axes, a wrong sign in (6) and a factor 2 in (7) that no product of two rows
gives; it describes no head that pans and tilts. The printed inverse, (8) and (9), does, with atan2
and the horizontal range in (9).

The arm has five joints, or seven with a wrist: three at the shoulder, the elbow and the forearm's
roll; the zero hangs straight down, where axes 1, 3 and 5 fall into one. Of all twists of +-90
degrees only (+90, +90, -90, +90, 0) gives the printed forward kinematics after these repairs:
    (12) the last term is cos(q4) cos(q1) sin(q2); print lacks cos(q1).
    (13) d5 multiplies both last terms, and the last is cos(q4) sin(q1) sin(q2), not sin(q1)^2.
    (14) ends in - d3 cos(q2); print has cos(q1) sin(q2).
The inverse (15) to (17) is right, up to atan2; (18) uses symbols nobody defines and (19) is a
line of the leg's, so both are replaced here. Joints 6 and 7 have no equation in print.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.reach import ROUNDING, require

NULL = 1e-12  # m or -, below this a direction is undefined
SIGNS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))  # of sin(q2) and sin(q4), by branch


class DHRow(NamedTuple):
    """One joint of a chain.

    Attributes:
        offset: Added to the joint angle, in [rad].
        d: Shift along the old z, in [m].
        a: Shift along the new x, in [m].
        alpha: Turn about the new x, in [rad].
    """

    offset: float
    d: float
    a: float
    alpha: float


def dh_transform(theta: np.ndarray, d: float, a: float, alpha: float) -> np.ndarray:
    """Transform of one joint, [Yanto] eq. (1): Rz(theta) Tz(d) Tx(a) Rx(alpha).

    Args:
        theta: Joint angle, in [rad]. Shape (...).
        d: Shift along the old z, in [m].
        a: Shift along the new x, in [m].
        alpha: Turn about the new x, in [rad].

    Returns:
        Homogeneous transform. Shape (..., 4, 4).
    """
    c, s = np.cos(theta), np.sin(theta)
    ca, sa = np.cos(alpha), np.sin(alpha)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [
        [c, -ca * s, sa * s, a * c],
        [s, ca * c, -sa * c, a * s],
        [zero, sa * one, ca * one, d * one],
        [zero, zero, zero, one],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def chain_pose(rows: Sequence[DHRow], joints: np.ndarray) -> np.ndarray:
    """Pose of the last frame of a chain in the first.

    Args:
        rows: One a joint.
        joints: In [rad]. Shape (..., joints).

    Returns:
        Homogeneous transform. Shape (..., 4, 4).
    """
    joints = np.asarray(joints, dtype=float)
    pose = np.broadcast_to(np.eye(4), (*joints.shape[:-1], 4, 4))
    for row, angle in zip(rows, np.moveaxis(joints, -1, 0), strict=True):
        pose = pose @ dh_transform(angle + row.offset, row.d, row.a, row.alpha)
    return pose


@dataclass(frozen=True, kw_only=True)
class DhHead:
    """Lengths of the chain, rows (pan, d, 0, -90 deg) and (tilt - 90 deg, 0, a, 0).

    Attributes:
        neck: d, neck base to the tilt axis, in [m].
        eyes: a, tilt axis to the point between the eyes, in [m].
    """

    neck: float
    eyes: float

    @property
    def rows(self) -> tuple[DHRow, DHRow]:
        """The chain's rows."""
        return DHRow(0.0, self.neck, 0.0, -pi / 2.0), DHRow(-pi / 2.0, 0.0, self.eyes, 0.0)

    def pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the eyes in the neck base frame; joints pan, tilt. (..., 2) to (..., 4, 4)."""
        return chain_pose(self.rows, joints)

    def pointing(self, point: np.ndarray) -> np.ndarray:
        """Pan and tilt that turn the head's axis through a point, [Yanto] eqs. (8) and (9).

        The other branch is pan + pi, -tilt. Pan is undefined on the neck's axis and 0 there.

        Args:
            point: In the neck base frame, in [m]. Shape (..., 3).

        Returns:
            Pan and tilt >= 0, in [rad]. Shape (..., 2).
        """
        x, y, z = np.moveaxis(np.asarray(point, dtype=float), -1, 0)
        return np.stack([np.arctan2(y, x), np.arctan2(np.hypot(x, y), z - self.neck)], axis=-1)


@dataclass(frozen=True, kw_only=True)
class DhArm:
    """Lengths of the arm; poses are in the frame of the shoulder, z up.

    Attributes:
        rise: d1, base to the shoulder's centre, in [m].
        upper_arm: d3, shoulder to elbow, in [m].
        forearm: d5, elbow to the tip, or to the wrist when there is one, in [m].
        hand: d7, wrist to the tip, in [m]; None without a wrist.
        name: Limb that an error names.
    """

    rise: float
    upper_arm: float
    forearm: float
    hand: float | None = None
    name: str = "arm"

    @property
    def rows(self) -> tuple[DHRow, ...]:
        """Rows of the chain, five or seven."""
        turn = pi / 2.0
        shoulder = (
            DHRow(0.0, self.rise, 0.0, turn),
            DHRow(0.0, 0.0, 0.0, turn),
            DHRow(0.0, self.upper_arm, 0.0, -turn),
            DHRow(0.0, 0.0, 0.0, turn),
        )
        if self.hand is None:
            return (*shoulder, DHRow(0.0, self.forearm, 0.0, 0.0))
        wrist = (DHRow(0.0, self.forearm, 0.0, -turn), DHRow(0.0, 0.0, 0.0, turn))
        return (*shoulder, *wrist, DHRow(0.0, self.hand, 0.0, 0.0))

    def pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the tip, [Yanto] eqs. (10) to (14), corrected.

        Args:
            joints: In [rad]. Shape (..., 5), or (..., 7) with a wrist.

        Returns:
            Homogeneous transform, positions in [m]. Shape (..., 4, 4).
        """
        return chain_pose(self.rows, joints)

    def pose_joints(self, pose: np.ndarray) -> np.ndarray:
        """Joints of the five-joint arm, all four branches, [Yanto] eqs. (15) to (17).

        Where sin(q2) = 0, q1 is undefined and 0; where sin(q4) = 0, only q3 +- q5 is defined and
        q3 is 0.

        Args:
            pose: Pose of the tip, positions in [m]. Shape (..., 4, 4).

        Returns:
            Joints in [rad], branches in the order of `SIGNS`. Shape (..., 4, 5).

        Raises:
            Infeasible: If five joints cannot take the pose.
            ValueError: If the arm has a wrist.
        """
        if self.hand is not None:
            raise ValueError("pose_joints is for five joints; use wrist_joints")
        rotation, tip = pose[..., :3, :3], pose[..., :3, 3]
        elbow = tip - self.forearm * rotation[..., 2]
        self._require_elbow(elbow)
        upper = self._upper_joints(elbow, rotation[..., 2])
        across = self._frame4(upper).swapaxes(-1, -2) @ rotation[..., None, :, :]
        roll = np.arctan2(across[..., 1, 0], across[..., 0, 0])
        return np.concatenate([upper, roll[..., None]], axis=-1)

    def point_joints(
        self, point: np.ndarray, swivel: np.ndarray | float = 0.0, roll: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Joints that put the tip at a point; the wrist, if there is one, stays straight.

        Args:
            point: In [m]. Shape (..., 3).
            swivel: Turn of the elbow about the line from shoulder to tip, 0 where the elbow is
                lowest, in [rad]. Shape (...).
            roll: q5, in [rad]. Shape (...).

        Returns:
            Joints in [rad], branches in the order of `SIGNS`. Shape (..., 4, 5) or (..., 4, 7).

        Raises:
            Infeasible: If the point is out of reach.
        """
        forearm = self.forearm + (self.hand or 0.0)
        elbow = self._elbow(np.asarray(point, dtype=float), forearm, np.asarray(swivel))
        upper = self._upper_joints(elbow, (point - elbow) / forearm)
        rolled = np.broadcast_to(
            np.asarray(roll, dtype=float)[..., None, None], (*upper.shape[:-1], 1)
        )
        wrist = [] if self.hand is None else [np.zeros((*upper.shape[:-1], 2))]
        return np.concatenate([upper, rolled, *wrist], axis=-1)

    def wrist_joints(self, pose: np.ndarray, swivel: np.ndarray | float = 0.0) -> np.ndarray:
        """Joints of the seven-joint arm at a swivel of the elbow; derived here.

        The wrist's centre fixes q1 to q4 as in `point_joints`; what remains of the rotation is
        Rz(q5) Ry(q6) Rz(q7), taken with q6 >= 0; q5 + pi, -q6, q7 + pi is the other solution.

        Args:
            pose: Pose of the tip, positions in [m]. Shape (..., 4, 4).
            swivel: As in `point_joints`, to the wrist. Shape (...).

        Returns:
            Joints in [rad], branches in the order of `SIGNS`. Shape (..., 4, 7).

        Raises:
            Infeasible: If the wrist's centre is out of reach.
            ValueError: If the arm has no wrist.
        """
        if self.hand is None:
            raise ValueError("wrist_joints is for seven joints; use pose_joints")
        rotation = pose[..., :3, :3]
        wrist = pose[..., :3, 3] - self.hand * rotation[..., 2]
        elbow = self._elbow(wrist, self.forearm, np.asarray(swivel))
        upper = self._upper_joints(elbow, (wrist - elbow) / self.forearm)
        rest = self._frame4(upper).swapaxes(-1, -2) @ rotation[..., None, :, :]
        bend = np.arctan2(np.hypot(rest[..., 0, 2], rest[..., 1, 2]), rest[..., 2, 2])
        straight = np.sin(bend) < NULL
        q5 = np.where(straight, 0.0, np.arctan2(rest[..., 1, 2], rest[..., 0, 2]))
        sum_of_both = np.arctan2(rest[..., 1, 0], rest[..., 0, 0])
        q7 = np.where(straight, sum_of_both, np.arctan2(rest[..., 2, 1], -rest[..., 2, 0]))
        return np.concatenate([upper, np.stack([q5, bend, q7], axis=-1)], axis=-1)

    def _upper_joints(self, elbow: np.ndarray, along: np.ndarray) -> np.ndarray:
        """q1 to q4 from the elbow and the forearm's direction. Shape (..., 4, 4)."""
        sign2, sign4 = np.array(SIGNS).T
        ex, ey, ez = (elbow[..., i, None] for i in range(3))
        ax, ay, az = (along[..., i, None] for i in range(3))
        upright = np.hypot(ex, ey) < NULL
        q1 = np.where(upright, 0.0, np.arctan2(sign2 * ey, sign2 * ex))
        c1, s1 = np.cos(q1), np.sin(q1)
        q2 = np.arctan2(c1 * ex + s1 * ey, self.rise - ez)
        c2, s2 = np.cos(q2), np.sin(q2)
        u, v = s1 * ax - c1 * ay, c1 * c2 * ax + s1 * c2 * ay + s2 * az
        bent = np.hypot(u, v)
        q3 = np.where(bent < NULL, 0.0, np.arctan2(sign4 * u, sign4 * v))
        q4 = np.arctan2(sign4 * bent, c1 * s2 * ax + s1 * s2 * ay - c2 * az)
        return np.stack([q1, q2, q3, q4], axis=-1)

    def _frame4(self, upper: np.ndarray) -> np.ndarray:
        return chain_pose(self.rows[:4], upper)[..., :3, :3]

    def _elbow(self, point: np.ndarray, forearm: float, swivel: np.ndarray) -> np.ndarray:
        """Elbow on its circle about the line from the shoulder to a point. Shape (..., 3)."""
        shoulder = np.array([0.0, 0.0, self.rise])
        reach = np.linalg.norm(point - shoulder, axis=-1)
        self._require_reach(reach, forearm)
        line = (point - shoulder) / np.maximum(reach, NULL)[..., None]
        share = (self.upper_arm**2 + reach**2 - forearm**2) / (2.0 * np.maximum(reach, NULL))
        radius = np.sqrt(np.maximum(self.upper_arm**2 - share**2, 0.0))
        low = _lowest(line)
        side = np.cross(line, low)
        offset = np.cos(swivel)[..., None] * low + np.sin(swivel)[..., None] * side
        return shoulder + share[..., None] * line + radius[..., None] * offset

    def _require_reach(self, reach: np.ndarray, forearm: float) -> None:
        low, high = abs(self.upper_arm - forearm), self.upper_arm + forearm
        inside = (reach >= max(low - ROUNDING, NULL)) & (reach <= high + ROUNDING)
        require(
            inside,
            reach,
            self.name,
            f"shoulder to tip would have to be {{found:.4f}} m, the arm spans [{low:.4f}, "
            f"{high:.4f}] m",
        )

    def _require_elbow(self, elbow: np.ndarray) -> None:
        length = np.linalg.norm(elbow - np.array([0.0, 0.0, self.rise]), axis=-1)
        require(
            np.abs(length - self.upper_arm) <= ROUNDING,
            length,
            self.name,
            f"shoulder to elbow would have to be {{found:.6f}} m, it is {self.upper_arm:.6f} m; "
            "five joints take no such pose, give the tip's point alone",
        )


def _lowest(line: np.ndarray) -> np.ndarray:
    """Unit vector across a line that points down most; along x for an upright line."""
    down = line[..., 2:] * line - np.array([0.0, 0.0, 1.0])
    length = np.linalg.norm(down, axis=-1, keepdims=True)
    return np.where(length > 1e-9, down / np.maximum(length, NULL), np.array([1.0, 0.0, 0.0]))
