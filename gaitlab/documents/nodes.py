"""Values of a user's file, each knowing where it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gaitlab.documents.typed import instead
from gaitlab.errors import Problem

LONGEST_NUMBER = 60  # characters of one number

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
            return "a mapping (key: value)"
        if isinstance(self.value, tuple):
            return "a list"
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
