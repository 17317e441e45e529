"""One frame of a film: the robot on its lane, what acts on it, and the clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from PIL import Image
from scipy.spatial import ConvexHull, QhullError

from gaitlab.model import LinkPoses
from gaitlab.render.colours import BLUE, FAINT, VERMILLION
from gaitlab.render.lawn import Patch
from gaitlab.render.lens import CAMERAS, DISTANCE, Lens, View
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
from gaitlab.render.robot import robot_faces
from gaitlab.render.scene import LIGHT, Faces
from gaitlab.render.take import Take
from gaitlab.render.turf import BOARD, Turf, fans, ground, grown

PAPER = 255  # grey of the empty picture
TALL = 1.66  # height of the picture above its foot over that of the robot
LEAST_UNIT = 0.5  # pixels; keeps letters readable in a small picture
FLOOR = {"perspective": 0.26, "side": 0.19, "front": 0.24}  # of a robot height, below the base
ACROSS = 0.95  # robot heights, least width of the lane
BESIDE = 0.32  # robot heights of ground beside the outermost footprint
AHEAD = {"perspective": (2.6, 2.4), "side": (2.6, 2.6), "front": (1.6, 0.55)}
TINT = np.array([int(BLUE[i : i + 2], 16) for i in (1, 3, 5)])  # of the support polygon
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
    span: tuple[float, float]


class Painter:
    """Paints the frames of one or two trials side by side; holds the grass and the pixels."""

    def __init__(self, takes: tuple[Take, ...], style: Style, *, beside: bool = True) -> None:
        """Takes the trials and the look, and whether the trials share the width of a picture."""
        self._takes, self._style = takes, style
        self._height = FINER * style.height
        self._width = FINER * (style.width // (len(takes) if beside else 1))
        self._unit = max(self._height / 1000.0, LEAST_UNIT * FINER)
        self._ground = Layer(self._width, self._height, PAPER)
        self._robot = Layer(self._width, self._height, PAPER)
        self._stains = np.zeros((self._height, self._width), np.uint8)
        self._size = max(take.size for take in takes)
        self._turf = [self._lane(take) for take in takes]

    def frame(self, index: int, now: float) -> Image.Image:
        """The picture of a frame, at an instant of the clock."""
        style = self._style
        picture = Image.new("RGB", (FINER * style.width, FINER * style.height), "white")
        pen = Pen(picture, self._unit)
        for place, take in enumerate(self._takes):
            left = place * self._width
            picture.paste(self.panel(place, index), (left, 0))
            draw_head(pen, take, index, left, left + self._width)
        if len(self._takes) > 1:
            middle = np.array(
                [[self._width, 0], [self._width, self._height - (FOOT + 6) * pen.unit]]
            )
            pen.line(middle, FAINT, 3)
        draw_foot(pen, self._takes, now, style.span, picture.size)
        draw_legend(pen, (picture.width - 24 * pen.unit, self._height - 22 * pen.unit))
        return picture.reduce(FINER)

    def panel(self, place: int, index: int) -> Image.Image:
        """One trial at a frame, without words, at `FINER` times its size."""
        take, turf = self._takes[place], self._turf[place]
        lens = self._lens(take, index)
        picture = Image.fromarray(self._scene(take, turf, index, lens))
        pen = Pen(picture, self._unit)
        if lens.sideways:
            draw_support_line(pen, take, index, lens, -0.5 * BOARD * (turf.y[1] - turf.y[0]))
        draw_forces(pen, take, index, lens)
        if take.fallen(index):
            bottom = self._height - (FOOT + 4) * pen.unit
            pen.frame((3, 3), (self._width - 4, bottom), VERMILLION)
        return picture

    def _scene(self, take: Take, turf: Turf, index: int, lens: Lens) -> np.ndarray:
        behind, ahead = AHEAD[self._style.view]
        x = take.focus[index, 0]
        seen = (x - behind * self._size, x + ahead * self._size)
        self._ground.clear(self._ground.whole)
        for part in ground(turf, seen, take.footprints(index), lens):
            self._ground.paint(part)
        faces = _polygons(take, index)
        robot, shadow = _painted(faces, lens), _shadow(faces, take.surface.height, lens)
        window = self._robot.around(np.concatenate([shadow, *(part.corners for part in robot)]))
        self._robot.clear(window)
        for part in robot:
            self._robot.paint(part)
        self._stain(take, index, lens, shadow, window)
        merge(self._ground, self._robot, self._stains, TINT, window)
        return self._ground.colour

    def _stain(self, take: Take, index: int, lens: Lens, shadow: np.ndarray, window: Crop) -> None:
        """Shadow of the robot and support polygon."""
        self._stains[window.top : window.bottom, window.left : window.right] = 0
        if lens.sideways:
            return
        stain(self._stains, shadow, SHADE)
        hull = _hull(take.soles[index][take.contact[index]].reshape(-1, 3))
        if len(hull):
            stain(self._stains, _triangles(hull[None], lens), SUPPORT)
            for a, b in zip(hull, np.roll(hull, -1, axis=0), strict=True):
                edge = _strip(a, b, EDGE * take.size)
                stain(self._stains, _triangles(edge[None], lens), SUPPORT_EDGE)

    def _lens(self, take: Take, index: int) -> Lens:
        view = self._style.view
        free = self._height - FOOT * self._unit
        scale = free / (TALL * self._size)
        middle = 0.45 * self._size
        floor = free - scale * (FLOOR[view] * self._size + middle)
        distance = DISTANCE * self._size if view == "perspective" else inf
        return Lens(
            camera=CAMERAS[view],
            focus=np.array([*take.focus[index], middle]),
            place=(0.5 * self._width, floor),
            scale=scale,
            distance=distance,
        )

    def _lane(self, take: Take) -> Turf:
        behind, ahead = AHEAD[self._style.view]
        x, y = take.lane
        beside = BESIDE * self._size
        short = 0.5 * max(0.0, ACROSS * self._size - (y[1] - y[0]) - 2.0 * beside)
        patch = Patch(
            x=(x[0] - behind * self._size, x[1] + ahead * self._size),
            y=(y[0] - beside - short, y[1] + beside + short),
        )
        blades = self._height * self._width / FINER**2 / A_BLADE
        return grown(take.surface, patch, (behind + ahead) * self._size, blades)


def _polygons(take: Take, index: int) -> list[Faces]:
    poses = LinkPoses(*(part[index : index + 1] for part in take.poses))
    return robot_faces(take.tree, take.feet, poses)


def _painted(faces: Sequence[Faces], lens: Lens) -> list[Triangles]:
    """The robot on the screen; no two of its polygons have one number."""
    firsts = np.cumsum([0, *(len(part.corners) for part in faces)]).tolist()
    return [
        fans(part.corners - first * APART * lens.camera.axes[2], 255.0 * part.colours, lens, first)
        for part, first in zip(faces, firsts, strict=False)
    ]


def _shadow(faces: Sequence[Faces], height: float, lens: Lens) -> np.ndarray:
    """What the lamp throws of the robot on a plane at a height in [m]. Shape (n, 3, 3)."""
    quads = np.concatenate([part.corners for part in faces if part.corners.shape[1] == QUAD])
    flat = quads - (quads[..., 2:] - height) * LIGHT / LIGHT[2]
    return _triangles(flat, lens)


def _triangles(polygons: np.ndarray, lens: Lens) -> np.ndarray:
    return fans(polygons, np.zeros((len(polygons), 3)), lens).corners


def _hull(points: np.ndarray) -> np.ndarray:
    """Corners of the convex hull as seen from above, in order. Shape (k, 3), k = 0 for a line."""
    if not len(points):
        return points
    try:
        return points[ConvexHull(points[:, :2]).vertices]
    except QhullError:  # soles on their edge
        return points[:0]


def _strip(a: np.ndarray, b: np.ndarray, half: float) -> np.ndarray:
    """A strip on the ground along an edge. Shape (4, 3)."""
    along = (b - a)[:2] / max(float(np.hypot(*(b - a)[:2])), 1e-9)
    aside = half * np.array([-along[1], along[0], 0.0])
    return np.array([a - aside, b - aside, b + aside, a + aside])
