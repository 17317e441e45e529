"""Where this user keeps what can be made again, machine code for instance.

Home may be missing or read-only, in a container or under a batch system. Whatever is found here
is loaded and run, so a folder counts only if it can be written and is nobody else's.
"""

from __future__ import annotations

import logging
import os
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

NAMED = "NUMBA_CACHE_DIR"  # the variable that names a folder for machine code
NAME = "gaitlab"
TEMPORARY = ("/tmp", "/var/tmp")  # after that which `TMPDIR` names


@dataclass(frozen=True, kw_only=True)
class CacheFolder:
    """A folder for what can be made again.

    Attributes:
        path: Where it is, made already; None if nothing can be kept.
        refused: Folders that come first and cannot be used, each with the reason.
    """

    path: Path | None
    refused: tuple[str, ...] = ()


@cache
def cache_folder() -> CacheFolder:
    """The first that can be used of the user's own folder and one for temporary files.

    The user's own is `$XDG_CACHE_HOME/gaitlab`, or `~/.cache/gaitlab`. The other is for this user
    alone, `gaitlab-UID` with mode 0700; a link, or what belongs to somebody else, is refused.
    """
    places = [os.environ.get("TMPDIR"), *TEMPORARY]
    return _first(_own, *(partial(_private, Path(place)) for place in places if place))


@cache
def code_folder() -> CacheFolder:
    """The folder for machine code: that which `NUMBA_CACHE_DIR` names, else `cache_folder`."""
    if not (named := os.environ.get(NAMED)):
        return cache_folder()
    first = _first(lambda: _made(Path(named)))
    if first.path is not None:
        return first
    following = cache_folder()
    return CacheFolder(path=following.path, refused=(*first.refused, *following.refused))


def lend_caches() -> None:
    """Where the libraries' own folders cannot be written, have them use `cache_folder` as well.

    Matplotlib and fontconfig would say at length that they could not, and list all fonts anew in
    every process. The processes that this one starts inherit it. Nor is it said that listing them
    takes a moment.
    """
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    with suppress(_Refused):
        _made(_home("XDG_CONFIG_HOME", ".config"))
        if not cache_folder().refused:
            return
    folder = cache_folder().path
    if folder is None:
        logging.getLogger("matplotlib").setLevel(logging.ERROR)
        return
    os.environ.setdefault("MPLCONFIGDIR", str(folder / "matplotlib"))
    os.environ["XDG_CACHE_HOME"] = str(folder.parent)


class _Refused(Exception):
    """Why a folder cannot be used, in words."""


def _first(*choices: Callable[[], Path]) -> CacheFolder:
    refused = list[str]()
    for choice in choices:
        try:
            return CacheFolder(path=choice(), refused=tuple(refused))
        except _Refused as error:
            refused.append(str(error))
    return CacheFolder(path=None, refused=tuple(refused))


def _own() -> Path:
    folder = _made(_home("XDG_CACHE_HOME", ".cache") / NAME)
    found = folder.stat()
    if found.st_uid != os.geteuid() or found.st_mode & stat.S_IWOTH:
        raise _Refused(f"{folder} belongs to somebody else, or everybody may write to it")
    return folder


def _home(variable: str, name: str) -> Path:
    try:
        return Path(os.environ.get(variable) or Path.home() / name)
    except RuntimeError as error:
        raise _Refused("this user has no home") from error


def _private(place: Path) -> Path:
    """A folder of this user alone, which nobody else can have put there or can replace."""
    private = place / f"{NAME}-{os.geteuid()}"
    try:
        shared = place.stat().st_mode
        with suppress(FileExistsError):
            private.mkdir(mode=0o700)
        found = private.lstat()
    except OSError as error:
        raise _Refused(f"{private} cannot be made ({error.strerror})") from error
    if shared & (stat.S_IWGRP | stat.S_IWOTH) and not shared & stat.S_ISVTX:
        raise _Refused(f"in {place} others may replace what is not theirs")
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid() or found.st_mode & 0o077:
        raise _Refused(f"{private} is a link, or open to others, or belongs to somebody else")
    return _made(private / NAME)


def _made(folder: Path) -> Path:
    """The folder, in which a file could be written.

    Raises:
        _Refused: If none could.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"something")
            file.flush()
    except OSError as error:
        raise _Refused(f"{folder} cannot be written ({error.strerror})") from error
    return folder
