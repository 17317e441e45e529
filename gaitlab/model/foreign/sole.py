"""The sole of a foreign foot: the flat that its geometry stands on, however it is tilted.

The convex hull of the foot's vertices has many facets; those that look down and nearly alike are
one face. The face with the largest area is the sole, its normal the way down, and what lies within
a few millimetres of it is the rectangle that carries the robot. Where most of a face is flat, what
curves up at its edges does not tilt it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.model.foreign.reading import Geometry

DOWNWARD = np.radians(53.0)  # from down, within which a face may be a sole
ALIKE = np.radians(3.0)  # within which facets are one face
FLAT = np.radians(0.5)  # within which facets are in one plane
DEPTH = 4e-3  # m above the lowest point, within which rounded edges still carry
UP = np.array([0.0, 0.0, 1.0])
CIRCLE = 24  # corners by which a round shape is replaced


class FoundSole(NamedTuple):
    """The rectangle that a foot stands on, in the frame of its vertices.

    Attributes:
        centre: Of the rectangle, in [m]. Shape (3,).
        rotation: Columns are forward, left and up of the sole. Shape (3, 3).
        length: Along forward, in [m].
        width: Along left, in [m].
        tilt: Between the sole's up and the frame's, in [rad].
    """

    centre: np.ndarray
    rotation: np.ndarray
    length: float
    width: float
    tilt: float


def find_sole(vertices: np.ndarray, base: np.ndarray) -> FoundSole | None:
    """The sole of a foot; None if no face looks down.

    Args:
        vertices: Of all that the foot is made of, in [m]. Shape (n, 3).
        base: Rows are the robot's forward, left and up. Shape (3, 3).
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError):  # fewer than four corners, or all in a plane
        return None
    normals, areas = hull.equations[:, :3], _areas(vertices[hull.simplices])
    low = normals @ -base[2] >= np.cos(DOWNWARD)
    if not low.any():
        return None
    normals, areas = normals[low], areas[low]
    cosine = normals @ normals.T
    alike = cosine >= np.cos(ALIKE)
    group = alike[np.argmax(alike @ areas)]
    flat = (cosine >= np.cos(FLAT)) & group & group[:, None]
    shares = flat @ areas / areas[group].sum()
    if shares.max() > 0.5:
        group = flat[np.argmax(shares)]
    up = -np.sum(normals[group] * areas[group, None], axis=0)
    up /= np.linalg.norm(up)
    left = np.cross(up, base[0])
    left /= np.linalg.norm(left)
    axes = np.array([np.cross(left, up), left, up])
    at = vertices @ axes.T
    carrying = at[at[:, 2] <= at[:, 2].min() + DEPTH]
    ends = carrying.min(axis=0), carrying.max(axis=0)
    middle = np.append((ends[0] + ends[1])[:2] / 2.0, at[:, 2].min())
    length, width = (ends[1] - ends[0])[:2]
    tilt = float(np.arccos(np.clip(up @ base[2], -1.0, 1.0)))
    return FoundSole(middle @ axes, axes.T, float(length), float(width), tilt)


def corners(shapes: Sequence[Geometry], up: np.ndarray = UP) -> np.ndarray:
    """Vertices of boxes, cylinders and spheres in the body's frame, in [m]. Shape (n, 3).

    A cylinder by corners around its ends. A sphere by its lowest and highest point and four on its
    upper half, for under a foot it carries where it touches and not as wide as it is.

    Args:
        shapes: Geometry of the body.
        up: What is up at zero angles, in the body's frame. Shape (3,).
    """
    return np.concatenate([np.empty((0, 3)), *(_corners(shape, up) for shape in shapes)])


def _corners(shape: Geometry, up: np.ndarray) -> np.ndarray:
    if shape.kind == "box":
        signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        local = signs * shape.size
    elif shape.kind == "cylinder":
        radius, length = shape.size
        ring = _ring() * radius
        local = np.concatenate(
            [np.column_stack([ring, np.full(CIRCLE, z)]) for z in (-length / 2, length / 2)]
        )
    elif shape.kind == "sphere":
        side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
        side /= np.linalg.norm(side)
        around = np.array([side, -side, np.cross(up, side), -np.cross(up, side)])
        points = np.concatenate([[up, -up], np.sqrt(0.5) * (around + up)])
        return shape.position + shape.size[0] * points
    else:
        return np.empty((0, 3))
    return shape.position + local @ shape.rotation.T


def _ring() -> np.ndarray:
    turn = np.arange(CIRCLE) * 2.0 * np.pi / CIRCLE
    return np.column_stack([np.cos(turn), np.sin(turn)])


def _areas(triangles: np.ndarray) -> np.ndarray:
    """Areas of triangles (n, 3, 3), in [m^2]. Shape (n,)."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.linalg.norm(np.cross(first, second), axis=1) / 2.0
