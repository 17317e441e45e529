"""The index: one line a trial, so that nobody has to open every trial's file.

It is derived. Whatever is wrong with it (torn, stale, gone) is put right from the trials' files,
and whoever reads it does so: a line counts only while a file of that name and size is there.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gaitlab.store.durable import PARTIAL, append, write_durably
from gaitlab.store.parquet import Unreadable, read_record
from gaitlab.store.record import Scalar, State, TrialRecord, canonical, finite, lasting

ENDING = ".parquet"
TRIAL_FILE = re.compile(r"[0-9a-f]{32}\.parquet")
ID_END = 32 + len(ENDING)  # characters at the end of a path that hold the trial's id


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What the index knows of one trial.

    Attributes:
        trial_id: Identity of the trial.
        size: Length of its file, in bytes.
        state: `DONE`, `INFEASIBLE` or `FAILED`.
        reason: First line of the record's reason.
        labels: Robot, gait and surface by name, and the seed.
        metrics: As in the record.
        provenance: As in the record, without what differs between two equal runs.
    """

    trial_id: str
    size: int
    state: State
    reason: str
    labels: Mapping[str, Scalar]
    metrics: Mapping[str, Scalar]
    provenance: Mapping[str, Scalar]


@dataclass(frozen=True, kw_only=True)
class Index:
    """All trials of a store and the files that are none.

    Attributes:
        entries: Trial id to entry, in the order of the ids.
        unreadable: Files among the trials that are damaged, foreign or of a newer version.
    """

    entries: Mapping[str, Entry]
    unreadable: tuple[Unreadable, ...]


def entry(record: TrialRecord, size: int) -> Entry:
    """The line of the index that stands for a record whose file has this size, in bytes."""
    names = record.trial.get("names", {})
    labels = {kind: names.get(kind) for kind in ("robot", "gait", "surface")}
    return Entry(
        trial_id=record.trial_id,
        size=size,
        state=record.state,
        reason=next(iter(record.reason.splitlines()), ""),
        labels={**labels, "seed": record.trial.get("seed")},
        metrics={name: finite(value) for name, value in record.metrics.items()},
        provenance=lasting(record.provenance),
    )


def append_entry(path: Path, item: Entry) -> None:
    """Add a trial to the index file."""
    append(path, canonical(asdict(item)).encode())


def write_entries(path: Path, entries: Iterable[Entry]) -> None:
    """Replace the index file: one line a trial, sorted by id, so equal trials give equal bytes."""
    ordered = sorted(entries, key=lambda item: item.trial_id)
    lines = "".join(f"{canonical(asdict(item))}\n" for item in ordered)
    write_durably(path, lines.encode())


def read_entries(path: Path) -> dict[str, Entry]:
    """Every readable line of the index file, the last of a trial wins; {} if there is no file."""
    try:
        lines = path.read_bytes().splitlines()
    except FileNotFoundError:
        return {}
    found = (_parse(line) for line in lines)
    return {item.trial_id: item for item in found if item is not None}


def reconcile(trials: Path, known: Mapping[str, Entry]) -> Index:
    """What the trials' files say, taking from `known` whatever is still there unchanged."""
    entries: dict[str, Entry] = {}
    unreadable: list[Unreadable] = []
    for name, size in sorted(_files(trials)):  # text: a hundred thousand Paths take seconds
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


def _files(trials: Path) -> Iterator[tuple[str, int]]:
    if not trials.is_dir():
        return
    with os.scandir(trials) as folders:
        for folder in folders:
            yield from _files_in(folder)


def _files_in(folder: os.DirEntry[str]) -> Iterator[tuple[str, int]]:
    if not folder.is_dir():
        yield folder.path, folder.stat(follow_symlinks=False).st_size
        return
    with os.scandir(folder.path) as files:
        for file in files:
            if not file.name.endswith(PARTIAL) and not file.is_dir():
                yield file.path, file.stat(follow_symlinks=False).st_size


def _parse(line: bytes) -> Entry | None:
    try:
        content: dict[str, Any] = json.loads(line)
        return Entry(**content)
    except (ValueError, TypeError):
        return None  # a torn line: its trial is read from its own file
