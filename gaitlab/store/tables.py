"""The store as tables: the `trials` view as a DataFrame, both views in DuckDB."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import duckdb
import pandas as pd

from gaitlab.errors import UsageError
from gaitlab.store.index import Entry
from gaitlab.store.lists import TrialList
from gaitlab.store.record import Scalar

_FIRST = ("trial_id", "experiment", "robot", "gait", "surface", "seed", "state", "reason")
_TICKS = re.compile(r"\bticks\b", re.IGNORECASE)


def trials_table(
    entries: Mapping[str, Entry], lists: Sequence[TrialList], *, unlisted: bool
) -> pd.DataFrame:
    """One row for each experiment and committed trial, in the order of the plans.

    Args:
        entries: All trials of the store.
        lists: What the experiments ask for.
        unlisted: Add the trials that none of them asks for; their experiment is missing.
    """
    rows = [
        _row(entries[listed.trial_id], found.experiment, listed.values)
        for found in lists
        for listed in found.trials
        if listed.trial_id in entries
    ]
    wanted = {listed.trial_id for found in lists for listed in found.trials} if unlisted else set()
    rest = (item for key, item in entries.items() if unlisted and key not in wanted)
    return _frame([*rows, *(_row(item, None, {}) for item in rest)])


def select(sql: str, trials: pd.DataFrame, logs: Sequence[Path]) -> pd.DataFrame:
    """Answer of DuckDB to one query over the views `trials` and `ticks`.

    Raises:
        UsageError: If DuckDB does not understand the query, or a log cannot be read.
    """
    with duckdb.connect(":memory:") as connection:
        connection.execute("SET autoinstall_known_extensions = false")
        connection.register("trials", trials)
        try:
            if _TICKS.search(sql):
                _create_ticks(connection, logs)
            return connection.sql(sql).df()
        except AttributeError as error:  # a statement without a result
            raise UsageError("the query has no result; a query starts with SELECT") from error
        except duckdb.Error as error:
            raise UsageError(_advice(error, trials)) from error


def _create_ticks(connection: duckdb.DuckDBPyConnection, logs: Sequence[Path]) -> None:
    if not logs:
        raise UsageError("the store holds no log yet, so there are no ticks; run an experiment")
    files = ", ".join("'" + str(path).replace("'", "''") + "'" for path in logs)
    connection.execute(
        "CREATE VIEW ticks AS SELECT regexp_extract(filename, '([0-9a-f]{32})[.]parquet$', 1) "
        "AS trial_id, * EXCLUDE (filename) "
        f"FROM read_parquet([{files}], union_by_name = true, filename = true)"
    )


def _advice(error: duckdb.Error, trials: pd.DataFrame) -> str:
    known = ", ".join(str(name) for name in trials.columns)
    return (
        f"the query failed: {error}\n"
        "Views are `trials` and `ticks`; names with a dot go in double quotes. "
        f"Columns of trials: {known}"
    )


def _row(item: Entry, experiment: str | None, values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The surface is named as this experiment names it, whoever ran the trial first."""
    return {
        "trial_id": item.trial_id,
        "experiment": experiment,
        **item.labels,
        "state": item.state,
        "reason": item.reason,
        **item.metrics,
        **values,
        **item.provenance,
    }


def _frame(rows: Sequence[Mapping[str, Scalar]]) -> pd.DataFrame:
    names = dict.fromkeys((*_FIRST, *(name for row in rows for name in row)))
    return pd.DataFrame({name: _column([row.get(name) for row in rows]) for name in names})


def _column(values: Sequence[Scalar]) -> pd.Series:
    """A column of the narrowest type that holds all values and a gap."""
    kinds = {type(value) for value in values if value is not None}
    gap = any(value is None for value in values)
    if kinds == {bool}:
        return pd.Series(values, dtype="boolean" if gap else "bool")
    if kinds == {int}:
        return pd.Series(values, dtype="Int64" if gap else "int64")
    if kinds and kinds <= {int, float}:
        return pd.Series(_as_floats(values), dtype="float64")
    if kinds <= {str}:
        return pd.Series(values, dtype="str")
    return pd.Series([None if value is None else str(value) for value in values], dtype="str")


def _as_floats(values: Iterable[Scalar]) -> list[float]:
    return [float("nan") if value is None else float(value) for value in values]
