"""A few instants of one or two trials side by side in one picture."""

from __future__ import annotations

from collections.abc import Sequence

from PIL import Image

from gaitlab.render.colours import INK, PAPER, VERMILLION
from gaitlab.render.overlay import GREY, Pen
from gaitlab.render.painter import Painter, Style
from gaitlab.render.raster import FINER
from gaitlab.render.take import Take

HEAD = 0.17  # of the height of a panel, above each row


def filmstrip(takes: tuple[Take, ...], style: Style, instants: Sequence[float]) -> Image.Image:
    """A row for each trial, a panel for each instant.

    Args:
        takes: Trials at the instants.
        style: Where the film looks from, and the size of one panel.
        instants: On the clock, in [s].
    """
    painter = Painter(takes, style, beside=False)
    width, height = FINER * style.width, FINER * style.height
    head = round(HEAD * height)
    strip = Image.new("RGB", (width * len(instants), (height + head) * len(takes)), PAPER)
    pen = Pen(strip, height / 1000.0)
    for row, take in enumerate(takes):
        top = row * (height + head)
        for column in range(len(instants)):
            panel = painter.panel(row, column)
            _label(Pen(panel, height / 1000.0), take, column)
            strip.paste(panel, (column * width, top + head))
        u = pen.unit
        pen.text((24 * u, top + 22 * u), take.title, 60, bold=True)
        pen.text((24 * u, top + 100 * u), take.caption, 42, colour=GREY)
    return strip.reduce(FINER)


def _label(pen: Pen, take: Take, frame: int) -> None:
    """The clock of a panel, and the fall."""
    u, time = pen.unit, f"{take.time[frame]:.2f} s"
    pen.text((24 * u, 20 * u), time, 52, colour=INK, bold=True)
    if take.fallen(frame):
        text = f"FELL: {take.fall_cause}"
        low, width = (24 * u, 92 * u), pen.width(text, 44, bold=True) + 40 * u
        pen.box(low, (low[0] + width, low[1] + 66 * u), VERMILLION)
        place = (low[0] + 20 * u, low[1] + 33 * u)
        pen.text(place, text, 44, colour=PAPER, anchor="lm", bold=True)
