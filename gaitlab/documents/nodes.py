"""Values of a user's file, each knowing where it stands, and the mistakes found at them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from gaitlab.errors import FileError, Problem

T = TypeVar("T")
LONGEST_NUMBER = 60  # characters of one number
MINUSES = "-−‐‑‒–—﹣－"  # of keyboards and of typography
LOOKALIKES = str.maketrans("，．٫＋ｅＥ\N{NO-BREAK SPACE}", ",..+eE ")
NUMBER = re.compile(r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(\S*)")

Scalar = str | int | float | bool | None


@dataclass(frozen=True, kw_only=True)
class Node:
    """One value of a file.

    Attributes:
        file: File it stands in; `--set path=value` for one from the command line.
        line: Line, counted from 1; None for one from the command line.
        column: Column, counted from 1.
        value: A scalar, a tuple of nodes, or nodes by key.
        keys: Nodes of the keys themselves, for a mapping.
    """

    file: Path
    line: int | None = None
    column: int | None = None
    value: Scalar | tuple[Node, ...] | Mapping[str, Node]
    keys: Mapping[str, Node] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Folder that a relative file named here starts from; the working one for `--set`."""
        return Path.cwd() if self.line is None else self.file.parent

    @property
    def mapping(self) -> Mapping[str, Node]:
        """Nodes by key; empty when this is no mapping."""
        return self.value if isinstance(self.value, Mapping) else {}

    @property
    def items(self) -> tuple[Node, ...]:
        """Nodes of a list; empty when this is no list."""
        return self.value if isinstance(self.value, tuple) else ()

    def problem(self, message: str) -> Problem:
        """A mistake at this place."""
        return Problem(file=self.file, line=self.line, column=self.column, message=message)

    def found(self) -> str:
        """What stands here, for a message."""
        if isinstance(self.value, Mapping):
            return "a mapping (key: value)" if self.value else "nothing"
        if isinstance(self.value, tuple):
            return "a list" if self.value else "an empty list"
        if self.value is None:
            return "nothing"
        if isinstance(self.value, bool):
            return str(self.value).lower()
        if not isinstance(self.value, str):
            return str(self.value)
        meant = instead(self.value[:LONGEST_NUMBER])
        return f"the text {self.value[:60]!r}{f' ({meant})' if meant else ''}"

    def holding(self, other: Node) -> Node:
        """The value of another node at this place."""
        return Node(file=self.file, line=self.line, column=self.column, value=other.value)

    def replaced(self, **values: Node) -> Node:
        """Copy of a mapping with some entries set; the keys stand where the values stand."""
        keys = {name: node for name, node in values.items() if name not in self.keys}
        return Node(
            file=self.file,
            line=self.line,
            column=self.column,
            value={**self.mapping, **values},
            keys={**self.keys, **keys},
        )

    def without(self, *names: str) -> Node:
        """Copy of a mapping without some entries."""
        kept = {name: node for name, node in self.mapping.items() if name not in names}
        return Node(file=self.file, line=self.line, column=self.column, value=kept, keys=self.keys)


def plain(node: Node) -> object:
    """The values alone: dictionaries, tuples and scalars."""
    if isinstance(node.value, Mapping):
        return {key: plain(child) for key, child in node.value.items()}
    if isinstance(node.value, tuple):
        return tuple(plain(child) for child in node.value)
    return node.value


def merged(base: Node, child: Node) -> Node:
    """Both mappings in one; where both have a value the child's wins, lists are replaced whole."""
    entries = {}
    for key, node in child.mapping.items():
        both = key in base.mapping and base.mapping[key].mapping and node.mapping
        entries[key] = merged(base.mapping[key], node) if both else node
    keys = {**base.keys, **child.keys}
    value = {**base.mapping, **entries}
    return Node(file=child.file, line=child.line, column=child.column, value=value, keys=keys)


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


def typed_number(text: str) -> tuple[str, str]:
    """The number that a text begins with as YAML writes it, whatever keyboard it came from.

    Returns:
        The number and what follows it; both empty if the text begins with none.
    """
    found = NUMBER.match(_plain(text).strip())
    return (found[1].replace(",", "."), found[2]) if found else ("", "")


def instead(text: str) -> str:
    """`write 0.03, with a point`: how a number that YAML takes for a text is written.

    Empty if the text is no number alone, or is one in YAML as well.
    """
    number, rest = typed_number(text)
    reasons = [
        *(["with a point"] if "," in _plain(text) else []),
        *(["with the minus sign of the keyboard"] if set(text) & set(MINUSES[1:]) else []),
        *(["in the digits 0 to 9"] if any(c.isdigit() and not c.isascii() for c in text) else []),
    ]
    return f"write {number}, {' and '.join(reasons)}" if number and reasons and not rest else ""


def _plain(text: str) -> str:
    return "".join(map(_letter, text)).translate(LOOKALIKES)


def _letter(letter: str) -> str:
    if unicodedata.category(letter) == "Nd":
        return str(unicodedata.digit(letter))
    return "-" if letter in MINUSES else letter
