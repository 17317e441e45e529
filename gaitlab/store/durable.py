"""Files that are either whole or not there, whatever kills the writer."""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Iterator
from pathlib import Path

from gaitlab.errors import StoreError

PARTIAL = ".tmp"  # ending of a file that is still being written
LEAST_ROOM = 1 << 20  # byte worth freeing, however short the file that found none
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_STARVED = (errno.ENOMEM, errno.EMFILE, errno.ENFILE)


class StoreFull(StoreError):
    """There is no room for a file: the disk, a quota or the largest length of a file."""


def write_durably(path: Path, content: bytes) -> None:
    """Put a file in place in one step: beside, fsync, rename, fsync of the folder.

    Raises:
        StoreError: If the disk is full, or the folder cannot be written or has vanished.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}{PARTIAL}")
    try:
        _make_folder(path.parent)
        _write_synced(partial, content)
        os.replace(partial, path)
        _sync_folder(path.parent)
    except OSError as error:
        _remove_quietly(partial)
        raise unwritable(path, error, len(content)) from error


def append(path: Path, line: bytes) -> None:
    """Add one line to a file of lines, on a line of its own even after a torn one.

    Not synced: only for what can be rebuilt.

    Raises:
        StoreError: If the line cannot be written.
    """
    try:
        with path.open("a+b") as file:
            size = file.seek(0, os.SEEK_END)
            if size:
                file.seek(size - 1)
            start = b"\n" if size and file.read(1) != b"\n" else b""
            file.write(start + line + b"\n")
    except OSError as error:
        raise unwritable(path, error, len(line)) from error


def sweep(folder: Path) -> int:
    """Remove what writers left half-written below a folder; says how many files."""
    stale = list(_partial_files(folder))
    for path in stale:
        _remove_quietly(path)
    return len(stale)


def unwritable(path: Path, error: OSError, size: int = 0) -> StoreError:
    """The error of the operating system in the user's words, with what to do."""
    what = os.strerror(error.errno) if error.errno else str(error)
    room = f"{max(size, LEAST_ROOM) / 1e6:.0f} MB"
    advice = {
        errno.ENOSPC: f"the disk is full; free at least {room}",
        errno.EDQUOT: f"your quota is used up; free at least {room}",
        errno.EFBIG: f"files may not be that long here; allow at least {room} with `ulimit -f`",
        errno.EROFS: "the file system is read-only; choose another folder with --store DIR",
        errno.ENOENT: "the folder has vanished while it was in use",
    }.get(error.errno or 0, "make it writable or choose another folder with --store DIR")
    kind = StoreFull if error.errno in _NO_ROOM else StoreError
    return kind(
        f"{path}: cannot be written ({what}): {advice}. "
        "What is committed is safe; the same command goes on from there."
    )


def open_to_read(path: Path) -> io.FileIO:
    """A file of the store, open.

    Raises:
        OSError: If it cannot be opened.
    """
    return io.FileIO(path)


def unreachable(path: Path, error: Exception) -> StoreError:
    """What keeps a file of the store from being read, with what to do."""
    return StoreError(f"{path}: {hindrance(error)}")


def hindrance(error: Exception) -> str:
    """The same without the name of the file."""
    number = errno.ENOMEM if isinstance(error, MemoryError) else getattr(error, "errno", None)
    what = os.strerror(number) if number else str(error)
    advice = {
        errno.ENOMEM: "the file may be whole; free some memory, or use fewer workers with -j",
        errno.EMFILE: "the file may be whole; allow more open files with `ulimit -n`",
        errno.ENFILE: "the file may be whole; this machine has too many files open",
        errno.EIO: "the disk or the network fails; mend it, or copy the store to another disk",
    }.get(
        number or 0,
        "give yourself permission to read the whole folder, or choose another one with --store DIR",
    )
    return f"cannot be read ({what}); {advice}"


def starved(error: Exception) -> bool:
    """Whether this process lacks memory or open files, so that no file at all can be judged."""
    return isinstance(error, MemoryError) or getattr(error, "errno", None) in _STARVED


def _make_folder(folder: Path) -> None:
    if folder.is_dir():
        return
    folder.mkdir(parents=True, exist_ok=True)
    _sync_folder(folder.parent)


def _write_synced(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove_quietly(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return  # it ends in .tmp, so nobody will ever count it


def _partial_files(folder: Path) -> Iterator[Path]:
    for place, _, names in os.walk(folder):
        yield from (Path(place, name) for name in names if name.endswith(PARTIAL))
