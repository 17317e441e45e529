"""One question in SQL over the store: the views `trials` and `ticks`, read by DuckDB."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

import duckdb
import pandas as pd
import pyarrow as pa
import pyarrow.dataset as ds
from pyarrow.fs import LocalFileSystem

from gaitlab.errors import StoreError, UsageError
from gaitlab.store.parquet import Unreadable, read_log
from gaitlab.store.trial_files import redo

_TICKS = re.compile(r"\bticks\b", re.IGNORECASE)
_CHECKED = ds.ParquetFragmentScanOptions(page_checksum_verification=True)
_PARQUET = ds.ParquetFileFormat(default_fragment_scan_options=_CHECKED)


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
