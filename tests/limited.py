"""A control group with little processor time, where this machine lets tests make one."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

PERIOD = 100_000  # us
PLACES = (  # where a group is made, and the files that limit it
    (Path("/sys/fs/cgroup/cpu"), {"cpu.cfs_period_us": "{period}", "cpu.cfs_quota_us": "{quota}"}),
    (Path("/sys/fs/cgroup"), {"cpu.max": "{quota} {period}"}),
)


@contextmanager
def group(share: float | None, within: Path | None = None) -> Iterator[Path]:
    """A group that may use this share of a processor; gone afterwards, as its processes have to be.

    Args:
        share: How much; None for as much as there is.
        within: Another such group.
    """
    for version, (place, files) in enumerate(PLACES, start=1):
        unlimited = "-1" if version == 1 else "max"
        values = {"period": PERIOD, "quota": round(share * PERIOD) if share else unlimited}
        folder = (within or place) / f"test-{uuid.uuid4().hex[:8]}"
        with suppress(OSError):
            folder.mkdir()
            try:
                for name, text in files.items():
                    if not (folder / name).is_file():
                        raise FileNotFoundError
                    (folder / name).write_text(text.format(**values))
            except OSError:
                folder.rmdir()
                raise
            break
    else:
        pytest.skip("no control group with processor time can be made here")
    try:
        yield folder
    finally:
        _removed(folder)


def _removed(folder: Path) -> None:
    """Remove a group, which is busy for a moment after its last process has ended."""
    for _ in range(100):
        try:
            folder.rmdir()
        except OSError:
            time.sleep(0.1)
        else:
            return
    folder.rmdir()


def put(folder: Path, pid: int) -> None:
    """Put a process into a group."""
    (folder / "cgroup.procs").write_text(str(pid))


def entering(folder: Path) -> Callable[[], None]:
    """What a child process calls to be in a group before it runs anything."""
    return lambda: put(folder, os.getpid())
