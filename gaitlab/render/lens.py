"""From the world to the screen: where a film looks from and how large things appear."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Literal, TypeAlias

import numpy as np

from gaitlab.render.scene import Camera

View: TypeAlias = Literal["perspective", "side", "front"]

CAMERAS: dict[View, Camera] = {
    "perspective": Camera(azimuth=radians(-62.0), elevation=radians(14.0)),
    "side": Camera(azimuth=radians(-90.0), elevation=0.0),
    "front": Camera(azimuth=0.0, elevation=radians(9.0)),
}
DISTANCE = 4.5  # robot heights from the camera of a perspective view to what it looks at


@dataclass(frozen=True, kw_only=True, eq=False)
class Lens:
    """A camera that looks at a point.

    Attributes:
        camera: Direction it looks from.
        focus: What it looks at, world frame, in [m]. Shape (3,).
        place: Where the focus is on the screen, right and down, in pixels.
        scale: Size of a metre at the focus, in pixels.
        distance: From the camera to the focus, in [m]; infinite for a parallel projection.
    """

    camera: Camera
    focus: np.ndarray
    place: tuple[float, float]
    scale: float
    distance: float

    def see(self, points: np.ndarray) -> np.ndarray:
        """Right and down in pixels, and nearness, of points in the world. Shape (..., 3)."""
        right, up, away = np.moveaxis(self.camera.see(points - self.focus), -1, 0)
        if np.isinf(self.distance):
            zoom, near = np.ones_like(away), -away
        else:
            # One over the distance is what is linear on the screen.
            near = 1.0 / np.maximum(self.distance + away, 0.05 * self.distance)
            zoom = self.distance * near
        x, y = self.place
        return np.stack([x + self.scale * zoom * right, y - self.scale * zoom * up, near], axis=-1)

    @property
    def sideways(self) -> bool:
        """Whether it looks along the ground, which then is a line."""
        return self.camera.elevation == 0.0
