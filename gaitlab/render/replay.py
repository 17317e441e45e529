"""A trial shown from its log: in 3-D, as a film, a strip or a drawing, or in a window.

Nothing is simulated again.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL.PngImagePlugin import PngInfo

from gaitlab.documents.outputs import MARK, refuse_other, replaced
from gaitlab.errors import GaitlabError, UsageError
from gaitlab.log import TrialLog
from gaitlab.render.camera import View
from gaitlab.render.clip import Clip, frames, require_encoder, write_gif, write_mp4
from gaitlab.render.painter import Painter, Style
from gaitlab.render.replay_page import Replay, three_js, write_replay_page
from gaitlab.render.scene import Recorded, joints_of, scene_of, ticks_at
from gaitlab.render.stills import filmstrip, still_figure

STARTS = {
    ".gif": b"GIF8",
    ".mp4": b"\0\0\0",
    ".png": b"\x89PNG",
    ".svg": b"<?xml",
    ".html": b"<!DOCTYPE html>",
}
FILMS = (".gif", ".mp4")
SIZES = {  # pixels; of a strip's panel
    ".gif": (480, 360),
    ".mp4": (1280, 720),
    ".png": (360, 420),
    ".svg": (750, 780),
    ".html": (1280, 800),  # it fits every window
}
BESIDE = SIZES | {".gif": (640, 360)}  # of two trials
SMALLEST, LARGEST = 160, 3840  # pixels
SAMPLES = 3  # pictures that decide on the colours of a GIF
RATE = 60.0  # pictures a second
PAUSE = 1.0  # s between the end and the next beginning
WITHOUT = "--output fall.html, walk.gif, walk.mp4, strip.png and frame.svg need no screen"


class NoScreen(GaitlabError):
    """There is no screen to open a window on."""

    exit_code = 2


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
    clip: Clip,
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
        path: An `.html` page in 3-D, a `.gif` or `.mp4` film, a `.png` strip, or one `.svg` drawing
            of the last instant.
        clip: Which instants.
        view: Where to look from.
        size: Width and height in pixels, of a panel for a strip; by default that of the kind.
        panels: Instants on a strip.
        jobs: How many processes paint a film.
        force: Also replace a file that gaitlab did not write.

    Raises:
        UsageError: If path or size are not allowed, two trials are asked of a drawing, or a file is
            there that gaitlab did not write.
        NoEncoder: If an MP4 is asked for and there is no ffmpeg.
        NoViewer: If a page is asked for and the installed trimesh ships no three.js.
        StoreError: If the file cannot be written.
    """
    kind = checked_kind(path)
    refuse_other(path, STARTS[kind], force=force)
    width, height = checked_size(size or (BESIDE if len(shown) > 1 else SIZES)[kind])
    style = Style(view=view, width=width, height=height, span=(clip.begin, clip.end))
    pictures, duration = 1, 0.0
    if kind == ".html":
        pictures = write_replay_page([Replay(trial, clip) for trial in shown], path, view=view)
        duration = (clip.end - clip.begin) / clip.speed
    elif kind in FILMS:
        _write_film(shown, path, clip, style, jobs)
        pictures, duration = len(clip.instants), clip.duration
    elif kind == ".png":
        instants, facts = clip.spread(panels), PngInfo()
        facts.add_text("Software", MARK)
        strip = filmstrip(tuple(scene_of(trial, instants) for trial in shown), style)
        with replaced(path) as part:
            strip.save(part, pnginfo=facts)
        pictures = panels * len(shown)
    else:
        _write_drawing(shown, path, clip, view)
    return Written(path, path.stat().st_size, pictures, duration)


def checked_kind(path: Path) -> str:
    """What a file will be, by its ending.

    Raises:
        UsageError: If it is none that a replay writes.
        NoEncoder: If it is an MP4 and there is no ffmpeg.
        NoViewer: If it is a page and the installed trimesh ships no three.js.
    """
    kind = path.suffix.lower()
    if kind not in SIZES or path.is_dir():
        found = f"found {kind!r}" if kind else "found no ending"
        raise UsageError(
            f"--output {path}: {'a folder' if path.is_dir() else found}; allowed is a file ending "
            "in .html (3-D), .gif or .mp4 (a film), .png (a strip of instants) or .svg (a drawing)"
        )
    if kind == ".mp4":
        require_encoder()
    elif kind == ".html":
        three_js()
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


def _write_film(shown: Sequence[Recorded], path: Path, clip: Clip, style: Style, jobs: int) -> None:
    instants = clip.instants
    scenes = tuple(scene_of(trial, instants) for trial in shown)
    pictures = frames(scenes, style, instants, jobs)
    if path.suffix.lower() == ".mp4":
        write_mp4(path, pictures, clip.fps, clip.held)
        return
    painter = Painter(scenes, style)
    sampled = np.unique(np.linspace(0, len(instants) - 1, SAMPLES).astype(int))
    samples = [painter.frame(int(k), float(instants[k])) for k in sampled]
    write_gif(path, pictures, samples, clip.fps, clip.held)


def _write_drawing(shown: Sequence[Recorded], path: Path, clip: Clip, view: View) -> None:
    if len(shown) > 1:
        raise UsageError(f"--output {path}: a drawing shows one trial; .png, .gif and .mp4 two")
    figure = still_figure(shown[0], [clip.end], view=view)
    with replaced(path) as part:
        figure.savefig(part, metadata={"Date": None, "Creator": MARK})


def play(shown: Recorded, clip: Clip) -> None:
    """Play a trial again and again until its window is closed.

    Raises:
        NoScreen: If no window can be opened here.
    """
    if find_spec("pybullet") is None:
        raise NoScreen(f"the window is PyBullet's, which is not installed here. {WITHOUT}.")
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise NoScreen(f"no screen: DISPLAY is not set. {WITHOUT}.")
    # Bullet ends the process that cannot open a window, so it is one of its own.
    player = get_context("spawn").Process(
        target=_play, args=(shown.trial.to_dict(), shown.log, clip)
    )
    player.start()
    try:
        player.join()
    finally:
        if player.is_alive():
            player.terminate()
            player.join()
    if player.exitcode:
        display = os.environ.get("DISPLAY", "")
        raise NoScreen(f"no window could be opened (DISPLAY is {display!r}). {WITHOUT}.")


def _play(described: Mapping[str, object], log: TrialLog, clip: Clip) -> None:
    from gaitlab.simulation.bullet.window import Window
    from gaitlab.simulation.trial import Trial

    trial = Trial.from_dict(described)
    window = Window(trial.robot, trial.surface, log.header.standing_height)
    position, quaternion = log.vector("trunk_"), log.vector("trunk_q", "xyzw")
    joints = joints_of(trial.robot.tree, log)
    started = time.monotonic()
    while window.open:
        passed = (time.monotonic() - started) * clip.speed
        now = clip.begin + passed % (clip.end - clip.begin + PAUSE * clip.speed)
        tick = ticks_at(log, [min(now, clip.end)])[0]
        window.show(position[tick], quaternion[tick], joints[tick])
        time.sleep(1.0 / RATE)
