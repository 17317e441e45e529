"""How every figure of gaitlab looks: one place for fonts, colours, sizes and file formats.

References:
    Okabe2008: M. Okabe and K. Ito, Color Universal Design: how to make figures and presentations
        that are friendly to colorblind people, 2008.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from gaitlab.documents.printable import visible
from gaitlab.documents.steps import step

if TYPE_CHECKING:  # loaded when something is drawn: a page whose figures are there needs none
    from matplotlib.artist import Artist
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from matplotlib.text import Text

# [Okabe2008], ordered so that neighbours also differ in lightness when printed in grey.
BLACK, BLUE, VERMILLION, SKY = "#000000", "#0072B2", "#D55E00", "#56B4E9"
GREEN, ORANGE, PURPLE, YELLOW = "#009E73", "#E69F00", "#CC79A7", "#F0E442"
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION, BLACK, YELLOW)
INK, FAINT, PAPER = "#222222", "#BBBBBB", "#FFFFFF"
BAND = "#EBEBEB"  # behind a curve: a span of time

TEXT_WIDTH = 8.0  # in, the width of a page of a code-hosting site at SCREEN_DPI
SCREEN_DPI = 150  # 1/in, sharp on a screen of double density

# Lightness falls evenly from none to all, so the order survives a grey printer. None of it is a
# grey, nor are the letters on it: on a dark page, where greys turn about, a share keeps its colour.
SHARES = ("#E9F2FB", "#BFD9EC", "#5E9FCC", "#08467A")
ON_DARK, ON_LIGHT = "#FFFFF2", "#00000D"
DARK = 0.8  # share above which white letters read better than black ones

_RC: dict[Any, Any] = {  # matplotlib spells out every key as a type
    "font.family": "DejaVu Sans",  # ships with matplotlib: the same letters on every machine
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.axisbelow": True,
    "text.color": INK,
    "text.parse_math": False,  # a name with two dollar signs is no formula
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "figure.dpi": SCREEN_DPI,
    "hatch.linewidth": 0.6,
    "svg.hashsalt": "gaitlab",  # identifiers in the SVG do not change from run to run
    "svg.fonttype": "path",
}


_VECTOR: ContextVar[bool] = ContextVar("vector", default=False)


@contextmanager
def vector_figures(wanted: bool = True) -> Iterator[None]:
    """Whether `save` writes each figure as SVG too, for a form of a page that zooms or is set."""
    token = _VECTOR.set(wanted)
    try:
        yield
    finally:
        _VECTOR.reset(token)


def suffixes() -> tuple[str, ...]:
    """Endings of the files that `save` writes."""
    return (".png", ".svg") if _VECTOR.get() else (".png",)


def wrapped(text: str, width: int) -> str:
    """A title on as many lines as it needs, at most three; a number keeps its unit."""
    return fill(text.replace(" mm", "\N{NO-BREAK SPACE}mm"), width, max_lines=3, placeholder=" …")


def surface_text(name: str) -> str:
    """A surface as a reader calls it: `grass_50mm` becomes `grass 50 mm`."""
    stem = name.rpartition("/")[2].removesuffix(".yaml")
    return re.sub(r"(?<!\S)(\d+)mm(?!\S)", r"\1 mm", " ".join(stem.replace("_", " ").split()))


@cache
def share_colours() -> Colormap:
    """The colours of shares from 0 to 1."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("share", SHARES)


def letters_on(share: float) -> str:
    """Colour of letters on the colour of a share from 0 to 1."""
    return ON_DARK if share > DARK else ON_LIGHT


@contextmanager
def style() -> Iterator[None]:
    """Settings that hold while a figure is made and saved."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def new_figure(width: float = TEXT_WIDTH, height: float = 3.0) -> Figure:
    """An empty figure of a size in inches, independent of any display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _lay_out(figure: Figure) -> None:
    """Place everything once for all formats, to a millionth of the page.

    The solver's last digits differ from run to run and would be hashed into names in the SVG.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    figure.set_layout_engine(None)  # "none" would have every format drawn once more for nothing
    for axes in figure.axes:
        x, y, width, height = (round(v, 6) for v in axes.get_position(original=True).bounds)
        axes.set_position((x, y, width, height))


def _show_whatever_is_written(figure: Figure) -> None:
    """Write out control characters, of which no font has a picture and no SVG may hold one."""
    from matplotlib.ticker import ScalarFormatter

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if isinstance(axis.get_major_formatter(), ScalarFormatter):
                continue  # numbers
            texts = [label.get_text() for label in axis.get_ticklabels()]
            if any(text != visible(text) for text in texts):
                axis.set_ticks(axis.get_ticklocs(), list(map(visible, texts)))
    for text in _texts(figure):
        text.set_text(visible(text.get_text()))


def _texts(artist: Artist) -> Iterator[Text]:
    """Every text within but for those of ticks, which `findobj` would make just to be looked at."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    for child in artist.get_children():
        if isinstance(child, Text):
            yield child
        elif isinstance(child, Axis):
            yield child.label
        else:
            yield from _texts(child)


def save(figure: Figure, folder: Path, name: str) -> Path:
    """Write `name`.png, and `name`.svg within `vector_figures`; the same figure, the same bytes."""
    step(f"drawing {name}")
    png = folder / f"{name}.png"
    with style():
        _show_whatever_is_written(figure)
        _lay_out(figure)
        figure.savefig(png, dpi=SCREEN_DPI, metadata={"Software": None})
        if ".svg" in suffixes():
            svg = png.with_suffix(".svg")
            figure.savefig(svg, metadata={"Date": None, "Creator": None})
    return png
