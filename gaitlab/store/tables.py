"""The store as tables: the `trials` view as a DataFrame, both views in DuckDB."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, repeat
from pathlib import Path
from sys import intern

import duckdb
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from gaitlab.errors import StoreError, UsageError
from gaitlab.store.durable import write_durably
from gaitlab.store.entry import Entry
from gaitlab.store.lists import TrialList
from gaitlab.store.parquet import Unreadable, read_log
from gaitlab.store.record import Scalar

_FIRST = ("trial_id", "experiment", "robot", "gait", "surface", "seed", "state", "reason")
_TICKS = re.compile(r"\bticks\b", re.IGNORECASE)
_QUESTIONS = (duckdb.StatementType.SELECT, duckdb.StatementType.EXPLAIN)


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


def select(
    sql: str, trials: pd.DataFrame | Path, logs: Iterable[Path], *, exact: bool = False
) -> pd.DataFrame:
    """Answer of DuckDB to one query over the views `trials` and `ticks`.

    Args:
        sql: The query.
        trials: The table, or the file that `write_table` made of it.
        logs: Files with a log; only a query of `ticks` asks for them.
        exact: Give every value as JSON text with all its digits, whatever its type; None for NULL.

    Raises:
        UsageError: If DuckDB does not understand the query, or it is not one SELECT.
        StoreError: If a log is damaged.
    """
    with duckdb.connect(":memory:") as connection:
        connection.execute("SET autoinstall_known_extensions = false")
        _create_trials(connection, trials)
        try:
            _require_one_question(sql)
            files = [_sound(path) for path in logs] if _TICKS.search(sql) else []
            if _TICKS.search(sql):
                _create_ticks(connection, files)
            _close_in(connection, [*files, *([trials] if isinstance(trials, Path) else [])])
            answer = connection.sql(sql)
            return _exact(answer) if exact else answer.df()
        except duckdb.Error as error:
            raise UsageError(_advice(error, connection)) from error


def _require_one_question(sql: str) -> None:
    """A query asks and changes nothing: no second statement, no COPY, ATTACH, DROP or SET."""
    statements = duckdb.extract_statements(sql)
    if len(statements) != 1 or statements[0].type not in _QUESTIONS:
        found = ", ".join(statement.type.name for statement in statements) or "nothing"
        raise UsageError(f"a query is one SELECT (or EXPLAIN); this is {found}")


def _exact(answer: duckdb.DuckDBPyRelation) -> pd.DataFrame:
    """Values as DuckDB writes them in JSON: pandas has no type for half of its types."""
    texts = ", ".join(f"to_json(#{place})" for place in range(1, len(answer.columns) + 1))
    return pd.DataFrame(answer.project(texts).fetchall(), columns=answer.columns, dtype=object)


def _close_in(connection: duckdb.DuckDBPyConnection, files: Iterable[Path]) -> None:
    """Let the query read the store's own files and no others, and load nothing."""
    folders = ", ".join(_quoted(folder) for folder in sorted({file.parent for file in files}))
    connection.execute("SET python_enable_replacements = false")
    connection.execute(f"SET allowed_directories = [{folders}]")
    connection.execute("SET enable_external_access = false")


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Keep a table as a file that `select` takes; derived, and only worth it when it is long."""
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), sink, compression="zstd")
    write_durably(path, sink.getvalue().to_pybytes())


def _create_trials(connection: duckdb.DuckDBPyConnection, trials: pd.DataFrame | Path) -> None:
    if isinstance(trials, Path):
        connection.execute(f"CREATE VIEW trials AS SELECT * FROM read_parquet({_quoted(trials)})")
    else:
        connection.register("trials", trials)


def _sound(path: Path) -> Path:
    """The same path, once the checksum of every column was found right; DuckDB looks at none."""
    try:
        read_log(path)
    except Unreadable as error:
        raise StoreError(
            f"{error}. `gaitlab verify --repair` sets it aside, then `gaitlab run` does the trial "
            "again."
        ) from error
    return path


def _quoted(path: Path) -> str:
    return "'" + str(path).replace("'", "''") + "'"


def _create_ticks(connection: duckdb.DuckDBPyConnection, logs: Sequence[Path]) -> None:
    if not logs:
        raise UsageError("the store holds no log yet, so there are no ticks; run an experiment")
    files = ", ".join(_quoted(path) for path in logs)
    connection.execute(
        "CREATE VIEW ticks AS SELECT regexp_extract(filename, '([0-9a-f]{32})[.]parquet$', 1) "
        "AS trial_id, * EXCLUDE (filename) "
        f"FROM read_parquet([{files}], union_by_name = true, filename = true)"
    )


def _advice(error: duckdb.Error, connection: duckdb.DuckDBPyConnection) -> str:
    known = ", ".join(connection.sql("SELECT * FROM trials LIMIT 0").columns)
    return (
        f"the query failed: {error}\n"
        "Views are `trials` and `ticks`; names with a dot go in double quotes. "
        f"Columns of trials: {known}"
    )


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
    return pd.DataFrame({name: _column(columns.pop(name)) for name in list(columns)})


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
