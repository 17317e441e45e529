"""The table of a large store as a file beside it, so that a query need not gather it again.

It is derived and counts only while every trial's file has the name and size, and every list the
content, that it was made from; a copy of the store takes it along.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.store.durable import write_durably
from gaitlab.store.index import signature

if TYPE_CHECKING:
    import pandas as pd


class TableFile:
    """The file of the table and its stamp.

    Args:
        store: Folder of the store.
    """

    def __init__(self, store: Path) -> None:
        self.path = store / "table.parquet"
        self._stamp_file = store / "table.stamp"
        self._trials, self._experiments = store / "trials", store / "experiments"

    def write(self, table: pd.DataFrame) -> None:
        """Keep the table of the store as it is now. Only under the lock."""
        from gaitlab.store.tables import write_table  # slow to load, and no worker needs it

        stamp = self._stamp()
        write_table(table, self.path)
        write_durably(self._stamp_file, f"{stamp} {_digest(self.path)}\n".encode())

    def remove(self) -> None:
        """Keep none."""
        self._stamp_file.unlink(missing_ok=True)
        self.path.unlink(missing_ok=True)

    @property
    def fresh(self) -> bool:
        """Whether it is there, whole, and the table of the store as it is now."""
        try:
            stamp, digest = self._stamp_file.read_text().split()
            return digest == _digest(self.path) and stamp == self._stamp()
        except (OSError, ValueError):
            return False

    def _stamp(self) -> str:
        digest = hashlib.sha256(signature(self._trials).encode())
        for path in sorted(self._experiments.glob("*/trials.jsonl")):
            digest.update(f"{path.parent.name}\0".encode())
            digest.update(path.read_bytes())
        return digest.hexdigest()


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
