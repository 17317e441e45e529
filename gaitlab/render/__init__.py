"""Films of trials, drawn from their logs."""

from gaitlab.render.cut import Cut, cut_of
from gaitlab.render.lens import View
from gaitlab.render.replay import Written, write_replay
from gaitlab.render.take import Recorded
from gaitlab.render.window import play

__all__ = ["Cut", "Recorded", "View", "Written", "cut_of", "play", "write_replay"]
