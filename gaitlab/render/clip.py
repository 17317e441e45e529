"""A film: the instants of one or two trials that it shows, who paints them, its file."""

from __future__ import annotations

import shutil
import signal
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from math import isfinite
from multiprocessing import get_context
from multiprocessing.resource_tracker import ensure_running
from pathlib import Path

import numpy as np
from PIL import Image, ImageColor

from gaitlab.documents.outputs import MARK, replaced
from gaitlab.errors import GaitlabError, UsageError
from gaitlab.log import TrialLog
from gaitlab.render.figure_style import BLUE, INK, PAPER, VERMILLION
from gaitlab.render.ground import BOARD_COLOUR
from gaitlab.render.overlay import GREY
from gaitlab.render.painter import Painter, Style
from gaitlab.render.scene import ALUMINIUM, DARK, ORANGE, Scene, span_of

HOLD = 1.0  # s of film in which the last picture of a recording stands still
FASTEST = 240.0  # frames/s
MOST_FRAMES = 20000
ALONE = 30  # frames; for fewer it does not pay to start processes
AHEAD = 6  # frames that each process may be ahead of the file
CENTISECOND = 0.01  # s, what a GIF counts its pictures in
BROWSERS = 50.0  # frames/s; browsers slow down a GIF that asks for more
COLOURS = 64  # of a GIF; grass needs a dozen greens, the rest are greys
MARKS = (PAPER, INK, BLUE, VERMILLION, ORANGE, GREY, DARK, ALUMINIUM, BOARD_COLOUR, "#000000")
ALIKE = 12  # of 255; a colour of the pictures this near a mark's gives way to it
QUALITY = 21  # constant rate factor of H.264; 18 is visually lossless, 28 is coarse

_painter: Painter | None = None  # of a worker process


class NoEncoder(GaitlabError):
    """This machine cannot write videos."""

    exit_code = 2


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A piece of the clock, in [s] since walking at full amplitude began.

    Attributes:
        begin: First instant, in [s].
        end: Last instant, in [s].
        fps: Frames in a second of film, in [1/s].
        speed: Seconds of walking in a second of film.
        hold: How long the last picture stands still, in [s] of film.
    """

    begin: float
    end: float
    fps: float = 25.0
    speed: float = 1.0
    hold: float = HOLD

    @property
    def instants(self) -> np.ndarray:
        """Instants of the moving frames, the end among them, in [s]. Shape (n,)."""
        step = self.speed / self.fps
        inner = self.begin + step * np.arange(int((self.end - self.begin) / step + 1e-6) + 1)
        past = self.end - inner[-1] > 1e-3 * step
        return np.append(inner, self.end) if past else inner

    @property
    def held(self) -> int:
        """How many frames more the last picture is shown."""
        return round(self.hold * self.fps)

    @property
    def duration(self) -> float:
        """Length of the film, in [s]."""
        return (len(self.instants) + self.held) / self.fps

    def spread(self, count: int) -> np.ndarray:
        """A few instants from begin to end; the end alone for one, in [s]. Shape (count,)."""
        return np.linspace(self.begin, self.end, count) if count > 1 else np.array([self.end])


def clip_of(
    logs: Sequence[TrialLog],
    *,
    begin: float | None = None,
    end: float | None = None,
    fps: float = 25.0,
    speed: float = 1.0,
) -> Clip:
    """A clip of trials on one clock; by default all that any of them recorded.

    Raises:
        UsageError: If nothing was recorded in between, or a number is not allowed.
    """
    for name, value, most in (("fps", fps, FASTEST), ("speed", speed, 1000.0)):
        if not 0.0 < value <= most:
            raise UsageError(f"--{name} {value:g}: above 0 and up to {most:g} is allowed")
    first = min(span_of(log)[0] for log in logs)
    last = max(span_of(log)[1] for log in logs)
    begin, end = (first if begin is None else begin), (last if end is None else end)
    if not (isfinite(begin) and isfinite(end) and max(begin, first) <= min(end, last)):
        raise UsageError(
            f"--from {begin:g} --to {end:g}: nothing was recorded in between; the recording is "
            f"from {first:.2f} to {last:.2f} s, 0 is when walking at full amplitude begins"
        )
    hold = HOLD if end >= last else 0.0  # a piece out of the middle may loop
    clip = Clip(begin=max(begin, first), end=min(end, last), fps=fps, speed=speed, hold=hold)
    if (clip.end - clip.begin) * fps / speed > MOST_FRAMES:
        raise UsageError(
            f"more than {MOST_FRAMES} frames; shorten --from to --to, lower --fps or raise --speed"
        )
    return clip


def frames(
    scenes: tuple[Scene, ...], style: Style, instants: np.ndarray, jobs: int
) -> Iterator[Image.Image]:
    """The pictures of a film in order.

    Args:
        scenes: One or two trials at the instants.
        style: How the film looks.
        instants: On the clock, in [s]. Shape (n,).
        jobs: How many processes paint.
    """
    if jobs < 2 or len(instants) < ALONE:
        painter = Painter(scenes, style)
        for index, now in enumerate(instants):
            yield painter.frame(index, float(now))
        return
    size = (style.width, style.height)
    with ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_prepare, initargs=(scenes, style)
    ) as workers:
        orders = ((index, float(now)) for index, now in enumerate(instants))
        waiting: deque[Future[bytes]] = deque()
        try:
            with _deaf_children():
                first = islice(orders, AHEAD * jobs)
                waiting.extend(workers.submit(_paint, *order) for order in first)
            while waiting:
                painted = waiting.popleft().result()
                waiting.extend(workers.submit(_paint, *order) for order in islice(orders, 1))
                yield Image.frombytes("RGB", size, painted)
        finally:
            workers.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Processes started herein leave Ctrl-C to this one, already while they are being started."""
    ensure_running()  # as in `running.processes`: it makes all hear again as it starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare(scenes: tuple[Scene, ...], style: Style) -> None:
    global _painter
    _painter = Painter(scenes, style)


def _paint(index: int, now: float) -> bytes:
    if _painter is None:
        raise RuntimeError("a worker paints only after it was prepared")
    return _painter.frame(index, now).tobytes()


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
    palette = _palette_of(samples)
    plain = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    ends = np.rint(np.arange(len(plain) + 1) / fps / CENTISECOND)  # rounding never adds up
    lengths = np.diff(ends)
    lengths[-1] += round(held / fps / CENTISECOND)
    with replaced(path) as part:
        plain[0].save(
            part,
            save_all=True,
            append_images=plain[1:],
            duration=[round(1000.0 * CENTISECOND * length) for length in lengths],
            loop=0,
            optimize=False,
            disposal=1,
            comment=MARK.encode(),
        )


def _palette_of(pictures: Sequence[Image.Image]) -> Image.Image:
    """A picture whose palette suits all pictures and holds `MARKS` exactly."""
    together = Image.fromarray(np.concatenate([np.asarray(picture) for picture in pictures]))
    free = COLOURS - len(MARKS)
    fitting = together.quantize(free, dither=Image.Dither.NONE).getpalette() or []
    exact = np.array([ImageColor.getrgb(mark) for mark in MARKS])
    others = np.reshape(fitting, (-1, 3))
    apart = np.abs(others[:, None] - exact).max(axis=2).min(axis=1) > ALIKE
    palette = Image.new("P", (1, 1))
    palette.putpalette([*exact.ravel().tolist(), *others[apart].ravel().tolist()])
    return palette


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
            for picture in pictures:
                writer.append_data(np.asarray(picture))
            for _ in range(held):
                writer.append_data(np.asarray(picture))
