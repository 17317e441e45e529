"""The store as tables: the `trials` view as a DataFrame, both views in DuckDB."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import chain, repeat
from pathlib import Path
from sys import intern

import duckdb
import pandas as pd
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
from pyarrow.fs import LocalFileSystem

from gaitlab.errors import StoreError, UsageError
from gaitlab.store.durable import write_durably
from gaitlab.store.entry import Entry
from gaitlab.store.lists import TrialList
from gaitlab.store.parquet import Unreadable, read_log
from gaitlab.store.record import Scalar
from gaitlab.store.trial_files import redo
from gaitlab.store.units import is_number

_FIRST = ("trial_id", "experiment", "robot", "gait", "surface", "seed", "state", "reason")
_TICKS = re.compile(r"\bticks\b", re.IGNORECASE)
_CHECKED = ds.ParquetFragmentScanOptions(page_checksum_verification=True)
_PARQUET = ds.ParquetFileFormat(default_fragment_scan_options=_CHECKED)


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
    table = trials if isinstance(trials, pd.DataFrame) else ds.dataset(trials, format=_PARQUET)
    with duckdb.connect(":memory:") as connection:
        _close(connection)
        connection.register("trials", table)
        try:
            _require_one_question(sql)
            if _TICKS.search(sql):
                connection.register("ticks", _ticks([_sound(path) for path in logs]))
            connection.execute("BEGIN TRANSACTION READ ONLY")
            answer = connection.sql(sql)
            return _exact(answer) if exact else answer.df()
        except duckdb.Error as error:
            known = table.columns if isinstance(table, pd.DataFrame) else table.schema.names
            raise UsageError(_advice(error, known)) from error


def _close(connection: duckdb.DuckDBPyConnection) -> None:
    """Let a query open no file, not even the store's own, and load and set nothing.

    A SELECT can hold a COPY. The views are therefore read by pyarrow, which only reads.
    """
    connection.execute("SET python_enable_replacements = false")
    connection.execute("SET autoinstall_known_extensions = false")
    connection.execute("SET enable_external_access = false")
    connection.execute("SET lock_configuration = true")


def _require_one_question(sql: str) -> None:
    """A query asks and changes nothing: no second statement, no COPY, ATTACH, DROP or SET."""
    kinds = _kinds(sql)
    if kinds == ["EXPLAIN"]:
        kinds = _explained(sql)
    if kinds != ["SELECT"] and not (kinds == ["MULTI"] and _is_table(sql)):
        found = ", ".join(kinds) or "nothing"
        raise UsageError(f"a query is one SELECT, with EXPLAIN before it or not; this is {found}")


def _kinds(sql: str) -> list[str]:
    return [statement.type.name for statement in duckdb.extract_statements(sql)]


def _explained(sql: str) -> list[str]:
    """What stands behind EXPLAIN: the first rest of the text that is a statement."""
    text = sql.encode()
    for start, _ in duckdb.tokenize(sql)[1:]:
        with suppress(duckdb.ParserException):
            return _kinds(text[start:].decode())
    return ["EXPLAIN"]


def _is_table(sql: str) -> bool:
    """Whether it can stand in place of a table, as a PIVOT can and a COPY of one cannot."""
    with suppress(duckdb.ParserException):
        return len(_kinds(f"SELECT * FROM ({sql.rstrip().rstrip(';')}\n)")) == 1
    return False


def _exact(answer: duckdb.DuckDBPyRelation) -> pd.DataFrame:
    """Values as DuckDB writes them in JSON: pandas has no type for half of its types."""
    texts = ", ".join(f"to_json(#{place})" for place in range(1, len(answer.columns) + 1))
    return pd.DataFrame(answer.project(texts).fetchall(), columns=answer.columns, dtype=object)


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Keep a table as a file that `select` takes; derived, and only worth it when it is long."""
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), sink, compression="zstd")
    write_durably(path, sink.getvalue().to_pybytes(), within=path.parent)


def _sound(path: Path) -> Path:
    """The same path, once the checksum of every column was found right; DuckDB looks at none."""
    try:
        read_log(path)
    except Unreadable as error:
        raise StoreError(f"{error}. {redo(path.parents[2])}") from error
    return path


def _ticks(logs: Sequence[Path]) -> ds.Dataset:
    """The logs one below the other, read as the query goes; a column that one lacks is missing."""
    if not logs:
        raise UsageError("the store holds no log yet, so there are no ticks; run an experiment")
    here, trial_id = LocalFileSystem(), ds.field("trial_id")
    files = [_PARQUET.make_fragment(str(log), here, trial_id == log.stem) for log in logs]
    columns = pa.unify_schemas([pa.schema(map(_bare, file.physical_schema)) for file in files])
    schema = pa.schema([pa.field("trial_id", pa.string()), *columns])
    return ds.FileSystemDataset(files, schema, _PARQUET, here)


def _bare(field: pa.Field) -> pa.Field:
    return pa.field(field.name, field.type)


def _advice(error: duckdb.Error, columns: Iterable[str]) -> str:
    return (
        f"the query failed: {error}\n"
        "Views are `trials` and `ticks`; names with a dot go in double quotes. "
        f"Columns of trials: {', '.join(columns)}"
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
