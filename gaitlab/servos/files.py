"""Servos by name: `gaitlab/servos/*.yaml`, and a user's own files."""

from __future__ import annotations

from pathlib import Path

from gaitlab.documents import build, load
from gaitlab.plugins import locate
from gaitlab.servos.servo import Servo


def load_servo(name: str, relative_to: Path | None = None) -> Servo:
    """Servo of a name or a file; every number checked for unit and range.

    Args:
        name: Name of a file in `gaitlab/servos`, or a .yaml file of the user's own.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If there is no such servo.
        FileError: If its file is wrong.
    """
    return build(Servo, load(locate("servo", name, relative_to)), skip=("description",))
