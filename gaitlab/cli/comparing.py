"""`gaitlab compare-log`: a real robot's log beside what is simulated of its targets."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import Settings, completed, names_of
from gaitlab.cli.printing import columns, other_output_on_stderr, plural, say

if TYPE_CHECKING:
    from gaitlab.running.real_log import LogComparison
    from gaitlab.statistics import Interval


def compare_log(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Targets over time and what was measured: .csv, .npz, .parquet."
        ),
    ],
    robot: Annotated[
        str,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="A name or a file.",
            autocompletion=completed(lambda: names_of("robot")),
        ),
    ],
    surface: Annotated[
        str,
        typer.Option(
            "--surface",
            metavar="SURFACE",
            help="The ground that it walked on.",
            autocompletion=completed(lambda: names_of("surface")),
        ),
    ] = "hard_floor",
    seeds: Annotated[
        int, typer.Option("--seeds", metavar="N", min=2, max=1000, help="Simulated walks.")
    ] = 10,
    settings: Settings = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> int:
    """Walk the targets of a real robot's log again and print how far from it the simulation is.

    Columns JOINT_measured, imu_pitch and imu_roll, or imu_qx, imu_qy, imu_qz, imu_qw hold what
    the robot measured.

    \b
    Example:
      gaitlab compare-log walk.csv --robot eros --surface carpet_4mm
    """
    from gaitlab.running.real_log import compare_log as compare
    from gaitlab.running.real_log import replays

    with other_output_on_stderr():
        found = compare(replays(file, robot, surface, seeds, settings or ()))
    say(json.dumps(_object(found)) if as_json else _text(found))
    return 0


def _object(found: LogComparison) -> dict[str, object]:
    """The comparison as JSON has it; what is not known is null."""
    residuals = [
        {
            "quantity": one.quantity,
            "unit": one.unit,
            "rms": _known(one.rms),
            "rms_interval": [_known(end) for end in one.rms_interval],
            "mean": _known(one.mean),
            "mean_interval": [_known(end) for end in one.mean_interval],
        }
        for one in found.residuals
    ]
    return {
        "residuals": residuals,
        "seeds": found.seeds,
        "rows": found.rows,
        "time": found.time,
        "falls": found.falls,
        "first_fall": _known(found.first_fall),
        "digest": found.digest,
    }


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


def _text(found: LogComparison) -> str:
    head = ("simulated - measured", "unit", "rms", "95 %", "mean", "95 %")
    rows = [
        [
            one.quantity,
            one.unit,
            f"{one.rms:.4f}" if isfinite(one.rms) else "",
            _ends(one.rms_interval),
            f"{one.mean:+.4f}",
            _ends(one.mean_interval, sign="+"),
        ]
        for one in found.residuals
    ]
    compared = f"{found.rows} rows, {found.time:.2f} s, {plural(found.seeds, 'seed')}"
    falls = f"; {found.falls} fell, the first {found.first_fall:.2f} s after the first row, where "
    falls += "the comparison ends"
    return "\n".join([columns(head, rows), "", compared + (falls if found.falls else "")])


def _ends(interval: Interval, sign: str = "") -> str:
    if not (isfinite(interval.low) and isfinite(interval.high)):
        return ""
    return f"{interval.low:{sign}.4f} to {interval.high:{sign}.4f}"
