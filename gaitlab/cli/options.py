"""Arguments that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from gaitlab.documents.outputs import file_to_write
from gaitlab.documents.printable import is_utf8

if TYPE_CHECKING:
    from gaitlab.plugins import Kind


def completed(known: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """What completes a name; silent whatever is wrong, for someone is just typing."""

    def complete(incomplete: str) -> list[str]:
        with suppress(Exception):
            return sorted({name for name in known() if name.startswith(incomplete)})
        return []

    return complete


def with_engine(settings: Sequence[str] | None, engine: EngineChoice | None) -> list[str]:
    """All settings of a command, the chosen engine as the last."""
    return [*(settings or ()), *([f"engine.name={engine.value}"] if engine else [])]


def names_of(*kinds: Kind) -> list[str]:
    """Names of these kinds that can be asked for."""
    from gaitlab.plugins import names

    return [name for kind in kinds for name in names(kind)]


def _experiments() -> list[str]:
    return names_of("experiment")


complete_experiments = completed(_experiments)


def _folder(text: str) -> Path:
    # An unset variable of the shell gives an empty text, which a Path takes for this folder.
    if not str(text).strip():
        raise typer.BadParameter("found nothing; give a folder, or leave the option out")
    if not is_utf8(str(text)):
        raise typer.BadParameter(f"found '{text}', which holds bytes that are no UTF-8; rename it")
    return Path(text)


def written_to(text: str) -> Path:
    """The file or folder that an option gives to write to."""
    try:
        return file_to_write(str(text))
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


ExperimentName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="EXPERIMENT",
        help="A file, or the name of one in experiments/.",
        autocompletion=complete_experiments,
    ),
]
StoreFolder: TypeAlias = Annotated[
    Path,
    typer.Option(
        "--store",
        metavar="DIR",
        parser=_folder,
        envvar="GAITLAB_STORE",
        help="Folder of the results.",
    ),
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Change one value of the file; may be repeated."
    ),
]


class EngineChoice(str, Enum):
    """Physics engines."""

    bullet = "bullet"
    mujoco = "mujoco"


Engine: TypeAlias = Annotated[
    EngineChoice | None,
    typer.Option(
        "--engine",
        help="Simulate in this engine instead of the file's: bullet is the reference, mujoco "
        "walks some ten times faster. Short for --set engine.name=...",
    ),
]
ShownEngine: TypeAlias = Annotated[
    EngineChoice | None,
    typer.Option(
        "--engine",
        help="Show what was simulated in this engine instead of the file's. Short for --set "
        "engine.name=...",
    ),
]
Seeds: TypeAlias = Annotated[
    int | None,
    typer.Option("--seeds", metavar="N", help="Replicates of each cell, instead of the file's."),
]
Jobs: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "-j",
        "--jobs",
        metavar="N",
        help="Worker processes, one a usable core by default; 0 runs in this process.",
    ),
]
ShardText: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--shard",
        metavar="I/N",
        help="Run the I-th of N shares of the experiment, counted from 1; the others may be run "
        "at the same time, on this machine or on others that see the same store.",
    ),
]
Dask: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="ADDRESS",
        help="Walk on the workers of a Dask scheduler (tcp://host:8786, or the file it wrote), of "
        "this machine (local, with -j), or of SLURM (slurm, with cluster.yaml, or a FILE.yaml).",
    ),
]
SharedStore: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--shared-store/--no-shared-store",
        help="Whether the workers of --dask see the folder of the results; else results travel "
        "through the scheduler.",
    ),
]
Quick: TypeAlias = Annotated[
    bool, typer.Option("--quick", help="The short form of a reproduction, as its file has it.")
]
Force: TypeAlias = Annotated[
    bool, typer.Option("--force", help="Also replace files that gaitlab did not write.")
]
AllowCode: TypeAlias = Annotated[
    bool,
    typer.Option("--allow-code", help="Run code that only the store names; it says which files."),
]
Quiet: TypeAlias = Annotated[bool, typer.Option("-q", "--quiet", help="Show no progress.")]

DEFAULT_STORE = Path("data")
