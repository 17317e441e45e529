"""`gaitlab list` and `show`: what there is and what it means."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from contextlib import suppress
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, cast

import typer

from gaitlab.cli.catalogue_text import described, trial_text
from gaitlab.cli.options import DEFAULT_STORE, StoreFolder, completed, names_of
from gaitlab.cli.printing import (
    other_output_on_stderr,
    say,
    wrapped,
)
from gaitlab.errors import FileError, UnknownName

if TYPE_CHECKING:
    from gaitlab.plugins import Kind
    from gaitlab.store import Store, TrialRecord

HEX = re.compile(r"[0-9a-fA-F]{4,32}")
CLASSES: Mapping[str, Kind] = MappingProxyType({"Robot": "robot", "Balance": "balance"})
NEAREST = 5  # trials listed when a prefix fits none or several


class Plural(str, Enum):
    """What can be listed."""

    robots = "robots"
    gaits = "gaits"
    surfaces = "surfaces"
    servos = "servos"
    balance = "balance"
    metrics = "metrics"
    motions = "motions"
    experiments = "experiments"
    studies = "studies"

    @property
    def singular(self) -> str:
        """One of them, `study` for instance."""
        if self is Plural.studies:
            return "study"
        return self.value.removesuffix("s")


def _kind(text: str) -> Plural:
    """A kind in the plural or the singular."""
    for kind in Plural:
        if text in (kind.value, kind.singular):
            return kind
    raise typer.BadParameter(f"found {text!r}; allowed is one of {', '.join(Plural.__members__)}")


def list_names(
    kind: Annotated[
        Plural | None,
        typer.Argument(
            metavar="KIND",
            parser=_kind,
            help=f"{', '.join(Plural.__members__)}.",
            autocompletion=completed(lambda: Plural.__members__),
        ),
    ] = None,
) -> int:
    """List the names that experiments can use, all kinds or one.

    \b
    Example:
      gaitlab list surfaces
    """
    if kind is Plural.metrics:
        from gaitlab.metrics import lookup

        found = [lookup(name) for name in _names(kind)]
        rows = [[each.name, each.unit, each.doc.partition("\n")[0]] for each in found]
        say(wrapped(["metric", "unit", "what it is"], rows, texts=1))
    elif kind is not None:
        rows = [[name, _summary(_file_kind(kind), name)] for name in _names(kind)]
        say(wrapped([kind.singular, "what it is"], rows, texts=1))
    else:
        for each in Plural:
            say(f"{each.value}: {', '.join(_names(each))}")
    return 0


def _file_kind(kind: Plural) -> Kind:
    return cast("Kind", "experiment" if kind is Plural.studies else kind.singular)


def _names(kind: Plural) -> list[str]:
    if kind is Plural.studies:
        from gaitlab.experiment import studies

        return studies()
    return names_of(_file_kind(kind))


def _summary(kind: Kind, name: str) -> str:
    """What a name stands for in a line, empty when its file does not say."""
    from gaitlab.documents import load
    from gaitlab.plugins import locate

    path = locate(kind, name)
    if path.suffix == ".py":
        return (ast.get_docstring(ast.parse(path.read_bytes())) or "").partition("\n")[0]
    try:
        found = load(path).mapping
    except FileError as error:
        return f"wrong file: {error.problems[0].message}"
    described = found.get("title" if kind == "experiment" else "description")
    text = " ".join(str(described.value).split()) if described else ""
    kinds = (key for key in ("study", "reproduction") if kind == "experiment" and key in found)
    return ": ".join([*kinds, text])


def _all_names() -> list[str]:
    from gaitlab.plugins import KINDS

    return names_of(*KINDS)


def show(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME|TRIAL",
            help="A name from `gaitlab list`, or the first digits of a trial.",
            autocompletion=completed(_all_names),
        ),
    ],
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Show the parameters behind a name with unit, range and source, or the record of a trial.

    \b
    Example:
      gaitlab show grass_50mm
    """
    from gaitlab.plugins import KINDS, is_file_name, names, nearest
    from gaitlab.store import Store

    kinds = [kind for kind in KINDS if name in names(kind)]
    if kinds or is_file_name(name):
        with other_output_on_stderr():
            texts = [described(kind, name) for kind in kinds or [_kind_of_file(name)]]
        say("\n\n".join(texts))
        return 0
    if HEX.fullmatch(name):
        say(trial_text(_record(Store(store), name.lower())))
        return 0
    near = nearest(name, sorted({known for kind in KINDS for known in names(kind)}))
    raise UnknownName(
        f"nothing is called {name!r}{near}; `gaitlab list` gives every name, and a trial is "
        "named by at least 4 of its first digits"
    )


def _kind_of_file(name: str) -> Kind:
    """What a file defines: Python is told by its class, YAML by its keys."""
    from gaitlab.documents import load
    from gaitlab.model.servo import Servo
    from gaitlab.parameters import parameter_table

    path, text = Path(name), ""
    if path.suffix == ".py":
        with suppress(OSError):  # whoever loads it says what is wrong with it
            text = path.read_text(encoding="utf-8", errors="replace")
        return next((kind for name, kind in CLASSES.items() if f"class {name}" in text), "gait")
    keys = set(load(path).mapping)
    if "type" in keys or "frames" in keys:
        return "surface" if "type" in keys else "motion"
    return "servo" if keys & set(parameter_table(Servo)) else "experiment"


def _record(results: Store, prefix: str) -> TrialRecord:
    """Record of the one trial whose id starts so.

    Raises:
        UnknownName: If none or several do; lists the nearest.
    """
    ids = sorted(results.index().entries)
    fitting = [trial_id for trial_id in ids if trial_id.startswith(prefix)]
    if len(fitting) == 1:
        return results.record(fitting[0])
    nearest = fitting or sorted(ids, key=lambda i: -_shared(i, prefix))
    what = f"{len(fitting)} trials start" if fitting else "no trial starts"
    listed = ", ".join(trial_id[: len(prefix) + 4] for trial_id in nearest[:NEAREST]) or "none"
    raise UnknownName(f"{results.path}: {what} with {prefix}; nearest: {listed}")


def _shared(one: str, other: str) -> int:
    return next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), len(other))
