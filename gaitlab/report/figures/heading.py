"""A walk seen from where it started: forward along the first heading, left across it."""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET

AXES = ("forward", "left")


def axes_of(log: TrialLog) -> np.ndarray:
    """Forward and left of the trunk when the walk starts, world frame, as rows. Shape (2, 2)."""
    yaw = log["yaw"][_start(log)]
    return np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])


def seen(log: TrialLog, points: np.ndarray) -> np.ndarray:
    """World points forward and left of where the trunk starts, in [m]. Shape (..., 2)."""
    origin = log.vector("trunk_", "xy")[_start(log)]
    return (points[..., :2] - origin) @ axes_of(log).T


def _start(log: TrialLog) -> int:
    return min(max(log.walking.start - 1, 0), len(log) - 1)


def foot_rotation(log: TrialLog, foot: int) -> np.ndarray:
    """Rotation of the left (0) or right (1) foot in the world. Shape (n, 3, 3)."""
    return rotation_of(log.vector(f"{FEET[foot]}_foot_q", "xyzw"))


def support_extent(log: TrialLog) -> np.ndarray:
    """Lowest and highest coordinate of the loaded soles, forward and left, in [m].

    Shape (n, 2, 2): instants, axes, low and high; NaN in flight.
    """
    feet = np.stack([_foot_extent(log, foot) for foot in (0, 1)])
    loaded = log.per_foot("contact").astype(bool).T[:, :, None]
    low = np.where(loaded, feet[..., 0], np.inf).min(axis=0)
    high = np.where(loaded, feet[..., 1], -np.inf).max(axis=0)
    both = np.stack([low, high], axis=-1)
    return np.where(np.isfinite(both), both, np.nan)


def _foot_extent(log: TrialLog, foot: int) -> np.ndarray:
    """Extent of one sole. Shape (n, 2, 2)."""
    centre = seen(log, log.vector(f"{FEET[foot]}_foot_"))
    edges = foot_rotation(log, foot)[:, :2, :2] * (log.header.sole_length, log.header.sole_width)
    half = 0.5 * np.abs(axes_of(log) @ edges).sum(axis=-1)
    return np.stack([centre - half, centre + half], axis=-1)
