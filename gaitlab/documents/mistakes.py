"""Mistakes of a file, gathered so that a user is told of all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from gaitlab.errors import FileError, Problem

T = TypeVar("T")


def collected(problems: list[Problem], read: Callable[[], T]) -> T | None:
    """Result of `read()`; None if it raises a `FileError`, whose problems join the others."""
    try:
        return read()
    except FileError as error:
        problems += error.problems
        return None


def in_order(problems: Sequence[Problem]) -> list[Problem]:
    """Each problem once, by place in the file; what stands on the command line first."""
    unique = dict.fromkeys(problems)
    return sorted(unique, key=lambda p: (str(p.file), p.line or 0, p.column or 0))
