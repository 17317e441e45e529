"""A film, a strip or a drawing of trials from their logs; nothing is simulated again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL.PngImagePlugin import PngInfo

from gaitlab.documents.outputs import MARK, refuse_other, replaced
from gaitlab.errors import UsageError
from gaitlab.render.cut import Cut
from gaitlab.render.files import require_encoder, write_gif, write_mp4
from gaitlab.render.lens import CAMERAS, View
from gaitlab.render.painter import Painter, Style
from gaitlab.render.strip import filmstrip
from gaitlab.render.studio import frames
from gaitlab.render.take import Recorded, take_of

STARTS = {".gif": b"GIF8", ".mp4": b"\0\0\0", ".png": b"\x89PNG", ".svg": b"<?xml"}
FILMS, STILLS = (".gif", ".mp4"), (".png", ".svg")
SIZES = {".gif": (480, 360), ".mp4": (1280, 720), ".png": (360, 420)}  # pixels; a strip's panel
BESIDE = {".gif": (640, 360), ".mp4": (1280, 720), ".png": (360, 420)}  # of two trials
SMALLEST, LARGEST = 160, 3840  # pixels
SAMPLES = 3  # pictures that decide on the colours of a GIF
INCH = 150.0  # pixels


class Written(NamedTuple):
    """What a replay wrote.

    Attributes:
        path: The file.
        size: Its size, in [bytes].
        pictures: How many instants it shows.
        duration: Length of a film, in [s]; 0 for a still.
    """

    path: Path
    size: int
    pictures: int
    duration: float


def write_replay(
    shown: Sequence[Recorded],
    path: Path,
    cut: Cut,
    *,
    view: View = "perspective",
    size: tuple[int, int] | None = None,
    panels: int = 6,
    jobs: int = 1,
    force: bool = False,
) -> Written:
    """Draw one trial, or two side by side on one clock, into a file.

    Args:
        shown: One or two trials.
        path: A `.gif` or `.mp4` film, a `.png` strip, or one `.svg` drawing of the last instant.
        cut: Which instants.
        view: Where to look from.
        size: Width and height in pixels, of a panel for a strip; by default that of the kind.
        panels: Instants on a strip.
        jobs: How many processes paint a film.
        force: Also replace a file that gaitlab did not write.

    Raises:
        UsageError: If path or size are not allowed, two trials are asked of a drawing, or a file is
            there that gaitlab did not write.
        NoEncoder: If an MP4 is asked for and there is no ffmpeg.
        StoreError: If the file cannot be written.
    """
    kind = checked_kind(path)
    refuse_other(path, STARTS[kind], force=force)
    wide = checked_size(size or (BESIDE if len(shown) > 1 else SIZES).get(kind, (750, 780)))
    style = Style(view=view, width=wide[0], height=wide[1], span=(cut.begin, cut.end))
    if kind in FILMS:
        _write_film(shown, path, cut, style, jobs)
        return Written(path, path.stat().st_size, len(cut.instants), cut.duration)
    if kind == ".png":
        takes = tuple(take_of(each, cut.spread(panels).tolist()) for each in shown)
        with replaced(path) as part:
            facts = PngInfo()
            facts.add_text("Software", MARK)
            filmstrip(takes, style, cut.spread(panels).tolist()).save(part, pnginfo=facts)
        return Written(path, path.stat().st_size, panels * len(shown), 0.0)
    _write_drawing(shown, path, cut, style)
    return Written(path, path.stat().st_size, 1, 0.0)


def checked_kind(path: Path) -> str:
    """What a file will be, by its ending.

    Raises:
        UsageError: If it is none that a replay writes.
    """
    kind = path.suffix.lower()
    if kind not in (*FILMS, *STILLS) or path.is_dir():
        found = f"found {kind!r}" if kind else "found no ending"
        raise UsageError(
            f"--output {path}: {'a folder' if path.is_dir() else found}; allowed is a file ending "
            "in .gif or .mp4 (a film), .png (a strip of instants) or .svg (one drawing)"
        )
    if kind == ".mp4":
        require_encoder()
    return kind


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """A size that video encoders take: both even.

    Raises:
        UsageError: If it is too small or too large.
    """
    if not all(SMALLEST <= edge <= LARGEST for edge in size):
        raise UsageError(
            f"--size {size[0]}x{size[1]}: each edge is {SMALLEST} to {LARGEST} pixels long"
        )
    return size[0] - size[0] % 2, size[1] - size[1] % 2


def _write_film(shown: Sequence[Recorded], path: Path, cut: Cut, style: Style, jobs: int) -> None:
    instants = cut.instants
    takes = tuple(take_of(each, instants.tolist()) for each in shown)
    pictures = frames(takes, style, instants.tolist(), jobs)
    if path.suffix.lower() == ".mp4":
        write_mp4(path, pictures, cut.fps, cut.held)
        return
    painter = Painter(takes, style)
    places = np.unique(np.linspace(0, len(instants) - 1, SAMPLES).astype(int))
    samples = [painter.frame(int(k), float(instants[k])) for k in places]
    write_gif(path, pictures, samples, cut.fps, cut.held)


def _write_drawing(shown: Sequence[Recorded], path: Path, cut: Cut, style: Style) -> None:
    from gaitlab.render.portrait import portrait
    from gaitlab.render.robot import stance_at

    if len(shown) > 1:
        raise UsageError(f"--output {path}: a drawing shows one trial; .png, .gif and .mp4 two")
    _, trial, log = shown[0]
    clock = log["time"] - log.header.startup_time
    tick = min(int(np.searchsorted(clock, cut.end - 1e-6)), len(log) - 1)
    robot = trial.robot
    stance = stance_at(log, robot.tree, robot.sole, tick, robot.feet)
    figure = portrait(stance, trial.surface, camera=CAMERAS[style.view])
    with replaced(path) as part:
        figure.savefig(part, metadata={"Date": None, "Creator": MARK})
