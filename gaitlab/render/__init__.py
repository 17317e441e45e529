"""Pictures of robots and trials, drawn from their logs: films, stills, files of other tools.

Here belong scene, camera and figure style; what a page says about a picture is in
`gaitlab.report`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gaitlab.render.camera import View
    from gaitlab.render.clip import Clip, clip_of
    from gaitlab.render.replay import Written, play, write_replay
    from gaitlab.render.scene import Recorded

__all__ = ["Clip", "Recorded", "View", "Written", "clip_of", "play", "write_replay"]

_PLACES = {
    "View": "camera",
    **dict.fromkeys(("Clip", "clip_of"), "clip"),
    **dict.fromkeys(("Written", "play", "write_replay"), "replay"),
    "Recorded": "scene",
}


def __getattr__(name: str) -> object:
    """What draws is loaded when it is asked for: a page may need colours alone."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
