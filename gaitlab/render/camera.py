"""From the world to the screen: where a picture looks from and how large things appear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, radians
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from gaitlab.render.raster import Triangles

View: TypeAlias = Literal["perspective", "side", "front", "board"]


class Viewpoint(NamedTuple):
    """Where a view looks from, and what it frames; lengths are in robot heights.

    Attributes:
        azimuth: Direction in which the camera stands, from x to y, in [rad]; -pi/2 sees the right
            side with x to the right.
        elevation: Height over the horizon, in [rad].
        distance: From the camera to what it looks at; infinite for a parallel projection.
        tall: Height of the picture above the line of time.
        floor: How much of that is below the base of the robot.
        behind: Ground that is shown behind the robot.
        ahead: Ground that is shown ahead of it.
        aside: Ground on either side; None for all of the lane that the robot walks along.
    """

    azimuth: float
    elevation: float
    distance: float
    tall: float
    floor: float
    behind: float
    ahead: float
    aside: float | None = None


VIEWPOINTS: dict[View, Viewpoint] = {
    "perspective": Viewpoint(radians(-62.0), radians(14.0), 4.5, 1.66, 0.26, 2.6, 2.4),
    "side": Viewpoint(radians(-90.0), 0.0, inf, 1.66, 0.19, 2.6, 2.6),
    "front": Viewpoint(0.0, radians(9.0), inf, 1.66, 0.24, 1.6, 0.55),
    "board": Viewpoint(radians(-66.0), radians(13.0), inf, 1.2, 0.14, 0.4, 0.4, 0.34),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Camera:
    """A camera that looks at a point.

    Attributes:
        azimuth: Direction in which it stands, from x to y, in [rad].
        elevation: Height over the horizon, in [rad].
        focus: What it looks at, world frame, in [m]. Shape (3,).
        place: Where the focus is on the screen, right and down, in pixels.
        scale: Size of a metre at the focus, in pixels.
        distance: From the camera to the focus, in [m]; infinite for a parallel projection.
    """

    azimuth: float
    elevation: float
    focus: np.ndarray
    place: tuple[float, float]
    scale: float
    distance: float = inf

    @cached_property
    def axes(self) -> np.ndarray:
        """Right, up and away in the world frame, as rows. Shape (3, 3)."""
        a, e = self.azimuth, self.elevation
        away = -np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return np.stack([right, np.cross(right, away), away])

    def see(self, points: np.ndarray) -> np.ndarray:
        """Right and down in pixels, and nearness, of points in the world. Shape (..., 3)."""
        right, up, away = np.moveaxis((points - self.focus) @ self.axes.T, -1, 0)
        if np.isinf(self.distance):
            zoom, near = np.ones_like(away), -away
        else:
            # One over the distance is what is linear on the screen.
            near = 1.0 / np.maximum(self.distance + away, 0.05 * self.distance)
            zoom = self.distance * near
        x, y = self.place
        return np.stack([x + self.scale * zoom * right, y - self.scale * zoom * up, near], axis=-1)

    def triangles(self, polygons: np.ndarray, colours: np.ndarray, first: int = 0) -> Triangles:
        """Convex polygons as triangles on the screen.

        Args:
            polygons: World frame, in [m]. Shape (n, corners, 3).
            colours: In 0 to 255. Shape (n, 3).
            first: Number of the first face.
        """
        seen = self.see(polygons)
        ears = seen.shape[1] - 2
        hub = np.repeat(seen[:, :1], ears, axis=1)
        corners = np.stack([hub, seen[:, 1:-1], seen[:, 2:]], axis=2)
        return Triangles(
            corners.reshape(-1, 3, 3).astype(np.float32),
            np.repeat(colours, ears, axis=0).astype(np.uint8),
            np.repeat(np.arange(first, first + len(polygons), dtype=np.int32), ears),
        )

    @property
    def sideways(self) -> bool:
        """Whether it looks along the ground, which then is a line."""
        return self.elevation == 0.0
