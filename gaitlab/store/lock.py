"""Who works in a store: locks that name their holder and die with it.

From the wide to the narrow:

- the store's: whoever writes into it shares it, whoever changes it as a whole has it alone;
- an experiment's, or one for each of its shards, so that nobody runs the same work twice;
- a trial's, its claim: who comes to a trial that another run is simulating leaves it to that one.

All are the kernel's, not the file's: a file left by a dead run, or copied elsewhere with the store,
holds nothing. Readers never ask for one.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

from gaitlab.errors import StoreError
from gaitlab.store.durable import NotAFile, read_whole, refuse_links, unwritable, without_links

STORE, LOCKS, CLAIMS = "lock", "locks", "claims"  # files and a folder of a store
WHOLE = "whole"  # lock of an experiment; its shards share it
LOOK = 0.05  # s between two tries
PATIENCE = 1.0  # s; whoever only looks whether a lock is free holds it for an instant
SWEEPING = 60.0  # s that another run may take to clear a large store on a slow disk
CLAIM_DIGITS = 15  # hex digits of a trial's id that are the place of its claim
_LOCKLESS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP)


class InUse(StoreError):
    """Somebody else holds what was asked for."""


@dataclass(frozen=True, kw_only=True)
class Held:
    """A store that this process writes into.

    Attributes:
        path: File of the store's lock.
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
def alone(store: Path) -> Iterator[Held]:
    """Hold a whole store, in which nobody else writes meanwhile.

    Raises:
        StoreError: If others do (names them), or the folder cannot be written.
    """
    with _opened(store / STORE) as descriptor:
        if not _taken(store / STORE, descriptor, fcntl.LOCK_EX, PATIENCE):
            raise InUse(
                f"{store}: {_holders(store)}. This changes the store as a whole: wait until it is "
                "free, or choose another folder with --store DIR."
            )
        _sign(store / STORE, descriptor)
        try:
            yield Held(path=store / STORE, descriptor=descriptor)
        finally:
            with suppress(OSError):  # those who wait shall not take it for long work
                os.ftruncate(descriptor, 0)


@contextmanager
def writing(store: Path, clear: Callable[[], object]) -> Iterator[Held]:
    """Write into a store beside others who write into it.

    Args:
        store: Its folder.
        clear: Is called if nobody else is at work in it.

    Raises:
        StoreError: If somebody changes it as a whole (names host, process and start), or the
            folder cannot be written.
    """
    path = store / STORE
    with _opened(path) as descriptor:
        _require_signed_or_empty(path, descriptor)
        if _taken(path, descriptor, fcntl.LOCK_EX):
            os.ftruncate(descriptor, 0)
            clear()
        end = time.monotonic() + SWEEPING
        while not _taken(path, descriptor, fcntl.LOCK_SH, PATIENCE):
            if _signature(path) or time.monotonic() > end:
                raise InUse(
                    f"{store}: another process changes this store as a whole ({_holder(path)}). "
                    "Wait until it ends, or choose another folder with --store DIR."
                )
        yield Held(path=path, descriptor=descriptor)


class Part(NamedTuple):
    """What of an experiment a run takes for itself.

    Attributes:
        name: Of the experiment, as it is listed.
        shard: Of which shard, `3-of-8`; empty for all of it.
        others: Whether other runs may do the same beside this one, since they share a search.
    """

    name: str
    shard: str = ""
    others: bool = False


@contextmanager
def reserved(store: Path, part: Part) -> Iterator[None]:
    """Keep other runs from an experiment, or from one shard of it.

    Raises:
        StoreError: If another one is at it (names host, process and start).
    """
    folder = store / LOCKS / part.name
    refuse_links(folder / WHOLE, store)
    shared = bool(part.shard) or part.others
    kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    with _opened(folder / WHOLE) as whole:
        if not _taken(folder / WHOLE, whole, kind, PATIENCE):
            raise InUse(_refusal(store, part.name, alone=not shared))
        if not shared:
            _sign(folder / WHOLE, whole)
        if not part.shard:
            yield
            return
        with _opened(folder / part.shard) as descriptor:
            if not _taken(folder / part.shard, descriptor, fcntl.LOCK_EX, PATIENCE):
                raise InUse(
                    f"{store}: shard {part.shard} of {part.name} is run by another process "
                    f"({_holder(folder / part.shard)}). Wait until it ends."
                )
            _sign(folder / part.shard, descriptor)
            yield


def shards_at_work(store: Path, experiment: str) -> dict[str, str]:
    """Who runs which shard of an experiment now: `3-of-8` to host, process and start."""
    folder = store / LOCKS / experiment
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return {}
    return {
        name: _holder(folder / name) for name in names if name != WHOLE and _is_held(folder / name)
    }


def at_work(store: Path) -> dict[str, str]:
    """Who runs what in a store now: an experiment, or shard of it, to host, process and start."""
    try:
        experiments = sorted(os.listdir(store / LOCKS))
    except OSError:
        return {}
    holders: dict[str, str] = {}
    for name in experiments:
        shards = shards_at_work(store, name)
        holders |= {f"{name}, shard {shard}": holder for shard, holder in shards.items()}
        path = store / LOCKS / name / WHOLE
        if not shards and _is_held(path):
            holders[name] = _holder(path)
    return holders


class Claims:
    """Trials that this process is simulating, so that other runs on the store leave them to it.

    A claim is one byte of a file, locked at a place that the trial's id gives; the byte is never
    written. The kernel gives up the claims of a process that dies.

    Args:
        store: Folder of the store.
    """

    def __init__(self, store: Path) -> None:
        self._path = store / CLAIMS
        self._descriptor: int | None = None

    def take(self, trial_id: str) -> bool:
        """Claim a trial; False if another process has it.

        Raises:
            StoreError: If the file cannot be written.
        """
        try:
            if self._descriptor is None:
                self._descriptor = without_links(self._path, os.O_RDWR | os.O_CREAT)
            fcntl.lockf(
                self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, int(trial_id[:CLAIM_DIGITS], 16)
            )
        except OSError as error:
            if error.errno in (errno.EACCES, errno.EAGAIN) and self._descriptor is not None:
                return False
            raise unwritable(self._path, error) from error
        except NotAFile as error:
            raise unwritable(self._path, error) from error
        return True

    def release(self, trial_id: str) -> None:
        """Give a claim up."""
        if self._descriptor is not None:
            fcntl.lockf(self._descriptor, fcntl.LOCK_UN, 1, int(trial_id[:CLAIM_DIGITS], 16))

    def close(self) -> None:
        """Give every claim up."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


@contextmanager
def _opened(path: Path) -> Iterator[int]:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = without_links(path, os.O_RDWR | os.O_CREAT)
    except (OSError, NotAFile) as error:
        raise unwritable(path, error) from error
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _taken(path: Path, descriptor: int, kind: int, patience: float = 0.0) -> bool:
    """Take a lock of this kind within a time in [s]; whether that was possible."""
    end = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            time.sleep(LOOK)
        except OSError as error:
            if error.errno not in _LOCKLESS:
                raise unwritable(path, error) from error
            raise StoreError(
                f"{path}: this file system has no locks ({error.strerror}); "
                "choose a folder on a local disk with --store DIR and copy it afterwards."
            ) from error
        else:
            return True


def _is_held(path: Path) -> bool:
    """Whether somebody holds a lock alone; False if that cannot be told."""
    try:
        descriptor = without_links(path, os.O_RDONLY)
    except (OSError, NotAFile):
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return False


def _sign(path: Path, descriptor: int) -> None:
    _require_signed_or_empty(path, descriptor)
    since = datetime.now(timezone.utc).isoformat(timespec="seconds")
    holder = {"host": socket.gethostname(), "pid": os.getpid(), "since": since}
    try:
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(holder).encode() + b"\n", 0)
    except OSError as error:
        raise unwritable(path, error) from error


def _require_signed_or_empty(path: Path, descriptor: int) -> None:
    """Leave a file alone that somebody else put where a lock should be."""
    if os.fstat(descriptor).st_size and _signature(path) is None:
        raise StoreError(
            f"{path}: not a lock that gaitlab wrote; move it away, or choose another folder with "
            "--store DIR"
        )


def _refusal(store: Path, experiment: str, *, alone: bool) -> str:
    """Why an experiment cannot be run now, and what can."""
    shards = shards_at_work(store, experiment) if alone else {}
    if shards:
        holders = "; ".join(f"shard {shard}: {holder}" for shard, holder in shards.items())
        return (
            f"{store}: {experiment} is run in shards ({holders}). Wait until they end; the same "
            "command then picks up what they leave."
        )
    return (
        f"{store}: {experiment} is run by another process "
        f"({_holder(store / LOCKS / experiment / WHOLE)}). Wait until it ends. To share an "
        f"experiment out, start all of it as `gaitlab run {experiment} --shard 1/2` and "
        "`--shard 2/2`, or with --dask; a study with --storage or --dask."
    )


def _holders(store: Path) -> str:
    holders = at_work(store)
    if not holders:
        return f"another process uses this store ({_holder(store / STORE)})"
    return "; ".join(f"{what} is run by {holder}" for what, holder in holders.items())


def _holder(path: Path) -> str:
    return _signature(path) or "it has not signed"


def _signature(path: Path) -> str | None:
    """Who signed a lock; None if nobody did."""
    try:
        holder = json.loads(read_whole(path))
        return f"host {holder['host']}, process {holder['pid']}, since {holder['since']}"
    except (OSError, StoreError, ValueError, KeyError, TypeError, RecursionError):
        return None
