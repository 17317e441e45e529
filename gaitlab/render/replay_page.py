"""Trials in 3-D as one HTML file: to turn, to scrub and to set side by side, without a network.

Drawn by three.js in the browser, which trimesh ships for the viewer of its own; the page holds it,
so that it opens from a disk, a mail or a talk's laptop. Nothing is simulated again.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zipfile
from collections.abc import Iterable, Mapping
from functools import cache
from html import escape
from importlib import resources
from importlib.util import find_spec
from math import isinf
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np

from gaitlab.documents.outputs import MARK, write_text
from gaitlab.errors import GaitlabError
from gaitlab.render.camera import VIEWPOINTS, View
from gaitlab.render.clip import Clip
from gaitlab.render.scene import Recorded, span_of
from gaitlab.render.track import body_of, track_of

SCRIPTS = ("scene.js", "strip.js", "player.js")
SHORT = 8  # digits of a trial in an address
FAR = 4.5  # robot heights from the camera, where a view has none of its own
SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
TEMPLATE = ("resources", "templates", "viewer.zip")  # in trimesh
BEGIN, END = "<script>", '"__esModule",{value:!0})}));'  # around three.js in it


class NoViewer(GaitlabError):
    """three.js is not where trimesh is known to keep it."""

    exit_code = 2


class Replay(NamedTuple):
    """A trial of a page.

    Attributes:
        shown: The trial and its log.
        clip: Which instants.
        role: What it is there, `worst seed` for instance; may be empty.
    """

    shown: Recorded
    clip: Clip
    role: str = ""

    @property
    def instants(self) -> np.ndarray:
        """Those of the clip at which something was recorded, in [s]; at least one. Shape (n,)."""
        first, last = span_of(self.shown.log)
        return np.unique(np.clip(self.clip.instants, first, last))


def address(trial_id: str) -> str:
    """What follows the name of a page's file in a link to one of its trials."""
    return f"#{trial_id[:SHORT]}"


def write_replay_page(
    replays: Iterable[Replay],
    path: Path,
    *,
    title: str = "",
    menu: str = "",
    view: View = "perspective",
    first: str = "",
) -> int:
    """Write trials as one file of HTML.

    Args:
        replays: The trials; one at a time is held. Which of them are shown, an address in the page
            says: `#ID` or `#ID,OTHER`.
        path: The file, replaced once it is whole.
        title: Of the page; by default what its first trial is.
        menu: HTML beside the picture, whose links to `address` choose a trial.
        view: Where to look from at first.
        first: Id of the trial that it opens with; by default the first two are side by side.

    Returns:
        How many instants the longest of them has.

    Raises:
        NoViewer: If the installed trimesh ships no three.js.
        StoreError: If the file cannot be written.
    """
    robots: dict[str, Mapping[str, Any]] = {}
    trials: list[dict[str, Any]] = []
    speed = 1.0
    for replay in replays:
        speed = replay.clip.speed
        body = body_of(replay.shown.trial.robot)
        name = hashlib.sha256(json.dumps(body).encode()).hexdigest()[:SHORT]
        robots[name] = body
        track = track_of(replay.shown, replay.instants)
        trials.append({**track, "robot": name, "role": replay.role})
    point = VIEWPOINTS[view]
    content = {
        "trials": trials,
        "robots": robots,
        "shown": [k for k, track in enumerate(trials) if track["id"] == first]
        or [0, 1][: len(trials)],
        "menu": bool(menu),
        "view": {
            "azimuth": point.azimuth,
            "elevation": point.elevation,
            "distance": FAR if isinf(point.distance) else point.distance,
        },
    }
    heading = title or (f"{trials[0]['title']}: {trials[0]['verdict']}" if trials else MARK)
    write_text(path, _document(heading, menu, content, speed))
    return max((track["count"] for track in trials), default=0)


@cache
def three_js() -> str:
    """The library that draws, as trimesh ships it for its own viewer.

    Raises:
        NoViewer: If it is not there.
    """
    spec = find_spec("trimesh")  # found, not imported, which takes longer than all the rest
    for folder in (spec and spec.submodule_search_locations) or ():
        file = Path(folder).joinpath(*TEMPLATE)
        if not file.is_file():
            continue
        with zipfile.ZipFile(file) as archive:
            text = archive.read(archive.namelist()[0]).decode()
        _, begin, after = text.partition(BEGIN)
        library, end, _ = after.partition(END)
        if begin and end and "Three.js Authors" in library:
            return library + end
    raise NoViewer(
        "the installed trimesh holds no three.js where gaitlab knows it, so no replay in HTML can "
        "be written; `pip install 'trimesh>=5,<6'` brings it. --output walk.gif, walk.mp4, "
        "strip.png and frame.svg work without it."
    )


def _document(title: str, menu: str, content: Mapping[str, Any], speed: float) -> str:
    """The whole text of the file; no script runs in it but its own, and nothing is fetched."""
    library, viewer = three_js(), "".join(map(_resource, SCRIPTS))
    allowed = " ".join(f"'sha256-{_digest(script)}'" for script in (library, viewer))
    data = json.dumps(content, separators=(",", ":"), allow_nan=False)
    speeds = (
        f'<option value="{value:g}"{" selected" if value == speed else ""}>{value:g}×</option>'
        for value in sorted({*SPEEDS, speed})
    )
    return Template(_resource("page.html")).substitute(
        policy=f"default-src 'none'; style-src 'unsafe-inline'; script-src {allowed}",
        mark=MARK,
        title=escape(title),
        style=_resource("page.css"),
        menu=f'<nav id="menu" aria-label="Trials">{menu}</nav>' if menu else "",
        speeds="".join(speeds),
        data=data.replace("<", "\\u003c"),
        library=library,
        viewer=viewer,
    )


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _resource(name: str) -> str:
    return resources.files("gaitlab.render").joinpath("viewer", name).read_text(encoding="utf-8")
