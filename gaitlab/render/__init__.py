"""Pictures of robots and trials, drawn from their logs: films, stills, files of other tools.

Here belong scene, camera and figure style; what a page says about a picture is in
`gaitlab.report`.
"""

from gaitlab.render.camera import View
from gaitlab.render.clip import Clip, clip_of
from gaitlab.render.replay import Written, play, write_replay
from gaitlab.render.scene import Recorded

__all__ = ["Clip", "Recorded", "View", "Written", "clip_of", "play", "write_replay"]
