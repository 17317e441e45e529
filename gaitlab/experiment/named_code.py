"""Which Python files the user's own experiment files name, and may therefore run.

The record of a trial names the code of its robot, gait and balance controller too, but a store may
come from somebody else: what it alone names runs only when the user says so.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from gaitlab.documents import Node, load
from gaitlab.errors import FileError, GaitlabError
from gaitlab.plugins import SUFFIXES, folders, locate
from gaitlab.simulation.trial import Plugin, own_code

Named: TypeAlias = Container[tuple[str, str | None]]  # file and SHA-256 of its text
SUFFIX = ".py"


def named_code(store: Path) -> set[tuple[str, str | None]]:
    """Code that an experiment file names, in the working directory or its `experiments/`.

    No code is run, and no experiment file counts that lies in the store itself.

    Args:
        store: Folder of the store.

    Returns:
        Each file with the SHA-256 of its text.
    """
    found: set[tuple[str, str | None]] = set()
    for file in _experiment_files(store.resolve()):
        with suppress(FileError):
            found.update(_named_in(load(file)))
    return found


def unnamed_code(trial: Mapping[str, Any], named: Named) -> list[str]:
    """Files of the user's own code that a trial would run and nobody but its record names."""
    return [code.name for code in own_code(trial) if (_file(code), code.digest) not in named]


def refusal(files: Sequence[str]) -> str:
    """Why code is not run, and what to do."""
    return (
        f"it would run {' and '.join(files)}, which only the store names, no experiment file of "
        "yours here with that text. Read the code; --allow-code runs it"
    )


def _experiment_files(store: Path) -> Iterator[Path]:
    here = Path.cwd()
    places = [here, *(folder for folder in folders("experiment") if here in folder.parents)]
    for folder in places:
        for suffix in SUFFIXES["experiment"]:
            for file in sorted(folder.glob(f"*{suffix}")):
                real = file.resolve()
                if store not in real.parents and real.is_file():
                    yield file


def _named_in(node: Node) -> Iterator[tuple[str, str]]:
    for inner in (*node.items, *node.mapping.values()):
        yield from _named_in(inner)
    if isinstance(node.value, str) and node.value.endswith(SUFFIX):
        with suppress(GaitlabError, OSError, ValueError):
            file = locate("gait", node.value, node.folder)
            yield str(file), hashlib.sha256(file.read_bytes()).hexdigest()


def _file(code: Plugin) -> str:
    """The file that would run, however its name is spelt; the name if there is none."""
    with suppress(GaitlabError):
        return str(locate("gait", code.name))
    return code.name
