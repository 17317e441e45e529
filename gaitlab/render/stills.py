"""A few instants of one or two trials side by side: a picture of their own, a figure of a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from gaitlab.render.camera import View
from gaitlab.render.figure_style import PAPER, SCREEN_DPI, new_figure, style
from gaitlab.render.overlay import GREY, SCALE, Pen
from gaitlab.render.painter import Painter, Style
from gaitlab.render.raster import FINER
from gaitlab.render.scene import Recorded, Scene, scene_of

HEAD = 0.17  # of the height of a panel, above each row
PAGE, PANEL = 10.0, 2.2  # in, widest figure of several instants and widest panel in it
PORTRAIT = 5.0  # in, width of a figure of one instant
TALLER = 1.04  # height of a panel in a figure over its width


def filmstrip(scenes: tuple[Scene, ...], style: Style) -> Image.Image:
    """A row for each trial, a panel for each of its instants.

    Args:
        scenes: Trials at equally many instants.
        style: Where the pictures look from, and the size of one panel.
    """
    painter = Painter(scenes, style, beside=False)
    width, height = FINER * style.width, FINER * style.height
    head, count = round(HEAD * height), len(scenes[0].time)
    strip = Image.new("RGB", (width * count, (height + head) * len(scenes)), PAPER)
    u = height / 1000.0
    pen = Pen(strip, u)
    for row, scene in enumerate(scenes):
        top = row * (height + head)
        for column in range(count):
            panel = painter.panel(row, column)
            label = Pen(panel, u)
            label.text((24 * u, 20 * u), f"{scene.time[column]:.2f} s", 52, bold=True)
            if scene.fallen(column):
                label.tag((24 * u, 92 * u), f"FELL: {scene.fall_cause}", 44)
            strip.paste(panel, (column * width, top + head))
        pen.text((24 * u, top + 22 * u), scene.title, 60, bold=True)
        pen.text((24 * u, top + 100 * u), scene.caption, 42, colour=GREY)
    return strip.reduce(FINER)


def still_figure(
    shown: Recorded, instants: Sequence[float] | np.ndarray, *, view: View = "board"
) -> Figure:
    """Instants of one trial side by side at one scale, each titled with its clock.

    Args:
        shown: The trial.
        instants: In [s] since walking at full amplitude began.
        view: Where to look from; by default at a board with the robot on it.
    """
    scene, alone = scene_of(shown, instants), len(instants) == 1
    across = PORTRAIT if alone else min(PANEL, PAGE / len(instants))
    wide, high = round(SCREEN_DPI * across), round(SCREEN_DPI * TALLER * across)
    painter = Painter((scene,), Style(view=view, width=wide, height=high))
    with style():
        figure = new_figure(across * len(instants), TALLER * across + (0.0 if alone else 0.3))
        panels = figure.subplots(1, len(instants), squeeze=False)[0]
        for frame, axes in enumerate(panels):
            axes.imshow(painter.panel(0, frame), interpolation="antialiased")
            axes.set_axis_off()
            if not alone:
                axes.set_title(f"{scene.time[frame]:.2f} s", loc="center", weight="normal")
        note = {"ha": "center", "va": "bottom", "fontsize": 7.5}
        panels[0].text(0.5, 0.01, SCALE, transform=panels[0].transAxes, **note)
    return figure
