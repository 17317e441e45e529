"""A leg that was found: its joints as lines of axes, and how it is bent to stand."""

from __future__ import annotations

from math import acos, inf, isfinite, pi
from typing import NamedTuple

import numpy as np

from gaitlab.model.stance import EXTENSION

BENT = acos(EXTENSION)  # rad, half of the knee's angle in standing


class FoundLeg(NamedTuple):
    """A leg in the trunk's frame at zero angles.

    Attributes:
        joints: Names of its joints, from the hip down.
        axes: Unit vectors. Shape (joints, 3).
        points: A point on each, in [m]. Shape (joints, 3).
        limits: In [rad]. Shape (joints, 2).
        pitch: Places of hip, knee and ankle among the joints.
        ankle: Origin of the foot's frame, in [m]. Shape (3,).
        rotation: Of the foot's frame. Shape (3, 3).
        holds: Whether its joints can hold the sole's roll, pitch and yaw.
        standing: Angles with the knee bent the way its limits allow, in [rad]. Shape (joints,).
        drawn: Where the file draws the foot's joint on its axis, in [m]. Shape (3,).
    """

    joints: tuple[str, ...]
    axes: np.ndarray
    points: np.ndarray
    limits: np.ndarray
    pitch: tuple[int, int, int]
    ankle: np.ndarray
    rotation: np.ndarray
    holds: tuple[bool, bool, bool]
    standing: np.ndarray
    drawn: np.ndarray

    @property
    def segments(self) -> tuple[float, float]:
        """Length of thigh and shank in the sagittal plane, in [m]."""
        hip, knee, ankle = (self.points[k, [0, 2]] for k in self.pitch)
        return float(np.linalg.norm(knee - hip)), float(np.linalg.norm(ankle - knee))


def limits_of(lower: float, upper: float) -> tuple[float, float]:
    """Limits of a joint, in [rad]; half a turn either way where the file states none."""
    return (lower, upper) if isfinite(lower) and isfinite(upper) else (-pi, pi)


def standing_angles(
    axes: np.ndarray,
    points: np.ndarray,
    limits: np.ndarray,
    pitch: tuple[int, int, int],
    sole: np.ndarray,
) -> np.ndarray:
    """Standing angles of a leg, its knee ahead or behind as its limits allow, in [rad].

    A segment's angle about y is that from straight down. Shape (joints,).
    """
    hip, knee, ankle = (points[k] for k in pitch)
    thigh, shank = _about_y(knee - hip), _about_y(ankle - knee)
    pitched = float(np.arctan2(-sole[2, 0], sole[0, 0]))
    best, least = np.zeros(len(axes)), inf
    for bend in (BENT, -BENT):
        first, second = -bend - thigh, 2.0 * bend - (shank - thigh)
        turns = np.array([first, second, -(first + second) - pitched])
        angles = np.zeros(len(axes))
        angles[list(pitch)] = turns * np.sign(axes[list(pitch), 1])
        beyond = np.maximum(limits[:, 0] - angles, 0.0) + np.maximum(angles - limits[:, 1], 0.0)
        if beyond[pitch[1]] < least - 1e-9:
            best, least = angles, beyond[pitch[1]]
    return best


def _about_y(segment: np.ndarray) -> float:
    return float(np.arctan2(-segment[0], -segment[2]))
