"""Equations of EROS and FLoW as printed, one at a time, to size each mistake.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from math import acos, asin, atan, atan2, cos, degrees, hypot, pi, radians, sin
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.dh import DhArm, DhHead
from gaitlab.kinematics.six_joint_leg import Leg

EROS_EQUATIONS = (11, 12, 13, 14, 15, 17, 22, 23, 25, 27)
PAN, TILT = radians(60.0), radians(85.0)  # ranges over which FLoW's head is compared
Solver = Callable[[Leg, np.ndarray, Collection[int]], np.ndarray]


class Miss(NamedTuple):
    """How far a sole lands from where it was to go.

    Attributes:
        position: Distance, in [m].
        tilt: Angle of the sole to the level, in [rad].
    """

    position: float
    tilt: float

    def __str__(self) -> str:
        return f"sole {1e3 * self.position:.1f} mm off, tilted {degrees(self.tilt):.1f} degrees"


def miss(solve: Solver, leg: Leg, sole: np.ndarray, printed: Collection[int]) -> Miss:
    """Where a sole lands when some equations are used as printed and all others as corrected.

    Args:
        solve: `eros_joints` or `flow_joints`.
        leg: The leg; what is solved is a level sole without heading.
        sole: Target below the ankle, relative to the hip, in [m]. Shape (3,).
        printed: Numbers of the equations that stay as printed.
    """
    joints = solve(leg, sole, printed)
    pose = leg.sole_pose(joints)
    return Miss(
        float(np.linalg.norm(pose[:3, 3] - leg.hip - sole)), float(np.arccos(min(pose[2, 2], 1.0)))
    )


def eros_joints(leg: Leg, sole: np.ndarray, printed: Collection[int]) -> np.ndarray:
    """Joints of a level sole, [Pristovani2018] eqs. (9) to (28). Shape (6,)."""
    px, py, pz = (float(x) for x in sole)
    dz3, dz4 = leg.geometry.thigh, leg.geometry.shank
    r0 = hypot(px, py)
    beta = atan(py / px) if 11 in printed else atan2(py, px)
    y = (py if 12 in printed else 0.0) + r0 * sin(beta)
    x = px - r0 * cos(beta) if 13 in printed else r0 * cos(beta)
    z = pz - leg.geometry.hip_drop if 14 in printed else pz
    z += leg.ankle_height
    roll = atan(y / z) if 15 in printed else atan2(y, -z)
    r1 = hypot(y, z)
    r2 = hypot(x, z if 17 in printed else r1)
    gamma_c = _opposite(dz3, dz4, r2)
    across = (dz3 if 22 in printed else dz4) * sin(gamma_c)
    along = dz3 + dz4 * cos(gamma_c) if 23 in printed else dz3 - dz4 * cos(gamma_c)
    bend = atan2(x, r1) + atan2(across, along)
    pitch, knee = (bend if 25 in printed else -bend), pi - gamma_c
    ankle = pitch + knee if 27 in printed else -(pitch + knee)
    return np.array([0.0, roll, pitch, knee, ankle, -roll])


def flow_joints(leg: Leg, sole: np.ndarray, printed: Collection[int]) -> np.ndarray:
    """Joints of a level sole, [Yanto] eqs. (25) to (38), hip pitch as a turn about +y. Shape (6,).

    Where the paper's R1 has no definition it is taken as hypot(dY, Z).
    """
    x, y, z = float(sole[0]), float(sole[1]), -float(sole[2]) - leg.ankle_height
    one, two = leg.geometry.thigh, leg.geometry.shank
    r1 = hypot(y, z)
    r2 = hypot(r1, y) if 30 in printed else hypot(x, r1)
    theta_sc = _opposite(one, two, r2)
    theta_sa = 0.0 if 32 in printed else atan2(x, r1)
    knee = pi - theta_sc
    theta_sb = atan2(two * sin(knee), one + two * cos(knee))
    if 34 in printed:
        theta_sb = asin(two * sin(theta_sc) / r2)
    pitch = -(theta_sa + (theta_sc if 35 in printed else theta_sb))
    knee = pi - theta_sb if 36 in printed else knee
    ankle = pitch + knee if 37 in printed else -(pitch + knee)
    roll = atan2(y, z)
    return np.array([0.0, roll, pitch, knee, ankle, roll if 38 in printed else -roll])


def printed_cosine(leg: Leg, sole: np.ndarray) -> float:
    """Argument of the arc cosine in [Yanto] eqs. (31) and (32) as printed."""
    one, two = leg.geometry.thigh, leg.geometry.shank
    ankle = sole + np.array([0.0, 0.0, leg.ankle_height])
    r2 = float(np.linalg.norm(ankle))
    return (one**2 + two**2 + r2**2) / (2.0 * one**2 + two**2)


def _opposite(one: float, two: float, third: float) -> float:
    """Angle of a triangle opposite its third side; 0 or pi where the sides do not close."""
    cosine = (one**2 + two**2 - third**2) / (2.0 * one * two)
    return acos(min(max(cosine, -1.0), 1.0))


def _looks() -> np.ndarray:
    """A grid of pan and tilt. Shape (n, 2)."""
    pan, tilt = np.meshgrid(np.linspace(-PAN, PAN, 49), np.linspace(0.02, TILT, 40))
    return np.stack([pan.ravel(), tilt.ravel()], axis=-1)


def head_miss(head: DhHead) -> float:
    """Largest error of the eyes' place by eqs. (5) to (7), d1 = d and d2 = 0, in [m]."""
    joints = _looks()
    one, two = joints.T
    a = head.eyes
    x = a * np.cos(one) * np.cos(two) - a * np.sin(one) * np.sin(two)
    y = a * np.sin(one) * np.cos(two) - a * np.cos(one) * np.sin(two)
    printed = np.stack([x, y, np.full_like(x, 2.0 * head.neck)], axis=-1)
    return float(np.linalg.norm(printed - head.pose(joints)[:, :3, 3], axis=-1).max())


def pointing_error(head: DhHead) -> float:
    """Largest error of tilt by eq. (9), in [rad], with Z counted from the tilt axis."""
    joints = _looks()
    x, _, z = (head.pose(joints)[:, :3, 3] - [0.0, 0.0, head.neck]).T
    return float(np.abs(np.arctan(x / z) - joints[:, 1]).max())


def _joints() -> np.ndarray:
    """Random joints of the arm within its ranges, in [rad]. Shape (n, 5)."""
    low, high = [-3.1, 0.0, -2.1, 0.0, -2.6], [3.1, 2.8, 2.1, 2.4, 2.6]
    return np.random.default_rng(2).uniform(low, high, size=(2000, 5))


def printed_tip_error(arm: DhArm, printed: Collection[int]) -> np.ndarray:
    """Error of the tip by eqs. (12) to (14) over random joints, in [m]. Shape (n, 3).

    Args:
        arm: An arm of five joints.
        printed: Numbers of the equations that stay as printed; the others are repaired.
    """
    joints = _joints()
    (c1, c2, c3, c4, _), (s1, s2, s3, s4, _) = np.cos(joints).T, np.sin(joints).T
    d1, d3, d5 = arm.rise, arm.upper_arm, arm.forearm
    hanging = c4 * s2 if 12 in printed else c4 * c1 * s2
    x = d5 * (s4 * (s1 * s3 + c1 * c2 * c3) + hanging) + d3 * c1 * s2
    y = d3 * s1 * s2 - d5 * (s4 * (c1 * s3 - s1 * c2 * c3) - c4 * s1 * s2)
    if 13 in printed:
        y = d3 * (s1 * (s2 - d5 * (s4 * c1 * s3 - c2 * c3 * s1)) - c4 * s1 * s1)
    z = d1 - d5 * (c2 * c4 - c3 * s2 * s4) - d3 * (c1 * s2 if 14 in printed else c2)
    return np.stack([x, y, z], axis=-1) - arm.pose(joints)[:, :3, 3]


def shoulder_sensitivity(arm: DhArm) -> float:
    """Turn of q2 by eq. (16) for 0.1 mm of Px at q1 = 89.9 degrees, q2 = 60 degrees, in [rad]."""
    q1, q2 = radians(89.9), radians(60.0)
    x, drop = arm.upper_arm * cos(q1) * sin(q2), arm.upper_arm * cos(q2)
    return abs(atan((x + 1e-4) / (cos(q1) * drop)) - atan(x / (cos(q1) * drop)))


def roll_error() -> float:
    """Mean error of q5 by eq. (19), the same for all lengths, in [rad], between -pi and pi."""
    joints = _joints()
    error = joints[:, 2] + joints[:, 3] - joints[:, 4]
    return float(np.abs(np.angle(np.exp(1j * error))).mean())
