"""Figures that are drawn again only where what they show has changed.

Beside the figures of a folder lies `.figures.json`: of each the key of what it shows, and the
digests of its files. A figure of the same key whose files are still those is copied instead of
drawn. The key follows from everything that could change the picture: what is shown, the code of
gaitlab, and matplotlib.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitlab.documents.steps import step
from gaitlab.render.figure_style import save, suffixes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KEYS = ".figures.json"  # name of the file beside the figures
PACKAGE = Path(__file__).parent.parent

_BEFORE: ContextVar[Path | None] = ContextVar("before", default=None)


@contextmanager
def figures_before(folder: Path) -> Iterator[None]:
    """Where `draw` looks for figures that were drawn before."""
    token = _BEFORE.set(folder)
    try:
        yield
    finally:
        _BEFORE.reset(token)


def draw(folder: Path, name: str, shown: object, make: Callable[[], Figure]) -> Path:
    """Write a figure as `figure_style.save` does, or take the one that shows the same.

    Args:
        folder: Where to.
        name: Of the files, without their endings.
        shown: All that the figure is made from, of plain values, arrays and dataclasses.
        make: Draws it.

    Returns:
        The picture, `name`.png.
    """
    key, files = key_of(name, shown), [f"{name}{suffix}" for suffix in suffixes()]
    step(f"drawing {name}")
    if not _taken(folder, name, key, files):
        save(make(), folder, name)
    _remember(folder, name, {"key": key, "files": {file: _digest(folder / file) for file in files}})
    return folder / f"{name}.png"


def key_of(name: str, shown: object) -> str:
    """A digest of what a figure shows, and of what draws it."""
    found = hashlib.sha256(f"{name} {code_digest()} {version('matplotlib')} ".encode())
    _feed(found.update, shown)
    return found.hexdigest()[:32]


@cache
def code_digest(package: Path = PACKAGE) -> str:
    """A digest of all code of gaitlab: anything may come to bear on a picture."""
    found = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        found.update(file.relative_to(package).as_posix().encode() + b"\0" + file.read_bytes())
    return found.hexdigest()


def _feed(update: Callable[[bytes], None], value: object) -> None:
    """Feed a value to a digest, so that two differ if anything in them does."""
    if isinstance(value, np.ndarray):
        update(f"array {value.dtype} {value.shape} ".encode())
        update(np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value) and not isinstance(value, type):
        parts = {item.name: getattr(value, item.name) for item in fields(value)}
        _feed(update, (type(value).__name__, parts))
    elif isinstance(value, Mapping):
        _feed(update, [pair for pair in value.items()])
    elif isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        update(f"list {len(value)} ".encode())
        for item in value:
            _feed(update, item)
    else:
        update(f"{type(value).__name__} {value!r} ".encode())


def _taken(folder: Path, name: str, key: str, files: Sequence[str]) -> bool:
    """Whether the files that show the same were there, as they were written, and are copied."""
    before = _BEFORE.get()
    entry = _keys(before).get(name, {}) if before is not None else {}
    if before is None or entry.get("key") != key:
        return False
    with suppress(OSError):
        if entry.get("files") == {file: _digest(before / file) for file in files}:
            for file in files:
                shutil.copyfile(before / file, folder / file)
            return True
    return False


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()[:32]


def _keys(folder: Path) -> dict[str, dict[str, object]]:
    """What is remembered of the figures of a folder; nothing where the file is not right."""
    with suppress(OSError, ValueError):
        found = json.loads((folder / KEYS).read_text(encoding="utf-8"))
        if isinstance(found, dict) and all(isinstance(entry, dict) for entry in found.values()):
            return found
    return {}


def _remember(folder: Path, name: str, entry: dict[str, object]) -> None:
    known = dict(sorted({**_keys(folder), name: entry}.items()))
    (folder / KEYS).write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
