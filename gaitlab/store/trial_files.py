"""The files of trials: each is put there whole, and read or refused in words one can act on."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from gaitlab.errors import StoreError, UnknownName
from gaitlab.log import TrialLog
from gaitlab.store import parquet
from gaitlab.store.durable import look_anew, refuse_links, unwritable, write_durably
from gaitlab.store.entry import trial_file
from gaitlab.store.lock import Held
from gaitlab.store.parquet import LogPart, Unreadable
from gaitlab.store.record import TrialRecord


def redo(store: Path) -> str:
    """What to do about a damaged trial."""
    from gaitlab.experiment.shell import store_option  # knows experiments, which no worker needs

    command = shlex.join(["gaitlab", "verify", "--repair", *store_option(store)])
    return f"`{command}` sets it aside, then `gaitlab run` of its experiment does this trial again."


class TrialFiles:
    """One file a trial, below the folder `trials`, by the first digits of its id.

    Attributes:
        path: Folder of the store.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._trials = path / "trials"

    def file(self, trial_id: str) -> Path:
        """Where the trial is, or would be."""
        return trial_file(self._trials, trial_id)

    def committed(self, trial_id: str) -> TrialRecord | None:
        """The record of a trial that need not be run again; None if there is none, or it failed.

        The folder is looked at anew, for another machine may have put it there just now.
        """
        look_anew(self.file(trial_id).parent)
        try:
            record = self.record(trial_id)
        except (UnknownName, StoreError):
            return None
        return None if record.state == "FAILED" else record

    def commit(self, record: TrialRecord, log: TrialLog | None) -> None:
        """Keep a trial for good; it is there wholly or not at all, whatever happens meanwhile.

        Raises:
            StoreError: If it cannot be written, or a newer gaitlab has written this trial.
        """
        self.commit_file(record.trial_id, parquet.encode(record, log))

    def commit_file(self, trial_id: str, content: bytes) -> None:
        """The same for the file of a trial that was encoded elsewhere.

        Raises:
            StoreError: If it cannot be written, or a newer gaitlab has written this trial.
        """
        path = self.file(trial_id)
        self.make_way(path)
        write_durably(path, content, within=self.path)

    def make_way(self, path: Path) -> None:
        """Prepare the place of a trial's file: what somebody else wrote there is set aside.

        Raises:
            StoreError: If a newer gaitlab has written this trial, or it may not be read.
        """
        if not os.path.exists(path):
            return
        try:
            parquet.read_record(path)
        except Unreadable as error:
            if error.kind in ("newer", "unreachable"):
                raise StoreError(f"{error}; it is left as it is") from error
            if error.kind in ("foreign", "older"):
                self.set_aside(path)
        except FileNotFoundError:
            return

    def set_aside(self, path: Path) -> Path:
        """Move a file out of the trials without losing it; says where it went."""
        folder = self.path / "aside"
        target = next(p for p in _numbered(folder / path.name) if not os.path.lexists(p))
        for place in (path, target):
            refuse_links(place, self.path)
        try:
            folder.mkdir(exist_ok=True)
            os.replace(path, target)
        except OSError as error:
            raise unwritable(path, error) from error
        return target

    def record(self, trial_id: str) -> TrialRecord:
        """The record of a trial.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, foreign or of a newer version.
        """
        with self._read(trial_id) as path:
            return parquet.read_record(path)

    def log(self, trial_id: str) -> TrialLog:
        """The log of a trial, bit for bit as it was recorded.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, or the trial ended without a log.
        """
        record = self.record(trial_id)
        with self._read(trial_id) as path:
            log = parquet.read_log(path)
        if log is None:
            raise self._without_log(record)
        return log

    def log_part(self, trial_id: str, names: Sequence[str]) -> LogPart:
        """Some columns of a trial's log, without the time that reading all of them takes.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, or the trial ended without a log.
        """
        with self._read(trial_id) as path:
            part = parquet.read_columns(path, names)
        if part is None:
            raise self._without_log(self.record(trial_id))
        return part

    def log_digest(self, trial_id: str) -> str:
        """SHA-256 of the log's columns, bit for bit, as its file states it; the log is not read.

        Raises:
            UnknownName: If the store does not hold the trial.
            StoreError: If its file is damaged.
        """
        with self._read(trial_id) as path:
            return parquet.written_sha256(path)

    def discard(self, trial_ids: Iterable[str], held: Held) -> None:
        """Drop trials that are to be simulated anew. Only for who has the store alone."""
        held.check()
        for trial_id in trial_ids:
            refuse_links(self.file(trial_id), self.path)
            self.file(trial_id).unlink(missing_ok=True)

    @contextmanager
    def _read(self, trial_id: str) -> Iterator[Path]:
        """File of a trial; what reading it raises becomes an error for the user."""
        try:
            yield self.file(trial_id)
        except FileNotFoundError as error:
            raise self._unknown(trial_id) from error
        except Unreadable as error:
            raise StoreError(f"{error}. {redo(self.path)}") from error

    def _without_log(self, record: TrialRecord) -> StoreError:
        why = f"it ended {record.state}: {record.reason}"
        return StoreError(f"{record.trial_id} has no log: {why}")

    def _unknown(self, trial_id: str) -> UnknownName:
        return UnknownName(
            f'{self.path}: no trial {trial_id}; `gaitlab query "SELECT trial_id FROM trials"` '
            "lists those that are there"
        )


def _numbered(path: Path) -> Iterator[Path]:
    yield path
    yield from (path.with_name(f"{path.name}.{number}") for number in count(1))
