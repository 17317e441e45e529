"""Which formats there are and what each needs; CSV, which needs nothing."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from gaitlab.documents.outputs import MARK, refuse_other, replaced
from gaitlab.documents.printable import csv_cell
from gaitlab.errors import UsageError
from gaitlab.log.columns import Column, columns
from gaitlab.render.export.mcap import write_mcap
from gaitlab.render.export.model import write_model
from gaitlab.render.export.recorded import ExportedTrial
from gaitlab.render.export.rerun import write_rerun
from gaitlab.render.export.trajectory import EXPORTED, write_trajectory

Format: TypeAlias = Literal["csv", "mcap", "rerun", "mjcf-urdf", "trajectory"]
FORMATS: tuple[Format, ...] = get_args(Format)


class _Writer(NamedTuple):
    """How a format is written.

    Attributes:
        write: Writes a trial to its files.
        ending: Of the file, if nobody names it; empty for several files that share a stem.
        start: How a file of the format starts.
        mark: What else tells that gaitlab wrote it.
        endings: Put behind the name that is given, one a file.
        library: What has to be installed; empty for nothing.
        package: What brings it.
    """

    write: Callable[[ExportedTrial, Sequence[Path]], None]
    ending: str
    start: bytes
    library: str = ""
    package: str = ""
    endings: Sequence[str] = ("",)
    mark: bytes = MARK.encode()


def _write_csv(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """One row a tick, the unit in every column's name.

    Read as float32, every number is the one that was recorded.
    """
    described = columns(shown.log.header.joints)
    texts = [_texts(shown.log.arrays[column.name]) for column in described]
    with files[0].open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([csv_cell(_title(column)) for column in described])
        writer.writerows(zip(*texts, strict=True))


def _title(column: Column) -> str:
    """`trunk_x [m]`; a name alone for what has no unit."""
    return column.name if column.unit == "-" else f"{column.name} [{column.unit}]"


def _texts(array: np.ndarray) -> list[str]:
    """Shortest texts that read back as the same number; NaN is an empty field, true is 1."""
    if array.dtype == bool:
        array = array.astype(np.int8)
    texts: list[str] = array.astype(str).tolist()
    return ["" if text == "nan" else text for text in texts]


_WRITERS: dict[Format, _Writer] = {
    "csv": _Writer(_write_csv, ".csv", b"time [s],", mark=b",gait_phase,"),
    "mcap": _Writer(write_mcap, ".mcap", b"\x89MCAP", "mcap", "mcap"),
    "rerun": _Writer(write_rerun, ".rrd", b"RRF", "rerun", "rerun-sdk"),
    "mjcf-urdf": _Writer(write_model, "", b"<", endings=(".urdf", ".xml")),
    "trajectory": _Writer(write_trajectory, "_walk.csv", b"# ", mark=EXPORTED.encode()),
}


def default_path(shown: ExportedTrial, form: Format) -> Path:
    """What an export is called when nobody says: the trial, or for a model the robot."""
    ending = _WRITERS[form].ending
    robot = Path(shown.trial.names.robot).stem
    return Path(f"{shown.record.trial_id[:8]}{ending}") if ending else Path(robot)


def require_library(form: Format) -> None:
    """Refuse a format whose library is missing.

    Raises:
        UsageError: Says what to install.
    """
    needed = _WRITERS[form]
    if needed.library and find_spec(needed.library) is None:
        raise UsageError(
            f"--to {form} needs {needed.package}: `pip install {needed.package}`, or "
            "`pip install gaitlab[export]` for all formats. csv and mjcf-urdf need nothing more."
        )


def write_export(
    shown: ExportedTrial, form: Format, path: Path | None = None, *, force: bool = False
) -> list[Path]:
    """Write a trial in a format of other tools.

    Args:
        shown: The trial.
        form: The format.
        path: The file, or for `mjcf-urdf` what its two files are called without their endings.
        force: Also replace a file that gaitlab did not write.

    Returns:
        The files.

    Raises:
        UsageError: If the format's library is missing, or a folder or a file that gaitlab did
            not write is there.
        StoreError: If a file cannot be written.
    """
    require_library(form)
    path = path or default_path(shown, form)
    if path.is_dir():
        raise UsageError(f"--output {path}: a folder is in the way; give a file")
    writer = _WRITERS[form]
    files = [path.with_name(path.name + ending) for ending in writer.endings]
    for file in files:
        refuse_other(file, writer.start, writer.mark, force=force)
    with ExitStack() as whole:
        writer.write(shown, [whole.enter_context(replaced(file)) for file in files])
    return files
