"""The store as a table: the `trials` view as a DataFrame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, repeat
from pathlib import Path
from sys import intern

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from gaitlab.store.durable import write_durably
from gaitlab.store.entry import Entry
from gaitlab.store.lists import TrialList
from gaitlab.store.record import Scalar
from gaitlab.store.units import is_number

_FIRST = ("trial_id", "experiment", "robot", "gait", "surface", "seed", "state", "reason")


def trials_table(
    entries: Mapping[str, Entry], lists: Sequence[TrialList], *, unlisted: bool
) -> pd.DataFrame:
    """One row for each experiment and committed trial, in the order of the plans.

    Args:
        entries: All trials of the store.
        lists: What the experiments ask for.
        unlisted: Add the trials that none of them asks for; their experiment is missing.
    """
    rows = (
        _row(entries[listed.trial_id], found.experiment, listed.values)
        for found in lists
        for listed in found.trials
        if listed.trial_id in entries
    )
    wanted = {listed.trial_id for found in lists for listed in found.trials} if unlisted else set()
    rest = (item for key, item in entries.items() if unlisted and key not in wanted)
    return _frame(chain(rows, (_row(item, None, {}) for item in rest)))


def outcomes_table(entries: Mapping[str, Entry], trial_ids: Iterable[str]) -> pd.DataFrame:
    """One row for each of the trials that is committed, each once, in the order of the ids."""
    wanted = (entries[key] for key in dict.fromkeys(trial_ids) if key in entries)
    return _frame(_row(item, None, {}) for item in wanted).drop(columns="experiment")


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Keep a table as a file that `select` takes; derived, and only worth it when it is long."""
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), sink, compression="zstd")
    write_durably(path, sink.getvalue().to_pybytes(), within=path.parent)


def _row(item: Entry, experiment: str | None, values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The surface is named as this experiment names it, whoever ran the trial first."""
    details = item.details
    return {
        "trial_id": item.trial_id,
        "experiment": experiment,
        **details.labels,
        "state": item.state,
        "reason": details.reason,
        **details.metrics,
        **values,
        **details.provenance,
    }


def _frame(rows: Iterable[Mapping[str, Scalar]]) -> pd.DataFrame:
    """Rows gathered column by column: as dictionaries they would take ten times the memory."""
    columns: dict[str, list[Scalar]] = {name: [] for name in _FIRST}
    count = 0
    for row in rows:
        for name, value in row.items():
            column = columns.setdefault(name, [])
            column.extend(repeat(None, count - len(column)))
            column.append(intern(value) if isinstance(value, str) else value)
        count += 1
    for column in columns.values():
        column.extend(repeat(None, count - len(column)))
    return pd.DataFrame({name: _column(name, columns.pop(name)) for name in list(columns)})


def _column(name: str, values: Sequence[Scalar]) -> pd.Series:
    """A column of the narrowest type that holds all values and a gap."""
    kinds = {type(value) for value in values if value is not None}
    gap = any(value is None for value in values)
    if kinds == {bool}:
        return pd.Series(values, dtype="boolean" if gap else "bool")
    if kinds == {int}:
        return pd.Series(values, dtype="Int64" if gap else "int64")
    if kinds <= {int, float} and (kinds or is_number(name)):
        return pd.Series(_as_floats(values), dtype="float64")
    if kinds <= {str}:
        return pd.Series(values, dtype="str")
    return pd.Series([None if value is None else str(value) for value in values], dtype="str")


def _as_floats(values: Iterable[Scalar]) -> list[float]:
    return [float("nan") if value is None else float(value) for value in values]
