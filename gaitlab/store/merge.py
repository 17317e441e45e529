"""Two stores into one: every trial of both is there afterwards, wherever they disagree twice."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from gaitlab.errors import StoreError, UsageError
from gaitlab.store.durable import NotAFile, read_whole, write_durably
from gaitlab.store.fingerprint import fingerprint
from gaitlab.store.index import ENDING, files_among
from gaitlab.store.lists import EARLIER, LIST, DamagedList, TrialList, encode_list, read_list
from gaitlab.store.parquet import Unreadable, read_record
from gaitlab.store.store import Store

DIGEST_LENGTH = 8  # hex digits that tell apart what has the same name in both stores
_Fate = Literal["taken", "shared", "conflict"]


@dataclass(frozen=True, kw_only=True)
class Merged:
    """What became of the trials and experiments of the store that was merged in.

    Attributes:
        taken: Trials that only it had, or had in a better state.
        shared: Trials that both had, bit for bit the same, or better here.
        conflicts: What both had and do not agree on, with where the other one is kept.
        refused: Files of it that are no whole trials; they stay where they are.
    """

    taken: int
    shared: int
    conflicts: tuple[str, ...]
    refused: tuple[str, ...]


def merge(into: Store, other: Store) -> Merged:
    """Add everything that another store holds; the other one is only read.

    A trial that was done in one store and failed in the other counts as done. A trial that was done
    in both with different numbers stays as it is here; the other one is kept in `conflicts/`.

    Raises:
        UsageError: If the two are the same, or the other one is no store.
        StoreError: If the store is held by a run or cannot be written.
    """
    _check(into, other)
    with into.alone():
        trials = _Trials(into)
        for name, _ in sorted(files_among(other.path / "trials")):
            if name.endswith(ENDING) or os.path.islink(name):
                trials.take(Path(name))
        conflicts = [message for folder in _lists(other) for message in _take_list(into, folder)]
        into.compact()
        into.tabulate()
    return Merged(
        taken=trials.counts["taken"],
        shared=trials.counts["shared"],
        conflicts=(*trials.conflicts, *conflicts),
        refused=tuple(trials.refused),
    )


def _check(into: Store, other: Store) -> None:
    if not (other.path / "trials").is_dir():
        raise UsageError(f"{other.path}: no store, it has no folder `trials`; name the other one")
    if into.path.exists() and os.path.samefile(into.path, other.path):
        raise UsageError(f"{into.path} and {other.path} are the same store; name two")


class _Trials:
    """Takes trials into a store and counts what became of them."""

    def __init__(self, into: Store) -> None:
        self._into = into
        self.counts: Counter[_Fate] = Counter()
        self.conflicts: list[str] = []
        self.refused: list[str] = []

    def take(self, path: Path) -> None:
        """Take one file, if it is a whole trial."""
        try:
            theirs = fingerprint(path)
        except FileNotFoundError:
            return  # removed since the folder was listed
        except Unreadable as error:
            self.refused.append(str(error))
            return
        self.counts[self._settle(path, theirs)] += 1

    def _settle(self, path: Path, theirs: str) -> _Fate:
        target = self._into.file(path.stem)
        ours = self._ours(target)
        if ours is None:
            self._into.make_way(target)
            self._copy(path, target)
            return "taken"
        if ours == theirs or _failed(path):
            return "shared"
        if _failed(target):
            self._copy(path, target)
            return "taken"
        kept = self._into.path / "conflicts" / f"{path.stem}.{theirs[:DIGEST_LENGTH]}.parquet"
        self._copy(path, kept)
        self.conflicts.append(
            f"trial {path.stem}: the two stores disagree; {target} stays, the other is {kept}"
        )
        return "conflict"

    def _copy(self, path: Path, target: Path) -> None:
        write_durably(target, read_whole(path), within=self._into.path)

    def _ours(self, target: Path) -> str | None:
        try:
            return fingerprint(target)
        except FileNotFoundError:
            return None
        except Unreadable as error:
            if error.kind == "unreachable":
                raise StoreError(f"{error}; it is left as it is") from error
            return None


def _failed(path: Path) -> bool:
    return read_record(path).state == "FAILED"


def _lists(store: Store) -> list[Path]:
    return sorted(path.parent for path in (store.path / "experiments").glob(f"*/{LIST}"))


def _take_list(into: Store, folder: Path) -> Iterator[str]:
    """Take the list of an experiment, if ours does not hold all of it; gives conflicts.

    Of two lists of which one holds the other, with fewer seeds for instance, the longer one stays.
    """
    try:
        theirs = read_list(folder)
    except DamagedList as error:
        yield str(error)
        return
    target = into.path / "experiments" / folder.name
    if not (target / LIST).exists():
        _copy_list(into, folder, target)
        return
    more, fewer = _ids(theirs) - _ids_in(target), _ids_in(target) - _ids(theirs)
    if not more:
        return
    if not fewer:
        _copy_list(into, folder, target)
        return
    digest = hashlib.sha256(read_whole(folder / LIST)).hexdigest()[:DIGEST_LENGTH]
    name = f"{folder.name[: 99 - DIGEST_LENGTH]}+{digest}"
    kept = into.path / "experiments" / name
    if not (kept / LIST).exists():
        _copy_list(into, folder, kept)
        content = encode_list(replace(theirs, experiment=name))
        write_durably(kept / LIST, content, within=into.path)
    yield f"experiment {folder.name}: the two lists of trials differ; the other one is now {name}"


def _ids(found: TrialList) -> set[str]:
    return {listed.trial_id for listed in found.trials}


def _ids_in(folder: Path) -> set[str]:
    """What our own list holds; nothing if it is damaged."""
    try:
        return _ids(read_list(folder))
    except DamagedList:
        return set()


def _copy_list(into: Store, folder: Path, target: Path) -> None:
    """The list last: it is what makes the folder an experiment."""
    for name in ("experiment.yaml", EARLIER, LIST):
        with suppress(FileNotFoundError, NotAFile):
            write_durably(target / name, read_whole(folder / name), within=into.path)
