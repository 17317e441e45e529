"""Triangles painted into pictures with a depth for every pixel: the compiled half of the film.

Pictures are painted at `FINER` times their size and averaged, which smooths every edge. Nearness
is any number that grows towards the camera and is linear on the screen.

All compiled functions and their constants stay in this one file: a change of it, and only of it,
makes the cached machine code stale.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.compiled import njit

FINER = 2  # pixels painted for one of the picture, along each edge
NOTHING = -1  # face of a pixel without one
SHADE, SUPPORT, SUPPORT_EDGE = 1, 2, 4  # bits of the stains on the ground
SHADOW = 0.72  # brightness left in the shadow of the robot
GHOST = 0.38  # share of the robot that shows through the blades before it
OUTLINE = 0.45  # brightness of the line around a face
TINT, EDGE_TINT = 0.42, 0.85  # share of the support polygon's colour in its inside and its edge


class Triangles(NamedTuple):
    """Triangles on the screen.

    Attributes:
        corners: Right and down in painted pixels, and nearness. Shape (n, 3, 3).
        colours: Red, green, blue in 0 to 255. Shape (n, 3).
        faces: Number of the face that each triangle belongs to. Shape (n,).
    """

    corners: np.ndarray
    colours: np.ndarray
    faces: np.ndarray


class Crop(NamedTuple):
    """A part of a picture: first and past-the-last column and row."""

    left: int
    right: int
    top: int
    bottom: int


class Layer:
    """A picture with a nearness and a face for every pixel.

    Attributes:
        colour: Shape (height, width, 3).
        near: Minus infinity where nothing is painted. Shape (height, width).
        face: `NOTHING` where nothing is painted. Shape (height, width).
    """

    def __init__(self, width: int, height: int, paper: int) -> None:
        """Takes a size in painted pixels and the grey of the empty picture in 0 to 255."""
        self._paper = paper
        self.colour = np.empty((height, width, 3), np.uint8)
        self.near = np.empty((height, width), np.float32)
        self.face = np.empty((height, width), np.int32)

    @property
    def whole(self) -> Crop:
        """All of it."""
        height, width = self.near.shape
        return Crop(0, width, 0, height)

    def around(self, corners: np.ndarray) -> Crop:
        """The part that holds points and a pixel around them. Shape (..., 2 or more)."""
        height, width = self.near.shape
        x, y = np.moveaxis(corners[..., :2], -1, 0)
        left, right = np.clip([x.min() - 2, x.max() + 3], 0, width).astype(int)
        top, bottom = np.clip([y.min() - 2, y.max() + 3], 0, height).astype(int)
        return Crop(int(left), int(right), int(top), int(bottom))

    def clear(self, window: Crop) -> None:
        """Empty a part."""
        part = np.s_[window.top : window.bottom, window.left : window.right]
        self.colour[part] = self._paper
        self.near[part] = -np.inf
        self.face[part] = NOTHING

    def paint(self, triangles: Triangles) -> None:
        """Paint triangles; of two at a pixel the nearer one shows."""
        _fill(self.colour, self.near, self.face, *triangles)


def stain(stains: np.ndarray, corners: np.ndarray, bit: int) -> None:
    """Mark the pixels below triangles. Shapes (height, width) and (n, 3, 3)."""
    _mark(stains, corners, bit)


def merge(ground: Layer, robot: Layer, stains: np.ndarray, tint: np.ndarray, window: Crop) -> None:
    """Put the robot on the ground: faces outlined, faint behind blades, the ground stained.

    Args:
        ground: The ground, which becomes the picture.
        robot: The robot.
        stains: Bits of what lies on the ground. Shape (height, width).
        tint: Colour of the support polygon. Shape (3,).
        window: Part to work on.
    """
    _merge(
        ground.colour,
        ground.near,
        robot.colour,
        robot.near,
        robot.face,
        stains,
        tint.astype(np.float32),
        window,
    )


@njit
def _span(x, y, row, width):  # type: ignore[no-untyped-def]
    """First and past-the-last column of a triangle whose middles lie within it on a row."""
    middle = row + 0.5
    low, high = np.inf, -np.inf
    for i in range(3):
        j = (i + 1) % 3
        if (y[i] <= middle) != (y[j] <= middle):
            at = x[i] + (middle - y[i]) * (x[j] - x[i]) / (y[j] - y[i])
            low, high = min(low, at), max(high, at)
    if low > high:
        return 0, 0
    first = int(np.ceil(max(low - 0.5, 0.0)))
    return first, int(np.ceil(min(high - 0.5, width - 0.0)))


@njit
def _rows(y, height):  # type: ignore[no-untyped-def]
    """First and past-the-last row whose middles a triangle may hold."""
    low, high = min(y[0], y[1], y[2]), max(y[0], y[1], y[2])
    first = int(np.ceil(max(low - 0.5, 0.0)))
    return first, int(np.ceil(min(high - 0.5, height - 0.0)))


@njit
def _fill(colour, near, face, corners, colours, faces):  # type: ignore[no-untyped-def]
    height, width = near.shape
    for k in range(len(corners)):
        x, y, z = corners[k, :, 0], corners[k, :, 1], corners[k, :, 2]
        area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
        if abs(area) < 1e-6:
            continue
        across = ((z[1] - z[0]) * (y[2] - y[0]) - (z[2] - z[0]) * (y[1] - y[0])) / area
        down = ((x[1] - x[0]) * (z[2] - z[0]) - (x[2] - x[0]) * (z[1] - z[0])) / area
        red, green, blue, own = colours[k, 0], colours[k, 1], colours[k, 2], faces[k]
        top, bottom = _rows(y, height)
        for row in range(top, bottom):
            left, right = _span(x, y, row, width)
            start = z[0] + down * (row + 0.5 - y[0]) + across * (0.5 - x[0])
            for column in range(left, right):
                depth = np.float32(start + across * column)
                if depth > near[row, column]:
                    near[row, column] = depth
                    face[row, column] = own
                    colour[row, column, 0] = red
                    colour[row, column, 1] = green
                    colour[row, column, 2] = blue


@njit
def _mark(stains, corners, bit):  # type: ignore[no-untyped-def]
    height, width = stains.shape
    for k in range(len(corners)):
        x, y = corners[k, :, 0], corners[k, :, 1]
        top, bottom = _rows(y, height)
        for row in range(top, bottom):
            left, right = _span(x, y, row, width)
            for column in range(left, right):
                stains[row, column] |= bit


@njit
def _merge(ground, ground_near, robot, robot_near, face, stains, tint, window):  # type: ignore[no-untyped-def]
    left, right, top, bottom = window
    for row in range(top, bottom):
        for column in range(left, right):
            own, bits = face[row, column], stains[row, column]
            if own == NOTHING and bits == 0:
                continue
            share = 0.0
            if own != NOTHING:
                share = 1.0 if robot_near[row, column] > ground_near[row, column] else GHOST
            light = OUTLINE if own != NOTHING and _is_edge(face, row, column) else 1.0
            bare = ground_near[row, column] == -np.inf
            shadow = SHADOW if bits & SHADE and not bare else 1.0
            covered = 0.0
            if bits & SUPPORT_EDGE:
                covered = EDGE_TINT
            elif bits & SUPPORT:
                covered = TINT
            for i in range(3):
                below = shadow * ground[row, column, i]
                below += covered * (tint[i] - below)
                value = below + share * (light * robot[row, column, i] - below)
                ground[row, column, i] = np.uint8(value)


@njit
def _is_edge(face, row, column):  # type: ignore[no-untyped-def]
    height, width = face.shape
    own = face[row, column]
    if row > 0 and face[row - 1, column] != own:
        return True
    if row < height - 1 and face[row + 1, column] != own:
        return True
    if column > 0 and face[row, column - 1] != own:
        return True
    return column < width - 1 and face[row, column + 1] != own
