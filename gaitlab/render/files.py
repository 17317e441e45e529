"""Films and strips as files."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from itertools import chain, repeat
from pathlib import Path

import numpy as np
from PIL import Image

from gaitlab.documents.outputs import MARK, replaced
from gaitlab.errors import GaitlabError, UsageError
from gaitlab.render.colours import BLUE, INK, PAPER, VERMILLION
from gaitlab.render.lawn import BOARD_COLOUR
from gaitlab.render.overlay import GREY
from gaitlab.render.robot import ALUMINIUM, DARK, ORANGE
from gaitlab.render.studio import palette_of

CENTISECOND = 0.01  # s, what a GIF counts its pictures in
BROWSERS = 50.0  # frames/s; browsers slow down a GIF that asks for more
COLOURS = 64  # of a GIF; grass needs a dozen greens, the rest are greys
MARKS = (PAPER, INK, BLUE, VERMILLION, ORANGE, GREY, DARK, ALUMINIUM, BOARD_COLOUR, "#000000")
QUALITY = 21  # constant rate factor of H.264; 18 is visually lossless, 28 is coarse


class NoEncoder(GaitlabError):
    """This machine cannot write videos."""

    exit_code = 2


def require_encoder() -> None:
    """Refuse a video before its pictures are painted.

    Raises:
        NoEncoder: If there is no ffmpeg.
    """
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        # A name in IMAGEIO_FFMPEG_EXE is given back untried.
        found = shutil.which(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        found = None
    if found is None:
        raise NoEncoder(
            "no ffmpeg was found, so no MP4 can be written; `pip install imageio-ffmpeg` brings "
            "one. --output walk.gif, strip.png and frame.svg work without it."
        )


def write_gif(
    path: Path, pictures: Iterable[Image.Image], samples: list[Image.Image], fps: float, held: int
) -> None:
    """An endless GIF.

    Args:
        path: Where to.
        pictures: In order.
        samples: Some of them, which decide on the colours.
        fps: In [1/s].
        held: How many frames more the last picture is shown.

    Raises:
        UsageError: If a GIF cannot be that fast.
    """
    if fps > BROWSERS:
        raise UsageError(f"--fps {fps:g}: a GIF shows up to {BROWSERS:g} frames/s; or write an MP4")
    palette = palette_of(samples, COLOURS, MARKS)
    plain = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    first = next(plain)
    durations = _centiseconds(fps)
    rest = list(plain)
    lengths = [next(durations) for _ in range(len(rest) + 1)]
    lengths[-1] += round(100.0 * held / fps)
    with replaced(path) as part:
        first.save(
            part,
            save_all=True,
            append_images=rest,
            duration=[10 * length for length in lengths],
            loop=0,
            optimize=False,
            disposal=1,
            comment=MARK.encode(),
        )


def _centiseconds(fps: float) -> Iterator[int]:
    """How long each picture stands so that rounding never adds up."""
    shown, k = 0, 0
    while True:
        k += 1
        until = round(k / fps / CENTISECOND)
        yield until - shown
        shown = until


def write_mp4(path: Path, pictures: Iterable[Image.Image], fps: float, held: int) -> None:
    """A video that every player and slide deck shows: H.264, yuv420p.

    Args:
        path: Where to.
        pictures: In order, of even width and height.
        fps: In [1/s].
        held: How many frames more the last picture is shown.

    Raises:
        NoEncoder: If there is no ffmpeg.
    """
    import imageio.v2 as imageio

    require_encoder()
    with replaced(path) as part:
        writer = imageio.get_writer(
            part,
            format="FFMPEG",
            mode="I",
            fps=fps,
            codec="libx264",
            pixelformat="yuv420p",
            macro_block_size=2,
            quality=None,
            output_params=[
                *("-crf", str(QUALITY), "-preset", "veryfast", "-movflags", "+faststart"),
                *("-metadata", f"comment={MARK}"),
            ],
        )
        with writer:
            last = None
            for picture in pictures:
                last = np.asarray(picture)
                writer.append_data(last)
            for still in chain(() if last is None else repeat(last, held)):
                writer.append_data(still)
