"""Functions that are compiled, and kept compiled from run to run.

Numba looks whether the file of a function has changed, not whether one has of a function that it
calls. So what it keeps lies in a folder named by the text of every file that compiles anything.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import config

PACKAGE = Path(__file__).parent.parent
# The rooms that compile.
ROOMS = ("kinematics", "model", "render", "servos", "simulation", "surfaces")
KEPT = 30 * 86400.0  # s, after which machine code of another text is thrown away


def _text() -> str:
    """Digest of all files that compile something. 16 hex digits."""
    files = (file for room in ROOMS for file in sorted((PACKAGE / room).rglob("*.py")))
    texts = (text for file in files if b"njit" in (text := file.read_bytes()))
    return hashlib.sha256(b"\0".join(texts)).hexdigest()[:16]


def _folder() -> Path:
    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gaitlab"
    folder = caches / f"compiled-{_text()}"
    if not folder.exists() and caches.exists():
        for old in caches.glob("compiled-*"):
            if time.time() - old.stat().st_mtime > KEPT:
                shutil.rmtree(old, ignore_errors=True)
    return folder


# Without a home, or with one that cannot be looked into, it lies where Numba puts it.
with suppress(OSError, RuntimeError):
    config.CACHE_DIR = config.CACHE_DIR or str(_folder())  # type: ignore[attr-defined]


def is_kept(name: str) -> bool:
    """Whether a function, `loop.advance` for instance, is known to need no compiling any more."""
    folder: str = config.CACHE_DIR  # type: ignore[attr-defined]
    return bool(folder) and any(Path(folder).rglob(f"{name}-*.nbc"))


def njit(function: Any = None, **options: Any) -> Any:
    """Compile a function when it is first called; afterwards it is read from the cache.

    Args:
        function: The function; without one a decorator.
        options: As of `numba.njit`.
    """
    decorate = numba.njit(cache=True, **options)
    return decorate if function is None else decorate(function)
