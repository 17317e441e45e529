"""A parallel projection of boxes, discs and blades, painted from far to near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

LIGHT = np.array([0.35, -0.55, 0.76])  # direction to the lamp, world frame, unit length
AMBIENT = 0.62  # brightness of a face that the lamp does not reach
DISC_CORNERS = 24


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Looks at the world from far away.

    Attributes:
        azimuth: Direction in which it stands, from x to y, in [rad]; -pi/2 sees the right side
            with x to the right.
        elevation: Height over the horizon, in [rad].
    """

    azimuth: float
    elevation: float

    @cached_property
    def axes(self) -> np.ndarray:
        """Right, up and away in the world frame, as rows. Shape (3, 3)."""
        a, e = self.azimuth, self.elevation
        away = -np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return np.stack([right, np.cross(right, away), away])

    def see(self, points: np.ndarray) -> np.ndarray:
        """Right, up and away of points in the world frame, in [m]. Shape (..., 3)."""
        return np.asarray(points @ self.axes.T)


@dataclass(frozen=True, kw_only=True, eq=False)
class Faces:
    """Polygons of one style.

    Attributes:
        corners: In the world frame, in [m]. Shape (n, corners, 3).
        colours: Red, green, blue. Shape (n, 3).
        nearer: Added towards the camera when sorting, in [m], for what lies on a face.
        edge: Width of the outline, in points; 0 for none.
    """

    corners: np.ndarray
    colours: np.ndarray
    nearer: float = 0.0
    edge: float = 0.0


def box_faces(
    size: Sequence[float], centre: np.ndarray, rotation: np.ndarray, colour: str, edge: float = 0.5
) -> Faces:
    """The six faces of a box, lit by the lamp.

    Args:
        size: Edge lengths, in [m].
        centre: In the world frame, in [m]. Shape (3,).
        rotation: Of the box in the world frame. Shape (3, 3).
        colour: Of a face in full light.
        edge: Width of the outline, in points.
    """
    corners, normals = _unit_box()
    placed = centre + (corners * np.asarray(size)) @ rotation.T
    return Faces(corners=placed, colours=lit(colour, normals @ rotation.T), edge=edge)


def _unit_box() -> tuple[np.ndarray, np.ndarray]:
    """Faces (6, 4, 3) of a cube of edge 1 about the origin and their normals (6, 3)."""
    faces, normals = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            normal = sign * np.eye(3)[axis]
            faces.append([0.5 * (normal + a * u + b * v) for a, b in _RING])
            normals.append(normal)
    return np.array(faces), np.array(normals)


_RING = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


def disc(
    centre: np.ndarray, normal: np.ndarray, radius: float, colour: str, *, nearer: float = 0.0
) -> Faces:
    """A disc about a point, all in the world frame, in [m]."""
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    angle = np.linspace(0.0, 2.0 * np.pi, DISC_CORNERS, endpoint=False)[:, None]
    ring = centre + radius * (np.cos(angle) * u + np.sin(angle) * v)
    return Faces(corners=ring[None], colours=lit(colour, normal[None]), nearer=nearer, edge=0.4)


def lit(colour: str, normals: np.ndarray) -> np.ndarray:
    """Colour of faces under the lamp. Shape (n, 3)."""
    shade = AMBIENT + (1.0 - AMBIENT) * np.clip(normals @ LIGHT, 0.0, 1.0)
    return np.clip(np.array(to_rgb(colour)) * shade[:, None], 0.0, 1.0)


def channels(colour: str) -> tuple[float, float, float]:
    """Red, green and blue of a colour, in [0, 1]."""
    red, green, blue = to_rgb(colour)
    return red, green, blue


def faded(faces: Faces, share: float) -> Faces:
    """The faces, mixed with white paper by a share."""
    return Faces(
        corners=faces.corners,
        colours=faces.colours * (1.0 - share) + share,
        nearer=faces.nearer,
        edge=faces.edge,
    )


def paint(axes: Axes, camera: Camera, faces: Sequence[Faces], *, zorder: float = 1.0) -> None:
    """Paint polygons from far to near; those that turn their back hide behind the others."""
    depth, order = [], []
    for i, part in enumerate(faces):
        away = camera.see(part.corners.mean(axis=1))[:, 2] - part.nearer
        depth.append(away)
        order.append(np.column_stack([np.full(len(away), i), np.arange(len(away))]))
    ranked = np.concatenate(order)[np.argsort(-np.concatenate(depth), kind="stable")]
    seen = [camera.see(part.corners)[..., :2] for part in faces]
    colours = np.array([faces[i].colours[j] for i, j in ranked])
    widths = [faces[i].edge for i, _ in ranked]
    outlines = np.where(np.array(widths)[:, None] > 0, 0.45 * colours, colours)
    polygons = PolyCollection(
        [seen[i][j] for i, j in ranked],
        facecolors=colours,
        edgecolors=outlines,
        linewidths=widths,
        joinstyle="round",
        zorder=zorder,
        rasterized=True,
    )
    axes.add_collection(polygons)
