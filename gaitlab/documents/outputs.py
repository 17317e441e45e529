"""Files that a user asked for: whole or as they were before, and nobody else's overwritten."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gaitlab.errors import StoreError, UsageError

MARK = "gaitlab"  # stands in every file that gaitlab writes, so that it knows its own
PAGE = "README.md"  # of a report's folder
PAGE_MARK = "This page again:"  # stands on the page of every report, unseen if nowhere else
BEFORE_CONTENT = 1 << 16  # byte at either end of a file in which the mark is looked for
SHOWABLE = (".png", ".svg", ".html", ".md", ".csv", ".tex")  # what a report writes


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A name to write to, beside the file, whose place it takes only once it is whole.

    Raises:
        StoreError: If it cannot be written.
        UsageError: If something that is no file is there.
    """
    target = Path(os.path.realpath(path))  # a link of the user's stays one
    if target.exists() and not target.is_file():
        raise UsageError(f"{path}: this is no plain file; give another name")
    part = target.with_name(f".{target.stem}.{os.getpid()}.part{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield part
        sync(part)
        if target.exists():
            shutil.copymode(target, part)
        os.replace(part, target)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise StoreError(f"{path}: cannot be written ({reason}); give another --output") from error
    finally:
        with suppress(OSError):
            part.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a file of text in one step.

    Raises:
        StoreError: If it cannot be written.
        UsageError: If something that is no file is there.
    """
    with replaced(path) as part:
        part.write_text(text, encoding="utf-8")


@contextmanager
def published(folder: Path, *, force: bool = False) -> Iterator[Path]:
    """A folder to write a report into, whose files take their places once all are whole.

    Args:
        folder: Where the report belongs; made if it is not there.
        force: Also replace files of a folder that holds no report of gaitlab.

    Raises:
        StoreError: If it cannot be written.
        UsageError: If the folder holds files of somebody else that would be lost.
    """
    if not force:
        _refuse_other_folder(folder)
    stage = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=f".{MARK}-", suffix=".part", dir=folder))
        yield stage
        _mark(stage / PAGE)
        _move(stage, folder)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise StoreError(
            f"{folder}: the report cannot be written ({reason}); what was there before is as it "
            "was. Give another --output"
        ) from error
    finally:
        if stage is not None:
            shutil.rmtree(stage, ignore_errors=True)
        with suppress(OSError):
            folder.rmdir()  # only if it is empty


def refuse_other(path: Path, start: bytes, mark: bytes = MARK.encode(), *, force: bool) -> None:
    """Refuse to overwrite a file that gaitlab did not write.

    Args:
        path: What is to be written.
        start: How a file of this kind starts.
        mark: What stands in one that gaitlab wrote.
        force: Whether it may be overwritten whoever wrote it.

    Raises:
        UsageError: If it is there and not gaitlab's.
    """
    if force or not os.path.lexists(path) or _is_ours(path, start, mark):
        return
    raise UsageError(
        f"--output {path}: there is a file that gaitlab did not write, which would be lost; choose "
        "another name, or --force replaces it"
    )


def _is_ours(path: Path, start: bytes, mark: bytes) -> bool:
    with suppress(OSError):
        if path.is_file():
            with path.open("rb") as file:
                ends = file.read(BEFORE_CONTENT)
                file.seek(max(len(ends), os.fstat(file.fileno()).st_size - BEFORE_CONTENT))
                return ends.startswith(start) and mark in ends + file.read(BEFORE_CONTENT)
    return False


def _refuse_other_folder(folder: Path) -> None:
    page = folder / PAGE
    with suppress(OSError, ValueError):
        if PAGE_MARK in page.read_text(encoding="utf-8"):
            return
    with suppress(OSError):
        others = [name for name in sorted(os.listdir(folder)) if Path(name).suffix in SHOWABLE]
        if others:
            raise UsageError(
                f"--output {folder}: the folder holds {others[0]} and no report of gaitlab; choose "
                "another folder, or --force writes into it"
            )


def _mark(page: Path) -> None:
    """Let a page be known again as a report's where its text does not say how to make it."""
    if page.is_file() and PAGE_MARK not in (text := page.read_text(encoding="utf-8")):
        page.write_text(f"{text}\n<!-- {PAGE_MARK} see details.md -->\n", encoding="utf-8")


def _move(stage: Path, folder: Path) -> None:
    """The page first: it is what makes the folder a report's."""
    files = sorted(path for path in stage.rglob("*") if path.is_file())
    for file in sorted(files, key=lambda path: path != stage / PAGE):
        sync(file)
    for file in sorted(files, key=lambda path: path != stage / PAGE):
        target = folder / file.relative_to(stage)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(file, target)


def sync(path: Path) -> None:
    """See to it that what a file or a folder holds is on the disk.

    Raises:
        OSError: If it cannot be.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def file_to_write(text: str) -> Path:
    """The path that an option gives.

    Raises:
        ValueError: If it is empty, or `-`, which would be a file of that name.
    """
    if not text.strip():
        raise ValueError("found nothing; give a name, or leave the option out")
    if text == "-":
        raise ValueError("found `-`; it is written to files only: give a name")
    return Path(text)
