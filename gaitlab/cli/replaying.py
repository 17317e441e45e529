"""`gaitlab replay` and `export`: a trial as a film, and in the file formats of other tools."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.common import MOST_JOBS, worker_count
from gaitlab.cli.options import (
    DEFAULT_STORE,
    AllowCode,
    Force,
    Quick,
    Seeds,
    Settings,
    ShownEngine,
    StoreFolder,
    complete_experiments,
    with_engine,
    written_to,
)
from gaitlab.cli.printing import other_output_on_stderr, plural, say, size, tell
from gaitlab.cli.trial_lookup import ADDRESS, complete_trials, trial_of
from gaitlab.errors import UnknownName, UsageError

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.papers.reproduction import Reproduction
    from gaitlab.render import Clip, Recorded
    from gaitlab.render.export import Format
    from gaitlab.store import Store

MOST_PANELS = 24


class ViewName(str, Enum):
    """Where a film looks from."""

    perspective = "perspective"
    side = "side"
    front = "front"


def _pixels(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None:
        raise UsageError(f"--size {text}: give WIDTHxHEIGHT in pixels, 1280x720 for instance")
    return int(found[1]), int(found[2])


def replay(
    trial: Annotated[
        str,
        typer.Argument(metavar="TRIAL", help=ADDRESS, autocompletion=complete_trials),
    ],
    other: Annotated[
        str | None,
        typer.Argument(
            metavar="OTHER",
            help="A second trial, shown beside it.",
            autocompletion=complete_trials,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="FILE",
            parser=written_to,
            help="An .html page in 3-D, a .gif or .mp4 film, a .png strip or an .svg drawing; "
            "walk_TRIAL.gif by default.",
        ),
    ] = None,
    fps: Annotated[float, typer.Option("--fps", metavar="N", help="Frames a second.")] = 25.0,
    speed: Annotated[
        float, typer.Option("--speed", metavar="X", help="0.25 shows it four times as slow.")
    ] = 1.0,
    begin: Annotated[
        float | None,
        typer.Option("--from", metavar="S", help="First instant; at 0 full walking begins."),
    ] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="S", help="Last instant.")] = None,
    view: Annotated[
        ViewName, typer.Option("--view", help="Where to look from.")
    ] = ViewName.perspective,
    pixels: Annotated[
        str | None,
        typer.Option("--size", metavar="WxH", help="In pixels; of one panel of a strip."),
    ] = None,
    panels: Annotated[
        int, typer.Option("--panels", metavar="N", min=1, max=MOST_PANELS, help="Of a strip.")
    ] = 6,
    gui: Annotated[bool, typer.Option("--gui", help="Play it in a window instead.")] = False,
    jobs: Annotated[
        int | None,
        typer.Option(
            "-j",
            "--jobs",
            metavar="N",
            min=0,
            max=MOST_JOBS,
            help="Painting processes, one a usable core by default; 0 paints in this process.",
        ),
    ] = None,
    force: Force = False,
    allow_code: AllowCode = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Show a trial in 3-D or as a film, drawn from its log: nothing is simulated again.

    Grass to height, the load on each foot, ZMP and support polygon, gait phase, clock and fall; in
    3-D also the joints as they were commanded. The .html needs a browser and no network.

    \b
    Example:
      gaitlab replay eros_quick/grass_50mm/worst --output fall.html
      gaitlab replay 4f7667a9 07175312 --view side --from 1 --to 3 --speed 0.25
    """
    from gaitlab.render import clip_of, play, write_replay
    from gaitlab.render.replay import checked_kind
    from gaitlab.store import Store
    from gaitlab.store.addresses import trial_at

    results = Store(store)
    names = [trial_at(results, name) for name in (trial, other) if name is not None]
    path = output or Path(f"walk_{'_'.join(name[:8] for name in names)}.gif")
    wanted = None if pixels is None else _pixels(pixels)
    if not gui:
        checked_kind(path)
    with other_output_on_stderr():
        shown = [_recorded(results, name, allow_code) for name in names]
        clip = clip_of([each.log for each in shown], begin=begin, end=end, fps=fps, speed=speed)
        if gui:
            play(_alone(shown), clip)
            return 0
        _announce(path, clip)
        written = write_replay(
            shown,
            path,
            clip,
            view=view.value,
            size=wanted,
            panels=panels,
            jobs=worker_count(jobs),
            force=force,
        )
    length = f", {written.duration:.1f} s" if written.duration else ""
    tell(f"{plural(written.pictures, 'picture')}{length}, {size(written.size)}")
    say(str(written.path))
    return 0


def _announce(path: Path, clip: Clip) -> None:
    """Say what is being done when it takes a while."""
    if path.suffix.lower() in (".gif", ".mp4"):
        span = f"{clip.begin:.2f} to {clip.end:.2f} s"
        tell(f"painting {plural(len(clip.instants), 'picture')} of {span} ...")


def _recorded(results: Store, name: str, allow_code: bool) -> Recorded:
    from gaitlab.render import Recorded
    from gaitlab.store.addresses import place_of

    trial = trial_of(results, results.record(name), allow_code=allow_code)
    return Recorded(name, trial, results.log(name), place_of(results, name))


def _alone(shown: list[Recorded]) -> Recorded:
    if len(shown) > 1:
        raise UsageError("--gui plays one trial; --output walk.gif or .mp4 shows two side by side")
    return shown[0]


def view(
    experiment: Annotated[
        str | None,
        typer.Argument(
            metavar="EXPERIMENT",
            help="A file, or the name of one in experiments/; by default the one that was planned "
            "last into the store.",
            autocompletion=complete_experiments,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            parser=written_to,
            help="Folder, reports/EXPERIMENT by default.",
        ),
    ] = None,
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in the browser.")
    ] = True,
    storage: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Database of a study, if several machines share it."),
    ] = None,
    force: Force = False,
    quick: Quick = False,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: ShownEngine = None,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Look at an experiment, a study or a reproduction in the browser, with walks in 3-D.

    The report, index.html, leads to the worst and the median walk of each cell in replays.html
    beside it; of a study, to those of its winner and of the values before it; of a reproduction,
    to a folder each of its experiments. All need no network, and can be sent to others.

    \b
    Example:
      gaitlab view eros_quick
      gaitlab view eros_small
      gaitlab view --no-open
    """

    from gaitlab.cli.common import refuse_quick
    from gaitlab.cli.progress import steps
    from gaitlab.experiment import is_reproduction, load_experiment
    from gaitlab.report.view import write_view
    from gaitlab.store import Store

    if output is not None and output.exists() and not output.is_dir():
        raise UsageError(f"--output {output}: a file is in the way; give a folder")
    results, settings = Store(store), with_engine(settings, engine)
    name = experiment or _newest(results)
    with other_output_on_stderr(), steps():
        whole: Reproduction | None
        if is_reproduction(name):
            from gaitlab.papers.reproduction import load_reproduction

            whole = load_reproduction(name, quick=quick, settings=settings, seeds=seeds)
        else:
            refuse_quick(name, quick)
            asked = load_experiment(name, settings, seeds)
            whole = _sweep(asked, settings, seeds)
        if whole is not None:
            from gaitlab.papers.reproduction.view import view_reproduction

            page, views = view_reproduction(whole, results, output, force=force)
        else:
            views = [write_view(asked, results, output, storage=storage, force=force)]
            page = views[0].page
    for written in views:
        walks = plural(len(written.links), "walk")
        tell(f"{walks} in {written.walks}, {size(written.walks.stat().st_size)}")
    say(str(page))
    if opened:
        _open(page)
    return 0


def _sweep(asked: Experiment, settings: Sequence[str], seeds: int | None) -> Reproduction | None:
    """The page of a sweep with a switch; None for any other experiment."""
    if asked.design is None:
        return None
    from gaitlab.papers.reproduction import sweep_page  # slow to load

    return sweep_page([asked], settings, seeds)


def _newest(results: Store) -> str:
    """The experiment that was planned last into a store.

    Raises:
        UnknownName: If there is none.
        UsageError: If options of the command line made it, which its name does not tell.
    """
    name = results.newest()
    if name is None:
        raise UnknownName(f"{results.path}: no experiment was run on this store; run one first")
    file, form, _ = name.partition("+")
    if form:
        raise UsageError(
            f"{results.path}: the newest results are {name}, a form of {file}; name the "
            f"experiment, and the options that it was run with: `gaitlab view {file} --set ...`"
        )
    return name


def _open(page: Path) -> None:
    """Show a page in the user's browser; a browser in the terminal would not draw it."""
    import webbrowser

    screen = any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")))
    if (sys.platform.startswith("linux") and not screen) or not webbrowser.open(
        page.absolute().as_uri()
    ):
        tell("no browser was found here; open the file above in one, on any machine")


class FormatName(str, Enum):
    """File formats of other tools."""

    csv = "csv"
    mcap = "mcap"
    rerun = "rerun"
    mjcf_urdf = "mjcf-urdf"
    trajectory = "trajectory"


def export(
    trial: Annotated[
        str, typer.Argument(metavar="TRIAL", help=ADDRESS, autocompletion=complete_trials)
    ],
    form: Annotated[
        FormatName,
        typer.Option(
            "--to",
            help="csv, mcap (Foxglove, PlotJuggler), rerun, the robot as mjcf-urdf, or what the "
            "joints were sent as a trajectory.",
        ),
    ] = FormatName.csv,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="FILE",
            parser=written_to,
            help="By default named after the trial or the robot.",
        ),
    ] = None,
    force: Force = False,
    allow_code: AllowCode = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Write the log of a trial, or the robot that walked in it, for another tool.

    \b
    Example:
      gaitlab export eros_quick/grass_50mm/worst --to mcap
    """
    from gaitlab.cli.progress import steps
    from gaitlab.documents.steps import expect, step
    from gaitlab.render.export import ExportedTrial, write_export
    from gaitlab.render.export.export import require_library
    from gaitlab.store import Store
    from gaitlab.store.addresses import trial_at

    wanted: Format = form.value
    require_library(wanted)
    results = Store(store)
    name = trial_at(results, trial)
    with other_output_on_stderr(), steps():
        expect(2)
        step(f"reading trial {name[:8]}")
        record = results.record(name)
        given = trial_of(results, record, allow_code=allow_code)
        shown = ExportedTrial(record=record, trial=given, log=results.log(name))
        step(f"writing {wanted}")
        files = write_export(shown, wanted, output, force=force)
    tell(f"trial {name[:8]}: {size(sum(file.stat().st_size for file in files))}")
    say("\n".join(str(file) for file in files))
    return 0
