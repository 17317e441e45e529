"""`gaitlab new` and `schema`: a file to begin with, and what an editor completes it by."""

from __future__ import annotations

import os
import re
import shlex
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from gaitlab.cli.options import Force, written_to
from gaitlab.cli.printing import say, tell
from gaitlab.documents.outputs import refuse_other, write_text
from gaitlab.errors import UsageError
from gaitlab.plugins import PACKAGE

TEMPLATES = PACKAGE / "experiment" / "templates"
WALK = "my_walk.yaml"  # the experiment in which a hint lets a new part walk


class NewKind(str, Enum):
    """What can be begun."""

    experiment = "experiment"
    study = "study"
    surface = "surface"
    servo = "servo"
    gait = "gait"


class SchemaKind(str, Enum):
    """Files that there is a schema of."""

    experiment = "experiment"
    study = "study"
    surface = "surface"
    servo = "servo"
    robot = "robot"


NEXT = {  # command by kind that comes next; without `run` in a walk of one's own
    NewKind.experiment: "run {file}",
    NewKind.study: "optimize {file}",
    NewKind.surface: 'run {walk} --set "surfaces=[{file}]"',
    NewKind.servo: "run {walk} --set servo.type={file}",
    NewKind.gait: "run {walk} --set gait={file}",
}


def new(
    kind: Annotated[NewKind, typer.Argument(metavar="KIND", help="What is begun.")],
    name: Annotated[
        Path, typer.Argument(metavar="NAME", parser=written_to, help="What it is to be called.")
    ],
    source: Annotated[
        str | None,
        typer.Option("--from", metavar="OTHER", help="Copy this one, a name or a file, instead."),
    ] = None,
) -> int:
    """Write a file to begin with: commented, right as it is, and completed by an editor.

    Never replaces a file. `gaitlab robot` begins a robot, from its URDF.

    \b
    Example:
      gaitlab new experiment our_walk
      gaitlab new surface our_field
      gaitlab new experiment our_quick --from eros_quick
    """
    file = _named(name, ".py" if kind is NewKind.gait else ".yaml")
    if os.path.lexists(file):
        raise UsageError(f"{file} is there already and is left as it is; choose another name")
    if source is None:
        template = TEMPLATES / ("gait.txt" if kind is NewKind.gait else f"{kind.value}.yaml")
        text = template.read_text(encoding="utf-8")
        text = text.replace("{name}", file.stem).replace("{file}", shlex.quote(str(file)))
    else:
        text = _copied(kind, source, file)
    if kind is not NewKind.gait:
        from gaitlab.experiment.json_schema import put_beside

        text = f"{put_beside(_schema_of(kind.value), file)}\n{text}"
    write_text(file, text)
    way = shlex.quote(str(file) if file.is_absolute() else f"./{file}")
    walk = WALK
    if "{walk}" in NEXT[kind] and not Path(WALK).exists():
        tell(f"First a walk, if there is none: gaitlab new experiment {Path(WALK).stem}")
    tell(f"Then: gaitlab {NEXT[kind].format(file=way, walk=walk)}")
    say(str(file))
    return 0


def _copied(kind: NewKind, source: str, file: Path) -> str:
    """The text of another file of the kind, right in its new place: name, and what it includes.

    Raises:
        UnknownName: If there is no such file.
    """
    from gaitlab.experiment.json_schema import MODELINE
    from gaitlab.experiment.loading import INCLUDE
    from gaitlab.plugins import locate

    place = locate("experiment" if kind is NewKind.study else kind.value, source)
    lines = place.read_text(encoding="utf-8").splitlines(keepends=True)
    text = "".join(line for line in lines if not line.startswith(MODELINE))
    if (found := INCLUDE.search(text)) is not None:
        reached = os.path.relpath(place.parent / found[1], file.parent)
        text = f"{text[: found.start(1)]}{Path(reached).as_posix()}{text[found.end(1) :]}"
    return re.sub(r"(?m)^name:[^\n#]*(?=#|$)", f"name: {file.stem}", text, count=1)


def _named(name: Path, ending: str) -> Path:
    """The file of a name, with or without its ending.

    Raises:
        UsageError: If results or tables could not be called by it.
    """
    from gaitlab.experiment.experiment import NAME

    stem = name.stem if name.suffix == ending else name.name
    if not NAME.fullmatch(stem):
        raise UsageError(
            f"NAME {name}: found {stem!r}; results are called by it, so letters, digits and _ . - "
            "are allowed, at most 100, the first a letter or a digit"
        )
    return name.with_name(f"{stem}{ending}")


def _schema_of(kind: str) -> str:
    return "experiment" if kind == "study" else kind


def schema(
    kind: Annotated[
        SchemaKind, typer.Argument(metavar="KIND", help="Which files.")
    ] = SchemaKind.experiment,
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", parser=written_to, help="Write it here instead."),
    ] = None,
    force: Force = False,
) -> int:
    """Print what may stand in a kind of files, as JSON Schema, for editors and other programs.

    An editor with a YAML language server completes and checks a file that begins with
    `# yaml-language-server: $schema=FILE`, as those of `gaitlab new` do.

    \b
    Example:
      gaitlab schema surface --output surface.json
    """
    from gaitlab.experiment.json_schema import schema_text

    text = schema_text(_schema_of(kind.value))
    if output is None:
        say(text.rstrip("\n"))
        return 0
    refuse_other(output, b'{\n "$schema"', force=force)
    write_text(output, text)
    say(str(output))
    return 0
