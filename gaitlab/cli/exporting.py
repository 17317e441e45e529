"""`gaitlab export`: a trial in the file formats of other tools."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import DEFAULT_STORE, AllowCode, Force, StoreFolder, written_to
from gaitlab.cli.printing import other_output_on_stderr, say, size, tell
from gaitlab.cli.trial_lookup import ADDRESS, trial_at, trial_of

if TYPE_CHECKING:
    from gaitlab.render.export import Format


class FormatName(str, Enum):
    """File formats of other tools."""

    csv = "csv"
    mcap = "mcap"
    rerun = "rerun"
    mjcf_urdf = "mjcf-urdf"


def export(
    trial: Annotated[str, typer.Argument(metavar="TRIAL", help=ADDRESS)],
    form: Annotated[
        FormatName,
        typer.Option(
            "--to", help="csv, mcap (Foxglove, PlotJuggler), rerun, or the robot as mjcf-urdf."
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
    from gaitlab.render.export import ExportedTrial, write_export
    from gaitlab.render.export.export import require_library
    from gaitlab.store import Store

    wanted: Format = form.value
    require_library(wanted)
    results = Store(store)
    name = trial_at(results, trial)
    with other_output_on_stderr():
        record = results.record(name)
        given = trial_of(results, record, allow_code=allow_code)
        shown = ExportedTrial(record=record, trial=given, log=results.log(name))
        files = write_export(shown, wanted, output, force=force)
    tell(f"trial {name[:8]}: {size(sum(file.stat().st_size for file in files))}")
    say("\n".join(str(file) for file in files))
    return 0
