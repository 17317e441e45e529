"""What is written and drawn over a frame: forces, ZMP, titles, the gait's phase and the clock."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from gaitlab.render.camera import Camera
from gaitlab.render.figure_style import BLUE, FAINT, INK, PAPER, VERMILLION
from gaitlab.render.ground import BOARD_COLOUR, TILE
from gaitlab.render.scene import Scene

REACH = 0.34  # robot heights, length of an arrow that stands for the robot's whole weight
UNLOADED = 0.02  # of the weight; less shows no arrow
GREY = "#6B7278"
FOOT = 94  # units, height of the line of time and the legend
SCALE, SUPPORT, ZMP, LOAD = (
    f"a tile is {100 * TILE:.0f} cm",
    "support polygon",
    "ZMP",
    "load on a foot",
)
LEGEND = (SCALE, SUPPORT, ZMP, LOAD)  # from the right
STARTUP, WALK = "#DDE3E8", "#AEBBC6"


@cache
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Letters of a height in pixels, those that matplotlib ships with: the same everywhere."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


class Pen:
    """Draws on a picture; lengths are in units of a thousandth of the picture's height.

    Attributes:
        unit: Pixels in a unit.
    """

    def __init__(self, picture: Image.Image, unit: float) -> None:
        """Takes the picture and the pixels in a unit."""
        self._draw, self.unit = ImageDraw.Draw(picture), unit

    def text(
        self,
        place: tuple[float, float],
        text: str,
        size: float,
        *,
        colour: str = INK,
        anchor: str = "la",
        bold: bool = False,
    ) -> None:
        """Write at a place in pixels."""
        face = font(max(6, round(size * self.unit)), bold)
        self._draw.text(place, text, fill=colour, font=face, anchor=anchor)

    def tag(self, low: tuple[float, float], text: str, size: float) -> None:
        """Write on a red plate with its upper left corner at a place in pixels."""
        (x, y), pad, middle = low, 0.6 * size * self.unit, 0.85 * size * self.unit
        width = self.width(text, size, bold=True) + 2.0 * pad
        self.box(low, (x + width, y + 2.0 * middle), VERMILLION)
        self.text((x + pad, y + middle), text, size, colour=PAPER, anchor="lm", bold=True)

    def width(self, text: str, size: float, bold: bool = False) -> float:
        """Width of a text, in pixels."""
        return font(max(6, round(size * self.unit)), bold).getlength(text)

    def line(self, points: np.ndarray, colour: str, thickness: float) -> None:
        """Join places in pixels. Shape (n, 2)."""
        width = max(1, round(thickness * self.unit))
        self._draw.line([tuple(map(float, p)) for p in points], fill=colour, width=width)

    def polygon(self, points: np.ndarray, colour: str) -> None:
        """Fill places in pixels. Shape (n, 2)."""
        self._draw.polygon([tuple(map(float, p)) for p in points], fill=colour)

    def dot(self, place: np.ndarray, radius: float, colour: str, ring: str) -> None:
        """A dot in a ring, radius in units."""
        for r, fill in ((1.45 * radius, ring), (radius, colour)):
            x, y, reach = float(place[0]), float(place[1]), r * self.unit
            self._draw.ellipse((x - reach, y - reach, x + reach, y + reach), fill=fill)

    def box(self, low: tuple[float, float], high: tuple[float, float], colour: str) -> None:
        """Fill a rectangle between two places in pixels."""
        self._draw.rectangle((*low, *high), fill=colour)

    def frame(self, low: tuple[float, float], high: tuple[float, float], colour: str) -> None:
        """Outline a rectangle."""
        self._draw.rectangle((*low, *high), outline=colour, width=max(2, round(5 * self.unit)))

    def arrow(self, tail: np.ndarray, head: np.ndarray, colour: str) -> None:
        """An arrow with a white rim, so that it stands out from grass and robot."""
        along = head - tail
        length = float(np.hypot(*along))
        if length < 6.0 * self.unit:
            return
        along = along / length
        aside = np.array([-along[1], along[0]])
        for rim, fill in ((3.0, PAPER), (0.0, colour)):
            half, wing = (3.5 + rim) * self.unit, (11.0 + 1.4 * rim) * self.unit
            size = min(24.0 * self.unit, 0.7 * length)
            tip, neck = head + 1.6 * rim * self.unit * along, head - (size + 0.4 * rim) * along
            shaft = [tail + half * aside, neck + half * aside, neck + wing * aside, tip]
            mirrored = [neck - wing * aside, neck - half * aside, tail - half * aside]
            self.polygon(np.array([*shaft, *mirrored]), fill)


def draw_forces(pen: Pen, scene: Scene, frame: int, camera: Camera) -> None:
    """The load on each sole, and the ZMP."""
    for centre, force in zip(scene.centres[frame], scene.forces[frame], strict=True):
        if force[2] > UNLOADED * scene.weight:
            tip = centre + REACH * scene.size * force / scene.weight
            tail, head = camera.see(np.stack([centre, tip]))[:, :2]
            pen.arrow(tail, head, VERMILLION)
    if np.isfinite(scene.zmp[frame]).all():
        pen.dot(camera.see(scene.zmp[frame])[:2], 7.5, "#000000", PAPER)


def draw_support_line(pen: Pen, scene: Scene, frame: int, camera: Camera, bottom: float) -> None:
    """The support polygon seen along the ground: a bar on the board, with the ZMP on it."""
    loaded = scene.soles[frame][scene.contact[frame]]
    if not len(loaded):
        return
    across = camera.see(loaded.reshape(-1, 3))[:, 0]
    y = camera.see(np.array([*scene.focus[frame], bottom]))[1]
    pen.box((across.min(), y - 5 * pen.unit), (across.max(), y + 5 * pen.unit), BLUE)


def draw_head(pen: Pen, scene: Scene, frame: int, left: float, right: float) -> None:
    """Title, caption, the gait's phase, the feet that carry load, and the fall."""
    u = pen.unit
    pen.text((left + 24 * u, 20 * u), scene.title, 34, bold=True)
    size = 21.0
    while size > 12 and pen.width(scene.caption, size) > right - left - 40 * u:
        size -= 1
    pen.text((left + 24 * u, 66 * u), scene.caption, size, colour=GREY)
    _phase(pen, scene, frame, left + 24 * u, 104 * u)
    if scene.fallen(frame) and scene.fall is not None:
        text = f"FELL at {scene.fall:.2f} s: {scene.fall_cause}"
        pen.tag((left + 24 * u, 140 * u), text, 26)


def _phase(pen: Pen, scene: Scene, frame: int, x: float, y: float) -> None:
    """A bar that fills over the gait cycle, and a box for each foot, full when it carries load."""
    u, phase = pen.unit, scene.phase[frame]
    height, length = 18 * u, 170 * u
    walking = bool(np.isfinite(phase))
    pen.box((x, y), (x + length, y + height), STARTUP)
    if walking:
        pen.box((x, y), (x + length * float(phase), y + height), GREY)
    middle = x + 0.5 * length
    pen.line(np.array([[middle, y], [middle, y + height]]), PAPER, 2)
    label = f"gait phase {phase:.2f}" if walking else "start-up"
    pen.text((x + length + 12 * u, y + 0.5 * height), label, 19, colour=GREY, anchor="lm")
    at = x + length + 190 * u
    for name, loaded in zip("LR", scene.contact[frame], strict=True):
        pen.box((at, y - 2 * u), (at + 26 * u, y + height + 2 * u), INK if loaded else STARTUP)
        colour = PAPER if loaded else GREY
        pen.text((at + 13 * u, y + 0.5 * height), name, 18, colour=colour, anchor="mm", bold=True)
        at += 32 * u


def draw_foot(
    pen: Pen,
    scenes: tuple[Scene, ...],
    now: float,
    span: tuple[float, float],
    size: tuple[int, int],
) -> None:
    """A line of time with the start of walking, every fall and the clock; what the marks mean."""
    (width, height), u = size, pen.unit
    y, left, right = height - 62 * u, 24 * u, width - 178 * u
    pen.box((0, height - FOOT * u), (width, height), PAPER)
    first, last = span

    def place(instant: float) -> float:
        return left + (right - left) * (instant - first) / max(last - first, 1e-9)

    pen.box((left, y - 4 * u), (right, y + 4 * u), STARTUP)
    pen.box((place(min(max(first, 0.0), last)), y - 4 * u), (right, y + 4 * u), WALK)
    pen.box((left, y - 4 * u), (place(now), y + 4 * u), INK)
    pen.dot(np.array([place(now), y]), 9, INK, PAPER)
    for scene in scenes:
        if scene.fall is not None and first <= scene.fall <= last:
            x = place(scene.fall)
            wings = np.array([[x, y - 8 * u], [x - 10 * u, y - 26 * u], [x + 10 * u, y - 26 * u]])
            pen.polygon(wings, VERMILLION)
    pen.text((width - 24 * u, y), f"{now:.2f} s", 32, anchor="rm", bold=True)


def draw_legend(pen: Pen, place: tuple[float, float]) -> None:
    """What the marks mean, on one line that ends at a place in pixels, if there is room."""
    u, (x, y) = pen.unit, place
    if x < sum(pen.width(text, 18) + 46 * u for text in LEGEND):
        return
    for text in LEGEND:
        x -= pen.width(text, 18)
        pen.text((x, y), text, 18, colour=GREY, anchor="lm")
        x -= 16 * u
        if text == ZMP:
            pen.dot(np.array([x, y]), 6, "#000000", FAINT)
        elif text == SUPPORT:
            pen.box((x - 12 * u, y - 7 * u), (x + 8 * u, y + 7 * u), BLUE)
        elif text == LOAD:
            pen.arrow(np.array([x, y + 13 * u]), np.array([x, y - 13 * u]), VERMILLION)
        else:
            pen.box((x - 12 * u, y - 7 * u), (x + 8 * u, y + 7 * u), BOARD_COLOUR)
        x -= 30 * u
