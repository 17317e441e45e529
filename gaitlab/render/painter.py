"""One frame of a film: the robot on its ground, what acts on it, and the clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.spatial import ConvexHull, QhullError

from gaitlab.render.camera import VIEWPOINTS, Camera, View
from gaitlab.render.figure_style import BLUE, FAINT, VERMILLION
from gaitlab.render.ground import Lawn, Patch, ground_triangles, grown
from gaitlab.render.overlay import (
    FOOT,
    Pen,
    draw_foot,
    draw_forces,
    draw_head,
    draw_legend,
    draw_support_line,
)
from gaitlab.render.raster import (
    FINER,
    SHADE,
    SUPPORT,
    SUPPORT_EDGE,
    Crop,
    Layer,
    Triangles,
    merge,
    stain,
)
from gaitlab.render.scene import LIGHT, Faces, Scene, all_corners, channels

PAPER = 255  # grey of the empty picture
LEAST_UNIT = 0.5  # pixels; keeps letters readable in a small picture
ACROSS = 0.95  # robot heights, least width of the lane
BESIDE = 0.32  # robot heights of ground beside the outermost footprint
MARGIN = 0.06  # robot heights of ground around what lies on a board
MIDDLE = 0.45  # robot heights, of what the camera looks at
TINT = 255.0 * np.array(channels(BLUE))  # of the support polygon
A_BLADE = 45.0  # pixels of the picture for each of the blades that it may show
APART = 2e-5  # m, towards the camera for each face, so that no two lie at one depth
QUAD = 4  # corners of the polygons that throw a shadow; horns and eyes lie on others
EDGE = 0.006  # robot heights, half the width of the support polygon's edge


@dataclass(frozen=True, kw_only=True)
class Style:
    """How a film looks.

    Attributes:
        view: Where it looks from.
        width: Of the picture, in pixels.
        height: Of the picture, in pixels.
        span: First and last instant of the clock, in [s].
    """

    view: View
    width: int
    height: int
    span: tuple[float, float] = (0.0, 0.0)


class Painter:
    """Paints the frames of one or two trials side by side; holds the grass and the pixels."""

    def __init__(self, scenes: tuple[Scene, ...], style: Style, *, beside: bool = True) -> None:
        """Takes the trials and the look, and whether the trials share the width of a picture."""
        self._scenes, self._style = scenes, style
        self._view = VIEWPOINTS[style.view]
        self._height = FINER * style.height
        self._width = FINER * (style.width // (len(scenes) if beside else 1))
        self._unit = max(self._height / 1000.0, LEAST_UNIT * FINER)
        self._ground = Layer(self._width, self._height, PAPER)
        self._robot = Layer(self._width, self._height, PAPER)
        self._stains = np.zeros((self._height, self._width), np.uint8)
        self._size = max(scene.size for scene in scenes)
        self._lawns = [self._lawn(scene) for scene in scenes]

    def frame(self, index: int, now: float) -> Image.Image:
        """The picture of a frame, at an instant of the clock."""
        style = self._style
        picture = Image.new("RGB", (FINER * style.width, FINER * style.height), "white")
        pen = Pen(picture, self._unit)
        for place, scene in enumerate(self._scenes):
            left = place * self._width
            picture.paste(self.panel(place, index), (left, 0))
            draw_head(pen, scene, index, left, left + self._width)
        if len(self._scenes) > 1:
            middle = np.array(
                [[self._width, 0], [self._width, self._height - (FOOT + 6) * pen.unit]]
            )
            pen.line(middle, FAINT, 3)
        draw_foot(pen, self._scenes, now, style.span, picture.size)
        draw_legend(pen, (picture.width - 24 * pen.unit, self._height - 22 * pen.unit))
        return picture.reduce(FINER)

    def panel(self, place: int, index: int) -> Image.Image:
        """One trial at a frame, without words, at `FINER` times its size."""
        scene, lawn = self._scenes[place], self._lawns[place]
        faces = scene.faces(index)
        patch = self._patch(scene, index, all_corners(faces))
        onto_board = self._view.aside is not None
        camera = self.camera(patch.centre if onto_board else scene.focus[index])
        self._ground.clear(self._ground.whole)
        for part in ground_triangles(lawn, patch, scene.sole_poses(index), camera):
            self._ground.paint(part)
        robot, shadow = _painted(faces, camera), _shadow(faces, scene.surface.height, camera)
        window = self._robot.around(np.concatenate([shadow, *(part.corners for part in robot)]))
        self._robot.clear(window)
        for part in robot:
            self._robot.paint(part)
        self._stain(scene, index, camera, shadow, window)
        merge(self._ground, self._robot, self._stains, TINT, window)
        picture = Image.fromarray(self._ground.colour)
        if not onto_board:
            pen = Pen(picture, self._unit)
            if camera.sideways:
                draw_support_line(pen, scene, index, camera, -0.5 * patch.thickness)
            draw_forces(pen, scene, index, camera)
            if scene.fallen(index):
                bottom = self._height - (FOOT + 4) * pen.unit
                pen.frame((3, 3), (self._width - 4, bottom), VERMILLION)
        return picture

    def camera(self, target: np.ndarray) -> Camera:
        """The camera that looks at a robot over a place of the ground, in [m]. Shape (2,)."""
        view, free = self._view, self._height - FOOT * self._unit
        scale = free / (view.tall * self._size)
        return Camera(
            azimuth=view.azimuth,
            elevation=view.elevation,
            focus=np.array([*target, MIDDLE * self._size]),
            place=(0.5 * self._width, free - scale * (view.floor + MIDDLE) * self._size),
            scale=scale,
            distance=view.distance * self._size,
        )

    def _stain(
        self, scene: Scene, index: int, camera: Camera, shadow: np.ndarray, window: Crop
    ) -> None:
        """Shadow of the robot and support polygon."""
        self._stains[window.top : window.bottom, window.left : window.right] = 0
        if camera.sideways:
            return
        stain(self._stains, shadow, SHADE)
        hull = _hull(scene.soles[index][scene.contact[index]].reshape(-1, 3))
        if len(hull) and self._view.aside is None:
            stain(self._stains, _corners(hull[None], camera), SUPPORT)
            for a, b in zip(hull, np.roll(hull, -1, axis=0), strict=True):
                along = (b - a)[:2] / max(float(np.hypot(*(b - a)[:2])), 1e-9)
                aside = (EDGE * scene.size) * np.array([-along[1], along[0], 0.0])
                edge = np.array([a - aside, b - aside, b + aside, a + aside])
                stain(self._stains, _corners(edge[None], camera), SUPPORT_EDGE)

    def _patch(self, scene: Scene, index: int, corners: np.ndarray) -> Patch:
        """The ground that a picture shows: a stretch of the lane, or a board below the robot."""
        (x, y), view, size = scene.focus[index], self._view, self._size
        if view.aside is None:
            return Patch(x=(x - view.behind * size, x + view.ahead * size), y=self._lane(scene)[1])
        low, high = corners.min(axis=0) - MARGIN * size, corners.max(axis=0) + MARGIN * size
        return Patch(
            x=(min(x - view.behind * size, low[0]), max(x + view.ahead * size, high[0])),
            y=(min(y - view.aside * size, low[1]), max(y + view.aside * size, high[1])),
        )

    def _lane(self, scene: Scene) -> np.ndarray:
        """Edges along x and y of the ground that a film may show, in [m]. Shape (2, 2)."""
        (x0, y0), (x1, y1) = scene.lane
        view, size = self._view, self._size
        if view.aside is not None:  # a robot that has fallen reaches beyond its feet
            return np.array(
                [[x0 - 1.5 * size, x1 + 1.5 * size], [y0 - 1.5 * size, y1 + 1.5 * size]]
            )
        beside = BESIDE * size
        beside += 0.5 * max(0.0, ACROSS * size - (y1 - y0) - 2.0 * beside)
        along = [x0 - view.behind * size, x1 + view.ahead * size]
        return np.array([along, [y0 - beside, y1 + beside]])

    def _lawn(self, scene: Scene) -> Lawn:
        """What grows on the lane."""
        view, (x, y) = self._view, self._lane(scene).tolist()
        across = y[1] - y[0] if view.aside is None else 2.0 * view.aside * self._size
        along = min((view.behind + view.ahead) * self._size, x[1] - x[0])
        most = self._height * self._width / FINER**2 / A_BLADE
        return grown(scene.surface, Patch(x=(x[0], x[1]), y=(y[0], y[1])), most / (along * across))


def _painted(faces: Sequence[Faces], camera: Camera) -> list[Triangles]:
    """The robot on the screen; no two of its polygons have one number."""
    firsts = np.cumsum([0, *(len(part.corners) for part in faces)]).tolist()
    return [
        camera.triangles(part.corners - first * APART * camera.axes[2], 255.0 * part.colours, first)
        for part, first in zip(faces, firsts, strict=False)
    ]


def _shadow(faces: Sequence[Faces], height: float, camera: Camera) -> np.ndarray:
    """What the lamp throws of the robot on a plane at a height in [m]. Shape (n, 3, 3)."""
    quads = np.concatenate([part.corners for part in faces if part.corners.shape[1] == QUAD])
    return _corners(quads - (quads[..., 2:] - height) * LIGHT / LIGHT[2], camera)


def _corners(polygons: np.ndarray, camera: Camera) -> np.ndarray:
    return camera.triangles(polygons, np.zeros((len(polygons), 3))).corners


def _hull(points: np.ndarray) -> np.ndarray:
    """Corners of the convex hull as seen from above, in order. Shape (k, 3), k = 0 for a line."""
    if not len(points):
        return points
    try:
        return points[ConvexHull(points[:, :2]).vertices]
    except QhullError:  # soles on their edge
        return points[:0]
