"""A folder of trials that loses nothing: commit, look up, tabulate, query."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from gaitlab.errors import StoreError, UnknownName
from gaitlab.log import TrialLog
from gaitlab.store import parquet
from gaitlab.store.durable import sweep, unwritable, write_durably
from gaitlab.store.entry import entry
from gaitlab.store.index import (
    Index,
    append_entry,
    read_entries,
    reconcile,
    write_entries,
)
from gaitlab.store.lists import (
    Listed,
    TrialList,
    earlier_lists,
    read_list,
    write_list,
    write_listed,
)
from gaitlab.store.lock import Held, locked
from gaitlab.store.parquet import LogPart, Unreadable
from gaitlab.store.record import State, TrialRecord
from gaitlab.store.table_file import TableFile

if TYPE_CHECKING:
    import pandas as pd

    from gaitlab.experiment import Experiment
    from gaitlab.plan import PlannedTrial


TABLE_FROM = 2000  # trials; fewer are tabulated in a tenth of a second
NOTHING: Mapping[str, str] = MappingProxyType({})


class Store:
    """Results in a folder, `data` by default. Opening one touches nothing.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._trials = path / "trials"
        self._experiments = path / "experiments"
        self._index_file = path / "index.jsonl"
        self._table_file = TableFile(path)

    @contextmanager
    def lock(self) -> Iterator[Held]:
        """Hold the store against other runs, first clearing what a killed run left half-written.

        Raises:
            StoreError: If another run holds it (names host, process and start), or the folder
                cannot be written.
        """
        with locked(self.path / "lock") as held:
            sweep(self.path)
            yield held

    def file(self, trial_id: str) -> Path:
        """Where the trial is, or would be."""
        return self._trials / trial_id[:2] / f"{trial_id}.parquet"

    def commit(self, record: TrialRecord, log: TrialLog | None) -> None:
        """Keep a trial for good; it is there wholly or not at all, whatever happens meanwhile.

        Raises:
            StoreError: If it cannot be written, or a newer gaitlab has written this trial.
        """
        path = self.file(record.trial_id)
        self.make_way(path)
        write_durably(path, parquet.encode(record, log))

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
            if error.kind in ("newer", "denied"):
                raise StoreError(f"{error}; it is left as it is") from error
            if error.kind in ("foreign", "older"):
                self.set_aside(path)
        except FileNotFoundError:
            return

    def set_aside(self, path: Path) -> Path:
        """Move a file out of the trials without losing it; says where it went."""
        folder = self.path / "aside"
        target = next(p for p in _numbered(folder / path.name) if not p.exists())
        try:
            folder.mkdir(exist_ok=True)
            os.replace(path, target)
        except OSError as error:
            raise unwritable(path, error) from error
        return target

    def note(self, record: TrialRecord) -> None:
        """Add a committed trial to the index. Only for the run that holds the lock."""
        path = self.file(record.trial_id)
        try:
            size = path.stat().st_size
        except OSError as error:
            raise unwritable(path, error) from error
        append_entry(self._index_file, entry(record, size))

    def index(self) -> Index:
        """What the store holds now; the trials' files decide, nothing is written."""
        return reconcile(self._trials, read_entries(self._index_file).entries)

    def compact(self) -> Index:
        """Put the index file in order, one line a trial. Only for the run that holds the lock."""
        known = read_entries(self._index_file)
        found = reconcile(self._trials, known.entries)
        unchanged = found.entries.keys() == known.entries.keys() and all(
            item is known.entries[key] for key, item in found.entries.items()
        )
        if not (known.tidy and unchanged and self._index_file.exists()):
            write_entries(self._index_file, found.entries.values())
        return found

    def rebuild(self) -> Index:
        """Write the index anew from the trials' files alone. Only under the lock."""
        found = reconcile(self._trials, {})
        write_entries(self._index_file, found.entries.values())
        self._table_file.remove()
        self.tabulate()
        return found

    def tabulate(self) -> None:
        """Keep the table of a large store beside it, for `query`. Only under the lock."""
        if self._table_file.fresh:
            return
        table = self.table()
        if len(table) >= TABLE_FROM:
            self._table_file.write(table)
        else:
            self._table_file.remove()

    def unsound(self) -> Iterator[Unreadable]:
        """Every file among the trials that is not what was written, down to the last column."""
        found = self.index()
        yield from found.unreadable
        for trial_id in found.entries:
            try:
                parquet.read_log(self.file(trial_id))
            except Unreadable as error:
                yield error
            except FileNotFoundError:
                continue  # removed since the folder was listed

    def states(self) -> dict[str, State]:
        """State of every trial by its id."""
        return {key: item.state for key, item in self.index().entries.items()}

    def record(self, trial_id: str) -> TrialRecord:
        """The record of a trial.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, foreign or of a newer version.
        """
        try:
            return parquet.read_record(self.file(trial_id))
        except FileNotFoundError as error:
            raise self._unknown(trial_id) from error
        except Unreadable as error:
            raise StoreError(f"{error}. {_REDO}") from error

    def log(self, trial_id: str) -> TrialLog:
        """The log of a trial, bit for bit as it was recorded.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, or the trial ended without a log.
        """
        record = self.record(trial_id)
        try:
            log = parquet.read_log(self.file(trial_id))
        except Unreadable as error:
            raise StoreError(f"{error}. {_REDO}") from error
        if log is None:
            raise self._without_log(record)
        return log

    def log_part(self, trial_id: str, names: Sequence[str]) -> LogPart:
        """Some columns of a trial's log, without the time that reading all of them takes.

        Raises:
            UnknownName: If the store does not hold it.
            StoreError: If its file is damaged, or the trial ended without a log.
        """
        try:
            part = parquet.read_columns(self.file(trial_id), names)
        except FileNotFoundError as error:
            raise self._unknown(trial_id) from error
        except Unreadable as error:
            raise StoreError(f"{error}. {_REDO}") from error
        if part is None:
            raise self._without_log(self.record(trial_id))
        return part

    def log_digest(self, trial_id: str) -> str:
        """SHA-256 of the log's columns, bit for bit, as its file states it; the log is not read.

        Raises:
            UnknownName: If the store does not hold the trial.
            StoreError: If its file is damaged.
        """
        try:
            return parquet.written_sha256(self.file(trial_id))
        except FileNotFoundError as error:
            raise self._unknown(trial_id) from error
        except Unreadable as error:
            raise StoreError(f"{error}. {_REDO}") from error

    def discard(self, trial_ids: Iterable[str], held: Held) -> None:
        """Drop trials that are to be simulated anew. Only for the run that holds the lock."""
        held.check()
        for trial_id in trial_ids:
            self.file(trial_id).unlink(missing_ok=True)

    def register(
        self,
        experiment: Experiment,
        planned: Iterable[PlannedTrial],
        basis: Mapping[str, str] = NOTHING,
    ) -> TrialList:
        """Keep a copy of the experiment's file and the list of its trials.

        Args:
            experiment: The experiment.
            planned: Its trials.
            basis: Digest of each part that its cells share, by what the part is called.
        """
        return write_list(self._experiments, experiment, planned, basis)

    def register_lines(
        self, experiment: Experiment, lines: Iterable[Listed], basis: Mapping[str, str] = NOTHING
    ) -> TrialList:
        """As `register`, for a search: it proposes its trials as it goes."""
        return write_listed(self._experiments, experiment, lines, basis)

    def earlier(self, experiment: str) -> list[TrialList]:
        """What an experiment of this name has asked for so far, the newest list first."""
        return earlier_lists(self._experiments / experiment)

    def experiments(self) -> dict[str, TrialList]:
        """Every experiment that was run on this store, by name."""
        if not self._experiments.is_dir():
            return {}
        folders = sorted(f for f in self._experiments.iterdir() if (f / "trials.jsonl").is_file())
        return {folder.name: read_list(folder) for folder in folders}

    def table(self, experiment: str | None = None) -> pd.DataFrame:
        """One row for each experiment and trial that is committed.

        Columns: trial_id, experiment, robot, gait, surface, seed, state, reason, every metric,
        every varied parameter under its dotted path, provenance. Rows stand in the order of the
        plan. Without a name, all experiments, and the trials that none asks for any more.

        Raises:
            UnknownName: If the experiment was never run on this store.
        """
        from gaitlab.store.tables import trials_table  # slow to load, and no worker needs it

        entries, lists = self.index().entries, self.experiments()
        chosen = list(lists.values()) if experiment is None else [self._chosen(experiment, lists)]
        return trials_table(entries, chosen, unlisted=experiment is None)

    def outcomes(self, trial_ids: Iterable[str]) -> pd.DataFrame:
        """One row for each of these trials that is committed, whoever asked for it.

        Columns: trial_id, robot, gait, surface, seed, state, reason, every metric, provenance.
        Rows stand in the order of the ids. What else the store holds changes nothing.
        """
        from gaitlab.store.tables import outcomes_table  # slow to load, and no worker needs it

        return outcomes_table(self.index().entries, trial_ids)

    def query(self, sql: str) -> pd.DataFrame:
        """Answer of DuckDB over the views `trials` (see `table`) and `ticks` (trial_id and log).

        Raises:
            UsageError: If the query is wrong; quotes DuckDB and lists the columns.
            StoreError: If it is about `ticks` and a log is damaged.
        """
        from gaitlab.store.tables import select  # slow to load, and no worker needs it

        table = self._table_file.path if self._table_file.fresh else self.table()
        return select(sql, table, self._logs())

    def _logs(self) -> Iterator[Path]:
        for key, item in self.index().entries.items():
            if item.state == "DONE":
                yield self.file(key)

    def _chosen(self, name: str, lists: dict[str, TrialList]) -> TrialList:
        if name not in lists:
            known = ", ".join(lists) or "none"
            raise UnknownName(
                f"{self.path}: experiment {name!r} was never run on this store; there: {known}. "
                f"Run it with `gaitlab run {name}`."
            )
        return lists[name]

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


_REDO = (
    "`gaitlab verify --repair` sets it aside, then `gaitlab run` of its experiment does this "
    "trial again."
)
