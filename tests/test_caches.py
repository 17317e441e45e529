"""Folders for what can be made again: the first that can be used, and nobody else's code."""

from __future__ import annotations

import logging
import os
import stat
import subprocess
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest

from gaitlab.kinematics import caches
from gaitlab.kinematics.caches import cache_folder, code_folder, lend_caches

VARIABLES = (
    "HOME",
    "XDG_CACHE_HOME",
    "XDG_CONFIG_HOME",
    "TMPDIR",
    "NUMBA_CACHE_DIR",
    "MPLCONFIGDIR",
)


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No folder of whoever runs the tests is looked at, and nothing is remembered."""
    for name in VARIABLES:
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", "/proc/nohome")
    monkeypatch.setattr(caches, "TEMPORARY", ())
    cache_folder.cache_clear()
    code_folder.cache_clear()
    yield
    cache_folder.cache_clear()
    code_folder.cache_clear()


def temporary(folder: Path) -> Path:
    folder.mkdir()
    folder.chmod(0o1777)
    return folder


@pytest.mark.parametrize("usable", list(product([True, False], repeat=3)))
def test_the_first_that_can_be_written_is_taken_and_the_others_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, usable: tuple[bool, bool, bool]
) -> None:
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "TMPDIR")
    where = [tmp_path / name for name in names]
    for name, folder, good in zip(names, where, usable, strict=True):
        monkeypatch.setenv(name, str(folder))
        if good:
            temporary(folder)
        else:
            folder.write_text("a file where the folder should be")
    found = code_folder()
    first = usable.index(True) if any(usable) else None
    if first is None:
        assert found.path is None
    else:
        assert found.path is not None
        assert found.path.is_dir()
        assert found.path.is_relative_to(where[first])
    before = where if first is None else where[:first]
    assert len(found.refused) == len(before)
    assert all(str(place) in why for place, why in zip(before, found.refused, strict=True))


@pytest.mark.parametrize("named", ["", "nobody"])
def test_without_a_home_or_a_name_there_is_still_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    place = temporary(tmp_path / "temporary")
    monkeypatch.setenv("TMPDIR", str(place))
    monkeypatch.delenv("HOME")

    def homeless() -> Path:
        raise RuntimeError("no home")

    monkeypatch.setattr(Path, "home", homeless)
    found = cache_folder()
    private = place / f"gaitlab-{os.geteuid()}"
    assert found.path is not None
    assert found.path.parent == private
    assert stat.S_IMODE(private.stat().st_mode) == 0o700
    cache_folder.cache_clear()
    assert cache_folder().path == found.path, "found again"


def linked(private: Path) -> None:
    other = private.parent.parent / "other"
    other.mkdir(mode=0o700)
    private.symlink_to(other)


def opened(private: Path) -> None:
    private.mkdir()
    private.chmod(0o770)


def given_away(private: Path) -> None:
    private.mkdir(mode=0o700, exist_ok=True)
    try:
        os.chown(private, 4321, -1)
    except OSError:
        pytest.skip("giving a folder to somebody else is not permitted here")


def replaceable(private: Path) -> None:
    private.mkdir(mode=0o700)
    private.parent.chmod(0o777)


@pytest.mark.parametrize("wrong", [linked, opened, given_away, replaceable])
def test_what_others_may_have_put_there_is_never_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: object
) -> None:
    place = temporary(tmp_path / "temporary")
    wrong(place / f"gaitlab-{os.geteuid()}")  # type: ignore[operator]
    monkeypatch.setenv("TMPDIR", str(place))
    assert cache_folder().path is None
    assert len(cache_folder().refused) == 2


def test_a_home_of_somebody_else_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """HOME=/tmp for instance, in which anybody may have made the folder before."""
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = tmp_path / ".cache" / "gaitlab"
    folder.mkdir(parents=True)
    assert cache_folder().path == folder
    cache_folder.cache_clear()
    given_away(folder)
    assert cache_folder().path is None


def test_libraries_are_lent_a_folder_only_where_theirs_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    before = dict(os.environ)
    lend_caches()
    assert dict(os.environ) == before
    cache_folder.cache_clear()
    place = temporary(tmp_path / "temporary")
    monkeypatch.setenv("TMPDIR", str(place))
    monkeypatch.setenv("HOME", "/proc/nohome")
    lend_caches()
    folder = cache_folder().path
    assert folder is not None
    assert os.environ["MPLCONFIGDIR"] == str(folder / "matplotlib")
    cache_folder.cache_clear()
    assert cache_folder().path == folder, "a process that inherits the variables has the same"


def test_libraries_are_quiet_where_there_is_nothing_to_lend() -> None:
    logger = logging.getLogger("matplotlib")
    level = logger.level
    try:
        lend_caches()
        assert not logger.isEnabledFor(logging.WARNING)
    finally:
        logger.setLevel(level)
    assert "MPLCONFIGDIR" not in os.environ


def test_looking_for_a_folder_loads_nothing_heavy() -> None:
    code = "import sys, gaitlab.kinematics.caches; sys.exit('numba' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
