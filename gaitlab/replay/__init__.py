"""Films of trials, drawn from their logs."""

from gaitlab.replay.cut import Cut, cut_of
from gaitlab.replay.lens import View
from gaitlab.replay.replay import Written, write_replay
from gaitlab.replay.take import Recorded
from gaitlab.replay.window import play

__all__ = ["Cut", "Recorded", "View", "Written", "cut_of", "play", "write_replay"]
