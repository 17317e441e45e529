"""A trial played in a window, where there is a screen."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from multiprocessing import get_context

import numpy as np

from gaitlab.errors import GaitlabError
from gaitlab.log import TrialLog
from gaitlab.render.cut import Cut
from gaitlab.render.take import Recorded

RATE = 60.0  # pictures a second
PAUSE = 1.0  # s between the end and the next beginning
WITHOUT = "--output walk.gif, walk.mp4, strip.png and frame.svg work without a screen"


class NoScreen(GaitlabError):
    """There is no screen to open a window on."""

    exit_code = 2


def play(shown: Recorded, cut: Cut) -> None:
    """Play a trial again and again until its window is closed.

    Raises:
        NoScreen: If no window can be opened here.
    """
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise NoScreen(f"no screen: DISPLAY is not set. {WITHOUT}.")
    # Bullet ends the process that cannot open a window, so it is one of its own.
    player = get_context("spawn").Process(
        target=_play, args=(shown.trial.to_dict(), shown.log, cut)
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


def _play(described: Mapping[str, object], log: TrialLog, cut: Cut) -> None:
    from gaitlab.simulation.trial import Trial
    from gaitlab.simulation.window import Window

    trial = Trial.from_dict(described)
    clock = log["time"] - log.header.startup_time
    window = Window(trial.robot, trial.surface, log.header.standing_height)
    position, quaternion = log.vector("trunk_"), log.vector("trunk_q", "xyzw")
    joints = log.joint_table("position")[:, : len(trial.robot.tree.joints)]
    started = time.monotonic()
    while window.open:
        passed = (time.monotonic() - started) * cut.speed
        now = cut.begin + passed % (cut.end - cut.begin + PAUSE * cut.speed)
        tick = min(int(np.searchsorted(clock, min(now, cut.end) - 1e-6)), len(log) - 1)
        window.show(position[tick], quaternion[tick], joints[tick])
        time.sleep(1.0 / RATE)
