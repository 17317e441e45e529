"""The index: one line a trial, so that nobody has to open every trial's file.

It is derived. Whatever is wrong with it (torn, stale, gone) is put right from the trials' files,
and whoever reads it does so: a line counts only while a file of that name and size is there.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from gaitlab.store.durable import (
    PARTIAL,
    NotAFile,
    append,
    open_to_read,
    replaced,
    unreachable,
    write_durably,
)
from gaitlab.store.entry import Entry, decode, encode, entry
from gaitlab.store.parquet import Unreadable, read_record

ENDING = ".parquet"
TRIAL_FILE = re.compile(r"[0-9a-f]{32}\.parquet")
LARGEST_INDEX = 4 << 30  # byte, of some million trials; a longer one is made anew
LONGEST_LINE = 1 << 20  # byte
BUFFER = 1 << 18  # byte read at once
ID_END = 32 + len(ENDING)  # characters at the end of a path that hold the trial's id


@dataclass(frozen=True, kw_only=True)
class Index:
    """All trials of a store and the files that are none.

    Attributes:
        entries: Trial id to entry, in the order of the ids.
        unreadable: Files among the trials that are damaged, foreign or of a newer version.
    """

    entries: Mapping[str, Entry]
    unreadable: tuple[Unreadable, ...]


def append_entry(path: Path, item: Entry) -> None:
    """Add a trial to the index file."""
    append(path, encode(item))


def write_entries(path: Path, entries: Iterable[Entry]) -> None:
    """Replace the index file: one line a trial, sorted by id, so equal trials give equal bytes."""
    ordered = sorted(entries, key=lambda item: item.trial_id)
    content = b"".join(b"%b\n" % encode(item) for item in ordered)
    write_durably(path, content, within=path.parent)


class Known(NamedTuple):
    """What an index file says.

    Attributes:
        entries: Trial id to entry; the last line of a trial wins.
        tidy: Whether every line is whole and the trials stand in the order of their ids.
    """

    entries: dict[str, Entry]
    tidy: bool


def read_entries(path: Path) -> Known:
    """Every readable line of the index file; none if there is no file.

    Raises:
        StoreError: If the file may not be read.
    """
    entries: dict[str, Entry] = {}
    tidy, last = True, ""
    for line in _lines(path):
        item = decode(line.rstrip(b"\n"), path.parent / "trials")
        if item is None:  # torn: its trial is read from its own file
            tidy = False
            continue
        tidy = tidy and item.trial_id > last
        last = item.trial_id
        entries[last] = item
    return Known(entries, tidy)


def _lines(path: Path) -> Iterator[bytes]:
    """Lines, none longer than the longest; what is no plain file has none that count."""
    try:
        with open_to_read(path) as raw, io.BufferedReader(raw, BUFFER) as file:
            if os.fstat(raw.fileno()).st_size > LARGEST_INDEX:
                yield b""
                return
            while line := file.readline(LONGEST_LINE):
                yield line
    except FileNotFoundError:
        return
    except NotAFile:
        yield b""
    except OSError as error:
        if not replaced(error):
            raise unreachable(path, error) from error
        yield b""  # another run has put it in order meanwhile; the trials' files say the rest


def reconcile(trials: Path, known: Mapping[str, Entry]) -> Index:
    """What the trials' files say, taking from `known` whatever is still there unchanged."""
    entries: dict[str, Entry] = {}
    unreadable: list[Unreadable] = []
    for name, size in sorted(files_among(trials)):  # text: a hundred thousand Paths take seconds
        path_id = name[-ID_END:].removesuffix(ENDING)
        item = known.get(path_id)
        if item is not None and item.size == size and name.endswith(_tail(path_id)):
            entries[path_id] = item
            continue
        path = Path(name)
        try:
            entries[path.stem] = _read_entry(path, size)
        except FileNotFoundError:
            continue  # removed since the folder was listed
        except Unreadable as error:
            unreadable.append(error)
    return Index(entries=entries, unreadable=tuple(unreadable))


def _read_entry(path: Path, size: int) -> Entry:
    if not TRIAL_FILE.fullmatch(path.name):
        raise Unreadable(path, "foreign", "not the name of a trial")
    if path.parent.name != path.name[:2]:
        raise Unreadable(path, "foreign", f"belongs in the folder {path.name[:2]}")
    return entry(read_record(path), size)


def _tail(trial_id: str) -> str:
    """How the path of a trial's file ends."""
    return f"{os.sep}{trial_id[:2]}{os.sep}{trial_id}{ENDING}"


def signature(trials: Path) -> str:
    """Digest of the names and sizes of all trials' files, wherever the store lies."""
    names = (f"{os.path.basename(name)} {size}" for name, size in files_among(trials))
    text = "\n".join(sorted(names))
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()


def files_among(trials: Path) -> Iterator[tuple[str, int]]:
    """Path and length of everything among the trials, that which is no trial too.

    Raises:
        StoreError: If a folder cannot be read.
    """
    try:
        with os.scandir(trials) as folders:
            for folder in folders:
                yield from _files_in(folder)
    except FileNotFoundError:
        return  # no store yet, or a folder has just been removed
    except OSError as error:
        raise unreachable(trials, error) from error


def _files_in(folder: os.DirEntry[str]) -> Iterator[tuple[str, int]]:
    if not folder.is_dir(follow_symlinks=False):
        yield folder.path, _size(folder)
        return
    with os.scandir(folder.path) as files:
        for file in files:
            folder_within = file.is_dir(follow_symlinks=False) and not file.name.endswith(ENDING)
            if folder_within or file.name.endswith(PARTIAL):
                continue
            with suppress(FileNotFoundError):  # removed since the folder was listed
                yield file.path, _size(file)


def _size(file: os.DirEntry[str]) -> int:
    """Length in bytes; below zero for a link or another thing that is no file."""
    plain = file.is_file(follow_symlinks=False)
    return file.stat(follow_symlinks=False).st_size if plain else -1
