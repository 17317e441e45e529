"""One run at a time on a store: a lock that names its holder and dies with it.

The lock is the kernel's (flock), not the file: a file left by a dead run, or copied elsewhere with
the store, holds nothing. Readers never ask for it.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from gaitlab.errors import StoreError
from gaitlab.store.durable import NotAFile, read_whole, unwritable, without_links


@dataclass(frozen=True, kw_only=True)
class Held:
    """A store that this process holds.

    Attributes:
        path: File of the lock.
        descriptor: The same, open.
    """

    path: Path
    descriptor: int

    def check(self) -> None:
        """Make sure that the folder is still the one that was taken.

        Raises:
            StoreError: If it was removed, replaced or unmounted meanwhile.
        """
        try:
            there = os.path.samestat(os.stat(self.path), os.fstat(self.descriptor))
        except OSError as error:
            raise unwritable(self.path.parent, error) from error
        if not there:
            raise unwritable(self.path.parent, FileNotFoundError(errno.ENOENT, "replaced"))


@contextmanager
def locked(path: Path) -> Iterator[Held]:
    """Hold the store for this process.

    Raises:
        StoreError: If another run holds it (names host, process and start), or the folder cannot
            be written.
    """
    descriptor = _open(path)
    try:
        _acquire(descriptor, path)
        _sign(descriptor, path)
        yield Held(path=path, descriptor=descriptor)
    finally:
        os.close(descriptor)


def _open(path: Path) -> int:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return without_links(path, os.O_RDWR | os.O_CREAT)
    except (OSError, NotAFile) as error:
        raise unwritable(path, error) from error


def _acquire(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise StoreError(
            f"{path.parent}: another run is using this store ({_holder(path)}). "
            "Wait until it ends, or choose another folder with --store DIR."
        ) from error
    except OSError as error:
        if error.errno not in (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP):
            raise unwritable(path, error) from error
        raise StoreError(
            f"{path}: this file system has no locks ({error.strerror}); "
            "choose a folder on a local disk with --store DIR and copy it afterwards."
        ) from error


def _sign(descriptor: int, path: Path) -> None:
    if os.fstat(descriptor).st_size and _signature(path) is None:
        raise StoreError(
            f"{path}: not a lock that gaitlab wrote; move it away, or choose another folder with "
            "--store DIR"
        )
    since = datetime.now(timezone.utc).isoformat(timespec="seconds")
    holder = {"host": socket.gethostname(), "pid": os.getpid(), "since": since}
    try:
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(holder).encode() + b"\n", 0)
    except OSError as error:
        raise unwritable(path, error) from error


def _holder(path: Path) -> str:
    return _signature(path) or "it has not signed yet"


def _signature(path: Path) -> str | None:
    """Who signed a lock; None if nobody did."""
    try:
        holder = json.loads(read_whole(path))
        return f"host {holder['host']}, process {holder['pid']}, since {holder['since']}"
    except (OSError, StoreError, ValueError, KeyError, TypeError, RecursionError):
        return None
