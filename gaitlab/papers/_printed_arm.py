"""Head and arm of the FLoW paper as printed, to size each mistake.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Collection
from math import atan, cos, radians, sin

import numpy as np

from gaitlab.kinematics.dh_arm import DhArm
from gaitlab.kinematics.dh_head import DhHead

PAN, TILT = radians(60.0), radians(85.0)  # ranges over which the head is compared


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


def roll_error(arm: DhArm) -> float:
    """Mean error of q5 by eq. (19), in [rad], between -pi and pi."""
    del arm  # The same for all lengths.
    joints = _joints()
    error = joints[:, 2] + joints[:, 3] - joints[:, 4]
    return float(np.abs(np.angle(np.exp(1j * error))).mean())
