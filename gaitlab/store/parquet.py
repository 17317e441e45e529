"""One trial as one Parquet file that explains itself.

One row group, one row a tick. Floats are split into byte streams before zstd, which halves what
dictionary encoding leaves of joint angles; dictionaries are off. Beside the columns the file
carries the header of the log, the whole record and a seal: the SHA-256 of both and of every
column's bytes, so that no damaged number is ever read.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import columns
from gaitlab.store.durable import hindrance, open_to_read, starved, unreachable
from gaitlab.store.record import TrialRecord, canonical, from_json, to_json

OLDEST_VERSION = 1  # of the file that can still be read
FASTER = -1  # level of zstd: a quarter less time than its usual one for files 2 % longer
FORMAT_VERSION = 1  # of the file; raise it when an older gaitlab could misread a newer file
LONGEST_FOOTER = 1 << 26  # byte
MOST_UNPACKED, FREE_UNPACKED = 200, 1 << 26  # byte a byte of the file, some 4 in fact; byte besides
_VERSION, _RECORD, _HEADER = b"gaitlab.format", b"gaitlab.record", b"gaitlab.header"
_VOLATILE = b"gaitlab.volatile"
_COLUMNS_SHA256, _SEAL = b"gaitlab.columns_sha256", b"gaitlab.seal"


UnreadableKind: TypeAlias = Literal["damaged", "foreign", "older", "newer", "unreachable"]


class Unreadable(Exception):
    """A file that is no whole trial of this version.

    Attributes:
        kind: `damaged`, `foreign` (not written by gaitlab), `older` or `newer` (written by
            another version), or `unreachable` (it may be whole, but something keeps it from being
            read, a missing permission or a failing disk for instance).
    """

    def __init__(self, path: Path, kind: UnreadableKind, why: str) -> None:
        super().__init__(f"{path}: {kind}: {why}")
        self.path, self.kind, self.why = path, kind, why

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.path, self.kind, self.why)


class LogPart(NamedTuple):
    """Some columns of a log, by name, and its header."""

    header: LogHeader
    arrays: dict[str, np.ndarray]


def encode(record: TrialRecord, log: TrialLog | None) -> bytes:
    """The file of a trial. Without a log it has the column `time` and no rows."""
    table = _table(log)
    sha256 = columns_sha256(log)
    header = canonical(log.header.to_dict()) if log is not None else ""
    text, volatile = to_json(record)
    metadata = {
        _VERSION: str(FORMAT_VERSION).encode(),
        _HEADER: header.encode(),
        _RECORD: text.encode(),
        _VOLATILE: volatile.encode(),
        _COLUMNS_SHA256: sha256.encode(),
        _SEAL: _seal(text, volatile, header, sha256).encode(),
    }
    return _parquet(table.replace_schema_metadata(metadata))


def read_record(path: Path) -> TrialRecord:
    """The record in a file, without reading its columns.

    Raises:
        Unreadable: If the file is torn, foreign or of a newer version.
        StoreError: If this process has no memory or may open no file.
    """
    with _opened(path) as file:
        return _record(path, _metadata(file))


def read_log(path: Path) -> TrialLog | None:
    """The log in a file, bit for bit as it was written; None if its trial ended without one.

    Raises:
        Unreadable: If the file is torn, foreign or of a newer version.
        StoreError: If this process has no memory or may open no file.
    """
    with _opened(path) as file:
        metadata = _metadata_of_log(file, path)
        if metadata is None:
            return None
        log = _log(file, metadata)
        if columns_sha256(log).encode() != metadata[_COLUMNS_SHA256]:
            raise ValueError("the columns are not those that were written")
        return log


def read_columns(path: Path, names: Sequence[str]) -> LogPart | None:
    """Some columns of a log by name; the others are not read. None if the trial ended without one.

    Pages that are damaged are found, a column that was exchanged as a whole is not.

    Raises:
        Unreadable: If the file is torn, foreign or of a newer version.
        StoreError: If this process has no memory or may open no file.
    """
    with _opened(path) as file:
        metadata = _metadata_of_log(file, path)
        if metadata is None:
            return None
        header = _header(json.loads(metadata[_HEADER]))
        table = file.read(columns=list(names), use_threads=False)
        return LogPart(header, {name: _plain(table, name) for name in names})


def written_sha256(path: Path) -> str:
    """SHA-256 of the columns as the file states it, without reading them.

    Raises:
        Unreadable: If the file is torn, foreign or of a newer version.
        StoreError: If this process has no memory or may open no file.
    """
    with _opened(path) as file:
        metadata = _metadata(file)
        _record(path, metadata)
        return metadata[_COLUMNS_SHA256].decode()


def columns_sha256(log: TrialLog | None) -> str:
    """SHA-256 of the bytes of all columns, in file order, but for one that an older log lacks."""
    digest = hashlib.sha256()
    for column in columns(log.header.joints) if log is not None else ():
        if column.late and np.isnan(log.arrays[column.name]).all():  # type: ignore[union-attr]
            continue
        digest.update(column.name.encode())
        digest.update(log.arrays[column.name].data)  # type: ignore[union-attr]
    return digest.hexdigest()


def _table(log: TrialLog | None) -> pa.Table:
    if log is None:
        return pa.schema(_fields(())[:1]).empty_table()
    fields = _fields(log.header.joints)
    arrays = [pa.array(log.arrays[field.name]) for field in fields]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


@lru_cache(maxsize=16)
def _fields(joints: tuple[str, ...]) -> list[pa.Field]:
    """Fields of the columns of a log of a robot with these joints."""
    return [
        pa.field(c.name, _TYPES[c.dtype], nullable=False, metadata={"unit": c.unit, "doc": c.doc})
        for c in columns(joints)
    ]


_TYPES = {
    "float32": pa.float32(),
    "int8": pa.int8(),
    "int16": pa.int16(),
    "bool": pa.bool_(),
}


def _parquet(table: pa.Table) -> bytes:
    floats = [field.name for field in table.schema if pa.types.is_floating(field.type)]
    sink = pa.BufferOutputStream()
    pq.write_table(
        table,
        sink,
        row_group_size=max(1, table.num_rows),
        compression="zstd",
        compression_level=FASTER,
        use_dictionary=False,
        use_byte_stream_split=floats,
        write_statistics=False,
        write_page_checksum=True,
    )
    return sink.getvalue().to_pybytes()


@contextmanager
def _opened(path: Path) -> Iterator[pq.ParquetFile]:
    """The file, open. What it makes the reader raise is damage; what keeps it from being read, not.

    The operating system's errors have a number, and those that pyarrow makes of a damaged file
    have none. Python reads the file, so that the number is never lost on the way.
    """
    try:
        with open_to_read(path) as file:
            _require_short_footer(file)
            yield pq.ParquetFile(file, page_checksum_verification=True)
    except (Unreadable, FileNotFoundError):
        raise
    except Exception as error:  # pyarrow has no end of kinds for a flipped bit
        if starved(error):
            raise unreachable(path, error) from error
        if isinstance(error, OSError) and error.errno is not None:
            raise Unreadable(path, "unreachable", hindrance(error)) from error
        _read_something_whole(path)
        raise Unreadable(path, "damaged", _short(error)) from error


def _require_short_footer(file: io.FileIO) -> None:
    """The last bytes but four say how long a footer is read; a trial's has some ten thousand."""
    file.seek(max(0, file.seek(0, os.SEEK_END) - 8))
    length = int.from_bytes(file.read(4), "little")
    if length > LONGEST_FOOTER:
        raise ValueError(f"not a whole Parquet file (a footer of {length} bytes)")


def _require_plausible(file: pq.ParquetFile, path: Path) -> None:
    """A few bytes can claim, or hold, more rows than there is memory for."""
    described = file.metadata
    most = MOST_UNPACKED * os.stat(path).st_size + FREE_UNPACKED
    if described.num_row_groups > 1 or described.num_rows * described.num_columns * 4 > most:
        raise ValueError(f"{described.num_rows} rows, more than such a file can hold")
    for group in range(described.num_row_groups):
        for number in range(described.num_columns):
            chunk = described.row_group(group).column(number)
            if chunk.num_values != described.num_rows or chunk.total_uncompressed_size > most:
                raise ValueError(
                    f"column {chunk.path_in_schema} does not have the rows of the file"
                )


def _read_something_whole(path: Path) -> None:
    """Make sure that the reader works: without a thread or memory it calls every file damaged."""
    try:
        whole = io.BytesIO(_parquet(pa.table({"time": pa.array([0.0], pa.float32())})))
        pq.ParquetFile(whole).read(use_threads=False)
    except Exception as error:
        raise unreachable(path, MemoryError()) from error


def _metadata_of_log(file: pq.ParquetFile, path: Path) -> dict[bytes, bytes] | None:
    """What the file says of its log, whose columns may then be read; None if it has none."""
    metadata = _metadata(file)
    _record(path, metadata)
    if not metadata[_HEADER]:
        return None
    _require_plausible(file, path)
    return metadata


def _metadata(file: pq.ParquetFile) -> dict[bytes, bytes]:
    metadata: dict[bytes, bytes] | None = file.schema_arrow.metadata
    return metadata or {}


def _record(path: Path, metadata: dict[bytes, bytes]) -> TrialRecord:
    if _VERSION not in metadata:
        raise Unreadable(path, "foreign", "not written by gaitlab")
    _check_version(path, metadata[_VERSION])
    sealed = [metadata[key].decode() for key in (_RECORD, _VOLATILE, _HEADER, _COLUMNS_SHA256)]
    if metadata[_SEAL].decode() != _seal(*sealed):
        raise ValueError("the record is not the one that was written")
    record = from_json(*sealed[:2])
    if record.trial_id != path.stem:
        raise Unreadable(path, "foreign", f"holds trial {record.trial_id}; rename it back")
    return record


def _check_version(path: Path, written: bytes) -> None:
    version = int(written)
    if version < OLDEST_VERSION:
        why = f"format {version}, this gaitlab reads from {OLDEST_VERSION} on"
        raise Unreadable(path, "older", why)
    if version > FORMAT_VERSION:
        why = f"format {version}, this gaitlab reads up to {FORMAT_VERSION}; update gaitlab"
        raise Unreadable(path, "newer", why)


def _log(file: pq.ParquetFile, metadata: dict[bytes, bytes]) -> TrialLog:
    header = _header(json.loads(metadata[_HEADER]))
    table = file.read(use_threads=False)
    there = set(table.schema.names)
    if foreign := there - {column.name for column in columns(header.joints)}:
        raise ValueError(f"column {min(foreign)!r} is none of a log")
    present = [c for c in columns(header.joints) if c.name in there or not c.late]
    arrays = {c.name: _array(table, c.name, c.dtype) for c in present}
    return TrialLog(header=header, arrays=arrays)


def _header(content: dict[str, Any]) -> LogHeader:
    """The header from JSON, which a seal alone does not make gaitlab's."""
    lists = {name: tuple(value) for name, value in content.items() if isinstance(value, list)}
    header = LogHeader(**{**content, **lists})
    for name, hint in LogHeader.__annotations__.items():
        given = getattr(header, name)
        values = given if "tuple" in hint else (given,)
        kinds = str if "str" in hint else (int, float)
        if not isinstance(values, tuple) or not all(isinstance(one, kinds) for one in values):
            raise ValueError(f"{name} of the header is {given!r}"[:200])
    return header


def _plain(table: pa.Table, name: str) -> np.ndarray:
    array: np.ndarray = table.column(name).combine_chunks().to_numpy(zero_copy_only=False)
    return array


def _array(table: pa.Table, name: str, dtype: str) -> np.ndarray:
    array = _plain(table, name)
    if array.dtype != dtype:
        raise ValueError(f"column {name} is {array.dtype}, not {dtype}")
    return array


def _seal(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _short(error: Exception) -> str:
    return str(error).splitlines()[0][:200] if str(error) else type(error).__name__
