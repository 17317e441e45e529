"""Which instants of one or two trials a film shows, and how fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from gaitlab.errors import UsageError
from gaitlab.log import TrialLog
from gaitlab.render.take import span_of

HOLD = 1.0  # s of film in which the last picture of a recording stands still
FASTEST = 240.0  # frames/s
MOST_FRAMES = 20000


@dataclass(frozen=True, kw_only=True)
class Cut:
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


def cut_of(
    logs: Sequence[TrialLog],
    *,
    begin: float | None = None,
    end: float | None = None,
    fps: float = 25.0,
    speed: float = 1.0,
) -> Cut:
    """A cut of trials on one clock; by default all that any of them recorded.

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
    cut = Cut(begin=max(begin, first), end=min(end, last), fps=fps, speed=speed, hold=hold)
    if (cut.end - cut.begin) * fps / speed > MOST_FRAMES:
        raise UsageError(
            f"more than {MOST_FRAMES} frames; shorten --from to --to, lower --fps or raise --speed"
        )
    return cut
