"""Films of trials, drawn from their logs."""

from gaitlab.replay.cut import Cut, cut_of
from gaitlab.replay.lens import View
from gaitlab.replay.replay import Recorded, Written, write_replay

__all__ = ["Cut", "Recorded", "View", "Written", "cut_of", "write_replay"]
