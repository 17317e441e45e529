"""Functions that are compiled, and kept compiled from run to run.

Numba looks whether the file of a function has changed, not whether one has of a function that it
calls. So what it keeps lies in a folder named by the text of every file that compiles anything,
within the first of those of `caches` that can be written.
"""

from __future__ import annotations

import hashlib
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator

from gaitlab.kinematics.caches import code_folder

PACKAGE = Path(__file__).parent.parent
# The rooms that compile.
ROOMS = ("kinematics", "model", "render", "servos", "simulation", "surfaces")
KEPT = 30 * 86400.0  # s, after which machine code of another text is thrown away


def _text() -> str:
    """Digest of all files that compile something. 16 hex digits."""
    files = (file for room in ROOMS for file in sorted((PACKAGE / room).rglob("*.py")))
    texts = (text for file in files if b"njit" in (text := file.read_bytes()))
    return hashlib.sha256(b"\0".join(texts)).hexdigest()[:16]


def _folder() -> Path | None:
    caches = code_folder().path
    if caches is None:
        return None
    folder = caches / f"compiled-{_text()}"
    if not folder.exists():
        for old in caches.glob("compiled-*"):
            with suppress(OSError):  # another process may throw it away, too
                if time.time() - old.stat().st_mtime > KEPT:
                    shutil.rmtree(old, ignore_errors=True)
    return folder


FOLDER = _folder()
config.CACHE_DIR = str(FOLDER or "")  # type: ignore[attr-defined]


def is_kept(name: str) -> bool:
    """Whether a function, `loop.advance` for instance, is known to need no compiling any more."""
    return FOLDER is not None and any(FOLDER.rglob(f"{name}-*.nbc"))


class _Named(CompileResultCacheImpl):
    """Looks into `FOLDER` and nowhere else."""

    _locator_classes = [UserProvidedCacheLocator]  # noqa: RUF012, as numba has it


class _Kept(FunctionCache):
    """Machine code on a disk that may be full, or damage it: then it is compiled once more."""

    _impl_class = _Named

    def load_overload(self, *arguments: Any) -> Any:
        try:
            return super().load_overload(*arguments)
        except Exception:  # a torn pickle may raise anything
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, *arguments: Any) -> None:
        with suppress(OSError):
            super().save_overload(*arguments)


def njit(function: Any = None, **options: Any) -> Any:
    """Compile a function when it is first called; afterwards it is read from the cache.

    Where nothing can be kept, each process compiles it anew.

    Args:
        function: The function; without one a decorator.
        options: As of `numba.njit`.
    """
    if function is None:
        return lambda function: njit(function, **options)
    compiled = numba.njit(**options)(function)
    if FOLDER is not None and compiled is not function:  # the same with NUMBA_DISABLE_JIT
        with suppress(RuntimeError, OSError):  # it can be written no more
            compiled._cache = _Kept(function)
    return compiled
