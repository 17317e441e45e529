"""Files of a store: whole or not there, whatever kills the writer, and never behind a link.

A store may come from somebody else. What is in it is read only if it is a plain file, and nothing
is opened for writing through a link, which could lead anywhere.
"""

from __future__ import annotations

import errno
import io
import os
import secrets
import stat
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import takewhile
from pathlib import Path

from gaitlab.documents.outputs import sync
from gaitlab.errors import StoreError

PARTIAL = ".tmp"  # ending of a file that is still being written
LARGEST = 1 << 30  # byte of a file that is read at once
LEAST_ROOM = 1 << 20  # byte worth freeing, however short the file that found none
TRIES = 4  # of a rename that a server may have carried out although it answers that it has not
BETWEEN_TRIES = 0.25  # s, doubled every time
_PERHAPS_DONE = (errno.ENOENT, errno.EEXIST, errno.ESTALE)
_WRITER = secrets.token_hex(4)  # of this process; process ids repeat themselves on other machines
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_RENAMELESS = (errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EXDEV)
_STARVED = (errno.ENOMEM, errno.EMFILE, errno.ENFILE)


class StoreFull(StoreError):
    """There is no room for a file: the disk, a quota or the largest length of a file."""


class NotAFile(ValueError):
    """A link, a pipe, a device or something endless is where a file of the store should be."""


def write_durably(path: Path, content: bytes, *, within: Path) -> None:
    """Put a file in place in one step: beside, fsync, rename, fsync of the folder.

    Args:
        path: The file.
        content: All of it.
        within: Folder of the store; no folder below it may be a link.

    Raises:
        StoreError: If the disk is full, or the folder cannot be written, is a link or has vanished.
    """
    refuse_links(path, within)
    partial = path.with_name(f"{path.name}.{_WRITER}.{os.getpid()}{PARTIAL}")
    try:
        _make_folder(path.parent)
        _write_synced(partial, content)
        _rename(partial, path)
        sync(path.parent)
    except OSError as error:
        _remove_quietly(partial)
        raise unwritable(path, error, len(content)) from error


def _rename(partial: Path, path: Path) -> None:
    """Give a file its name.

    A network file system whose answer was lost asks again, and may then be told that there is no
    such file, although, or because, the first time worked. So whether it is the same file that
    now has the name decides, and not the answer.
    """
    written = os.stat(partial)
    for attempt in range(TRIES):
        try:
            os.replace(partial, path)
        except OSError as error:
            if error.errno not in _PERHAPS_DONE:
                raise
            if _is_now(path, written):
                return
            if attempt + 1 == TRIES or not path.parent.is_dir():
                raise
            time.sleep(BETWEEN_TRIES * 2**attempt)
        else:
            return


def _is_now(path: Path, written: os.stat_result) -> bool:
    """Whether the file that was written has this name, once its folder has been looked at anew."""
    look_anew(path.parent)
    try:
        return os.path.samestat(os.lstat(path), written)
    except OSError:
        return False


def append(path: Path, line: bytes) -> None:
    """Add one line to a file of lines, on a line of its own even after a torn one.

    Not synced: only for what can be rebuilt.

    Raises:
        StoreError: If the line cannot be written.
    """
    try:
        with open(path, "a+b", opener=without_links) as file:
            size = file.seek(0, os.SEEK_END)
            if size:
                file.seek(size - 1)
            start = b"\n" if size and file.read(1) != b"\n" else b""
            file.write(start + line + b"\n")
    except (OSError, NotAFile) as error:
        raise unwritable(path, error, len(line)) from error


def sweep(folder: Path) -> int:
    """Remove what writers left half-written below a folder; says how many files."""
    stale = list(_partial_files(folder))
    for path in stale:
        _remove_quietly(path)
    return len(stale)


def unwritable(path: Path, error: OSError | NotAFile, size: int = 0) -> StoreError:
    """The error of the operating system in the user's words, with what to do."""
    number = getattr(error, "errno", None)
    what = os.strerror(number) if number else str(error)
    room = f"{max(size, LEAST_ROOM) / 1e6:.0f} MB"
    advice = {
        errno.ENOSPC: f"the disk is full; free at least {room}",
        errno.EDQUOT: f"your quota is used up; free at least {room}",
        errno.EFBIG: f"files may not be that long here; allow at least {room} with `ulimit -f`",
        errno.EROFS: "the file system is read-only; choose another folder with --store DIR",
        errno.ELOOP: "it is a link; move it away",
        errno.ENOENT: "the folder has vanished while it was in use",
        **dict.fromkeys(_RENAMELESS, "files cannot be renamed there; choose another --store DIR"),
    }.get(number or 0, "make it writable or choose another folder with --store DIR")
    kind = StoreFull if number in _NO_ROOM else StoreError
    return kind(
        f"{path}: cannot be written ({what}): {advice}. "
        "What is committed is safe; the same command goes on from there."
    )


def refuse_links(path: Path, within: Path) -> None:
    """Make sure that no folder between a file and the store's own is a link.

    Raises:
        StoreError: If one is.
    """
    for folder in takewhile(lambda parent: parent != within, path.parents):
        if folder.is_symlink():
            raise StoreError(
                f"{folder}: a link to {os.readlink(folder)}; a store writes into no folder but its "
                "own. Put the folder itself there, or choose another store with --store DIR"
            )


def open_to_read(path: Path) -> io.FileIO:
    """A file of the store, open; only a plain file, so that reading it ends.

    Raises:
        NotAFile: If it is a link, a pipe, a device or anything else.
        OSError: If it cannot be opened.
    """
    _require_plain(path, os.lstat(path))  # opening a device can do something
    descriptor = without_links(path, os.O_RDONLY)
    return io.FileIO(descriptor)


def read_whole(path: Path) -> bytes:
    """Everything in a file of the store, even while others replace it.

    Raises:
        FileNotFoundError: If there is none.
        NotAFile: If it is no plain file, or longer than any of gaitlab's.
        StoreError: If it cannot be read.
    """
    for attempt in range(TRIES):
        try:
            with open_to_read(path) as file:
                size = os.fstat(file.fileno()).st_size
                if size > LARGEST:
                    raise NotAFile(f"{size} bytes, more than gaitlab ever writes into one file")
                return file.read()
        except FileNotFoundError:
            raise
        except (OSError, MemoryError) as error:
            if not replaced(error) or attempt + 1 == TRIES:
                raise unreachable(path, error) from error
            look_anew(path.parent)
    raise AssertionError("the last try returns or raises")


def without_links(path: Path | str, flags: int) -> int:
    """Descriptor of a plain file, for `open` or as it is; never waits for one.

    Raises:
        NotAFile: If it is a pipe, a device or anything else.
        OSError: If it is a link or cannot be opened.
    """
    descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    try:
        _require_plain(Path(path), os.fstat(descriptor))
    except NotAFile:
        os.close(descriptor)
        raise
    return descriptor


def _require_plain(path: Path, status: os.stat_result) -> None:
    if stat.S_ISLNK(status.st_mode):
        raise NotAFile(f"a link to {os.readlink(path)}, not a file")
    if not stat.S_ISREG(status.st_mode):
        raise NotAFile("no plain file but a pipe, a device, a folder or the like")


def replaced(error: Exception) -> bool:
    """Whether a file could not be read because a server has another one under its name by now."""
    return getattr(error, "errno", None) == errno.ESTALE


def look_anew(folder: Path) -> None:
    """Ask the file system anew what a folder holds; that of a network remembers for a while."""
    with suppress(OSError):
        os.listdir(folder)


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
    _make_folder(folder.parent)
    folder.mkdir(exist_ok=True)
    sync(folder.parent)


def _write_synced(path: Path, content: bytes) -> None:
    _remove_quietly(path)
    with open(path, "xb", opener=without_links) as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _remove_quietly(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return  # it ends in .tmp, so nobody will ever count it


def _partial_files(folder: Path) -> Iterator[Path]:
    for place, _, names in os.walk(folder):
        yield from (Path(place, name) for name in names if name.endswith(PARTIAL))
