"""What is said to be on the disk is there: written, synced, renamed, and its folder synced."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gaitlab.store.durable import write_durably

Calls = list[tuple[str, int, int]]  # what was done, to which inode, how long the file was


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Calls:
    """Every sync and rename in order; all of them are really done."""
    done: Calls = []
    sync, rename = os.fsync, os.replace

    def synced(descriptor: int) -> None:
        status = os.fstat(descriptor)
        done.append(("sync", status.st_ino, status.st_size))
        sync(descriptor)

    def renamed(source: Path, target: Path) -> None:
        done.append(("rename", os.stat(source).st_ino, os.stat(source).st_size))
        rename(source, target)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", renamed)
    return done


def test_a_file_is_synced_whole_before_it_is_renamed_and_its_folder_after(
    tmp_path: Path, calls: Calls
) -> None:
    content = b"x" * 100  # short enough to stay in Python until it is flushed
    write_durably(tmp_path / "a", content, within=tmp_path)
    file, folder = (tmp_path / "a").stat().st_ino, tmp_path.stat().st_ino
    assert [(what, inode) for what, inode, _ in calls] == [
        ("sync", file), ("rename", file), ("sync", folder)
    ]  # fmt: skip
    assert calls[0][2] == len(content), "all of it had left Python before the sync"


def test_every_folder_that_had_to_be_made_is_synced_in_its_parent(
    tmp_path: Path, calls: Calls
) -> None:
    write_durably(tmp_path / "one" / "two" / "three" / "a", b"x", within=tmp_path)
    synced = {inode for what, inode, _ in calls if what == "sync"}
    for folder in (tmp_path, tmp_path / "one", tmp_path / "one" / "two"):
        assert folder.stat().st_ino in synced, folder
