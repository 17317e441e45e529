"""Servos by name: `gaitlab/servos/*.yaml`, and a user's own files."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from gaitlab.documents import build, load
from gaitlab.model.servo import Servo
from gaitlab.plugins import locate


def load_servo(name: str, relative_to: Path | None = None) -> Servo:
    """Servo of a name or a file; every number checked for unit and range.

    Args:
        name: Name of a file in `gaitlab/servos`, or a .yaml file of the user's own.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If there is no such servo.
        FileError: If its file is wrong.
    """
    path = locate("servo", name, relative_to)
    found = path.stat()
    return _read(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=64)
def _read(path: Path, changed: int, size: int) -> Servo:
    """The servo of a file as long as that stays the same: a search plans it thousands of times."""
    return build(Servo, load(path), skip=("description",))
