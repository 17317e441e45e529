"""The table of a large store as a file beside it, so that a query need not gather it again.

It is derived and counts only while the trials' files have the names and sizes, and the lists the
content, that it was made from. While no folder of trials has been written to since, one look at
the folders shows that; in a copy of the store, where times differ, a look at every file does.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.errors import StoreError
from gaitlab.store.durable import read_whole, write_durably
from gaitlab.store.index import signature
from gaitlab.store.lists import LIST

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
        """Keep the table of the store as it is now; a stamp of another table counts for nothing."""
        from gaitlab.store.tables import write_table  # slow to load, and no worker needs it

        stamps = f"{self._times()} {self._contents()}"
        write_table(table, self.path)
        stamp = f"{stamps} {_digest(self.path)}\n".encode()
        write_durably(self._stamp_file, stamp, within=self.path.parent)

    def remove(self) -> None:
        """Keep none."""
        self._stamp_file.unlink(missing_ok=True)
        self.path.unlink(missing_ok=True)

    @property
    def fresh(self) -> bool:
        """Whether it is there, whole, and the table of the store as it is now."""
        try:
            times, contents, digest = read_whole(self._stamp_file).decode().split()
            whole = digest == _digest(self.path)
            return whole and (times == self._times() or contents == self._contents())
        except (OSError, ValueError, StoreError):
            return False

    def _times(self) -> str:
        """When a trial or a list was last added, replaced or removed."""
        folders = (
            folder for folder in os.scandir(self._trials) if folder.is_dir(follow_symlinks=False)
        )
        times = sorted(f"{folder.name} {folder.stat().st_mtime_ns}" for folder in folders)
        times += [f"{path.parent.name} {path.stat().st_mtime_ns}" for path in self._lists()]
        return hashlib.sha256("\n".join(times).encode()).hexdigest()

    def _contents(self) -> str:
        digest = hashlib.sha256(signature(self._trials).encode())
        for path in self._lists():
            digest.update(f"{path.parent.name}\0".encode())
            digest.update(read_whole(path))
        return digest.hexdigest()

    def _lists(self) -> list[Path]:
        return sorted(self._experiments.glob(f"*/{LIST}"))


def _digest(path: Path) -> str:
    return hashlib.sha256(read_whole(path)).hexdigest()
