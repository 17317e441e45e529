"""Pictures of robots and trials, drawn from their logs: films, stills, files of other tools.

Here belong scene, camera and figure style; what a page says about a picture is in
`gaitlab.report`.
"""

from gaitlab.render.cut import Cut, cut_of
from gaitlab.render.lens import View
from gaitlab.render.replay import Written, write_replay
from gaitlab.render.take import Recorded
from gaitlab.render.window import play

__all__ = ["Cut", "Recorded", "View", "Written", "cut_of", "play", "write_replay"]
