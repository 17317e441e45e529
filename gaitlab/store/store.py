"""A folder of trials that loses nothing: commit, look up, tabulate, query."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.errors import UnknownName
from gaitlab.store import parquet
from gaitlab.store.durable import sweep, unwritable
from gaitlab.store.entry import entry
from gaitlab.store.index import (
    Index,
    append_entry,
    read_entries,
    reconcile,
    write_entries,
)
from gaitlab.store.lists import (
    LIST,
    NOTHING,
    Listed,
    Lists,
    TrialList,
    checked_name,
    earlier_lists,
    read_lists,
    require_one_file,
    write_list,
    write_listed,
)
from gaitlab.store.lock import Held, Part, alone, reserved, shards_at_work, writing
from gaitlab.store.parquet import Unreadable
from gaitlab.store.record import State, TrialRecord
from gaitlab.store.shards import Shard, ShardStatus, shard_statuses, write_shares
from gaitlab.store.table_file import TableFile
from gaitlab.store.trial_files import TrialFiles

if TYPE_CHECKING:
    import pandas as pd

    from gaitlab.experiment import Experiment
    from gaitlab.experiment.plan import PlannedTrial


TABLE_FROM = 2000  # trials; fewer are tabulated in a tenth of a second


class Store(TrialFiles):
    """Results in a folder, `data` by default. Opening one touches nothing.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._experiments = path / "experiments"
        self._index_file = path / "index.jsonl"
        self._table_file = TableFile(path)

    @contextmanager
    def writing(
        self, experiment: str, shard: Shard | None = None, *, others: bool = False
    ) -> Iterator[Held]:
        """Keep an experiment, or a shard of it, from other runs; those of others go on beside it.

        What a killed run left half-written is cleared first, if nobody else is at work.

        Args:
            experiment: Its name, as it is listed.
            shard: Which share of it is run; None for all of it.
            others: Whether other runs may do the same, since they share a search.

        Raises:
            StoreError: If another run is at the same, or the store is changed as a whole (names
                host, process and start), or the folder cannot be written.
        """
        part = Part(checked_name(experiment), shard.name if shard else "", others)
        with writing(self.path, self._clear) as held, reserved(self.path, part):
            yield held

    @contextmanager
    def alone(self) -> Iterator[Held]:
        """Hold the store as a whole, for what changes more than adding trials.

        Raises:
            StoreError: If a run is at work (names host, process and start), or the folder cannot
                be written.
        """
        with alone(self.path) as held:
            self._clear()
            yield held

    def _clear(self) -> None:
        """Remove what killed runs left half-written."""
        sweep(self.path)

    def note(self, record: TrialRecord) -> None:
        """Add a committed trial to the index. Only for a run that holds its experiment."""
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
        """Put the index file in order, one line a trial. Only for a run that holds something.

        A line that another run adds meanwhile may be lost; its trial is then read from its file.
        """
        known = read_entries(self._index_file)
        found = reconcile(self._trials, known.entries)
        unchanged = found.entries.keys() == known.entries.keys() and all(
            item is known.entries[key] for key, item in found.entries.items()
        )
        if not (known.tidy and unchanged and self._index_file.exists()):
            write_entries(self._index_file, found.entries.values())
        return found

    def rebuild(self) -> Index:
        """Write the index anew from the trials' files alone. Only for who has the store alone."""
        found = reconcile(self._trials, {})
        write_entries(self._index_file, found.entries.values())
        self._table_file.remove()
        self.tabulate()
        return found

    def tabulate(self) -> None:
        """Keep the table of a large store beside it, for `query`; derived like the index."""
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

    def folder_of(self, experiment: str) -> Path:
        """Folder of what belongs to an experiment; it may not be there yet.

        Raises:
            WrongValue: If the name can be that of no folder.
        """
        return self._experiments / checked_name(experiment)

    def share_out(self, experiment: str, numbers: Mapping[str, int], count: int) -> None:
        """Keep how an experiment is shared out: trial id to the number of its shard."""
        write_shares(self._experiments, experiment, numbers, count)

    def shards(self, listed: TrialList, index: Index) -> list[ShardStatus]:
        """How far the shards of an experiment are; none if it was never shared out as it is now."""
        at_work = shards_at_work(self.path, listed.experiment)
        return shard_statuses(self._experiments, listed, index.entries.keys(), at_work)

    def require_one_file(self, experiment: Experiment) -> None:
        """Refuse an experiment whose name is that of another file's results here.

        Raises:
            UsageError: Names the other file.
        """
        require_one_file(self._experiments, experiment)

    def earlier(self, experiment: str) -> list[TrialList]:
        """What an experiment of this name has asked for so far, the newest list first."""
        return earlier_lists(self._experiments / experiment)

    def experiments(self) -> dict[str, TrialList]:
        """Every experiment that was run on this store, by name, but those whose list is damaged."""
        return self.lists().sound

    def newest(self) -> str | None:
        """The experiment whose list of trials changed last; None if there is none."""

        def changed(name: str) -> float:
            return (self._experiments / name / LIST).stat().st_mtime

        return max(self.experiments(), key=changed, default=None)

    def lists(self) -> Lists:
        """What every experiment that was run on this store asked for, as far as it can be read."""
        return read_lists(self._experiments)

    def table(self, experiment: str | TrialList | None = None) -> pd.DataFrame:
        """One row for each experiment and trial that is committed.

        Args:
            experiment: Name of the one to tabulate as it was last run, or the list of the trials
                that it asks for now. Without it, all experiments, and the trials that none asks
                for any more.

        Columns: trial_id, experiment, robot, gait, surface, seed, state, reason, every metric,
        every varied parameter under its dotted path, provenance. Rows stand in the order of the
        plan.

        Raises:
            UnknownName: If the experiment was never run on this store.
        """
        from gaitlab.store.tables import trials_table  # slow to load, and no worker needs it

        if isinstance(experiment, TrialList):
            return trials_table(self.index().entries, [experiment], unlisted=False)
        lists = self.lists()
        chosen = lists.sound.values() if experiment is None else [self._chosen(experiment, lists)]
        return trials_table(self.index().entries, list(chosen), unlisted=experiment is None)

    def outcomes(self, trial_ids: Iterable[str]) -> pd.DataFrame:
        """One row for each of these trials that is committed, whoever asked for it.

        Columns: trial_id, robot, gait, surface, seed, state, reason, every metric, provenance.
        Rows stand in the order of the ids. What else the store holds changes nothing.
        """
        from gaitlab.store.tables import outcomes_table  # slow to load, and no worker needs it

        return outcomes_table(self.index().entries, trial_ids)

    def query(
        self,
        sql: str,
        left_out: Callable[[Exception], None] = lambda error: None,
        *,
        exact: bool = False,
    ) -> pd.DataFrame:
        """Answer of DuckDB over the views `trials` (see `table`) and `ticks` (trial_id and log).

        Args:
            sql: One SELECT.
            left_out: Is told of every file that does not count, unless the store is large and has
                its table beside it.
            exact: Give every value as JSON text with all its digits; None for NULL.

        Raises:
            UsageError: If the query is wrong; quotes DuckDB and lists the columns.
            StoreError: If it is about `ticks` and a log is damaged.
        """
        from gaitlab.store.query import select  # slow to load
        from gaitlab.store.tables import trials_table

        if self._table_file.fresh:
            return select(sql, self._table_file.path, self._logs(None), exact=exact)
        index, lists = self.index(), self.lists()
        for error in (*index.unreadable, *lists.damaged.values()):
            left_out(error)
        table = trials_table(index.entries, list(lists.sound.values()), unlisted=True)
        return select(sql, table, self._logs(index), exact=exact)

    def _logs(self, index: Index | None) -> Iterator[Path]:
        for key, item in (index or self.index()).entries.items():
            if item.state == "DONE":
                yield self.file(key)

    def _chosen(self, name: str, lists: Lists) -> TrialList:
        if name in lists.damaged:
            raise lists.damaged[name]
        if name not in lists.sound:
            from gaitlab.experiment.shell import store_option

            known = ", ".join(lists.sound) or "none"
            command = shlex.join(["gaitlab", "run", name, *store_option(self.path)])
            raise UnknownName(
                f"{self.path}: experiment {name!r} was never run on this store; there: {known}. "
                f"Run it with `{command}`."
            )
        return lists.sound[name]
