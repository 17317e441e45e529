"""What a trial gave as one digest, to compare two runs of it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from gaitlab.store.parquet import columns_sha256, read_log, read_record
from gaitlab.store.record import canonical


def fingerprint(path: Path) -> str:
    """Digest of state, metrics and log, bit for bit; equal for two equal runs of a trial.

    Raises:
        Unreadable: If the file is torn, foreign or of another version, down to the last column.
    """
    record, log = read_record(path), read_log(path)
    header = repr(log.header) if log is not None else ""
    parts = (record.state, canonical(dict(record.metrics)), header, columns_sha256(log))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()
