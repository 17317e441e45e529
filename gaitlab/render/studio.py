"""The frames of a film, painted one after another or by several processes at once."""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from itertools import islice
from multiprocessing import get_context

import numpy as np
from PIL import Image, ImageColor

from gaitlab.render.painter import Painter, Style
from gaitlab.render.take import Take

ALONE = 30  # frames; for fewer it does not pay to start processes
AHEAD = 6  # frames that each process may be ahead of the file

ALIKE = 12  # of 255; a found colour this near a mark's gives way to it

_painter: Painter | None = None  # of a worker process


def frames(
    takes: tuple[Take, ...], style: Style, instants: Sequence[float], jobs: int
) -> Iterator[Image.Image]:
    """The pictures of a film in order.

    Args:
        takes: One or two trials at the instants.
        style: How the film looks.
        instants: On the clock, in [s].
        jobs: How many processes paint.
    """
    if jobs < 2 or len(instants) < ALONE:
        painter = Painter(takes, style)
        for index, now in enumerate(instants):
            yield painter.frame(index, float(now))
        return
    size = (style.width, style.height)
    with ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_prepare, initargs=(takes, style)
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
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare(takes: tuple[Take, ...], style: Style) -> None:
    global _painter
    _painter = Painter(takes, style)


def _paint(index: int, now: float) -> bytes:
    if _painter is None:
        raise RuntimeError("a worker paints only after it was prepared")
    return _painter.frame(index, now).tobytes()


def palette_of(pictures: Sequence[Image.Image], colours: int, marks: Sequence[str]) -> Image.Image:
    """A picture whose palette suits all pictures and holds the colours of the marks exactly."""
    together = Image.fromarray(np.concatenate([np.asarray(picture) for picture in pictures]))
    found = together.quantize(colours - len(marks), dither=Image.Dither.NONE).getpalette() or []
    exact = np.array([ImageColor.getrgb(mark) for mark in marks])
    others = np.reshape(found, (-1, 3))
    apart = np.abs(others[:, None] - exact).max(axis=2).min(axis=1) > ALIKE
    palette = Image.new("P", (1, 1))
    palette.putpalette([*exact.ravel().tolist(), *others[apart].ravel().tolist()])
    return palette
