"""XML of a user's, with the line and column of every element; entities are refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

import numpy as np

from gaitlab.errors import FileError, Problem

LARGEST = 20_000_000  # characters of a file


@dataclass(eq=False)
class Tag:
    """An element of an XML file and where it begins."""

    name: str
    attributes: Mapping[str, str]
    file: Path
    line: int
    column: int
    children: list[Tag] = field(default_factory=list)

    def wrong(self, message: str) -> FileError:
        """A mistake in this element."""
        return FileError(
            [Problem(file=self.file, line=self.line, column=self.column, message=message)]
        )

    def all(self, name: str) -> list[Tag]:
        """Children of a name."""
        return [child for child in self.children if child.name == name]

    def first(self, name: str) -> Tag | None:
        """The first child of a name."""
        return next(iter(self.all(name)), None)

    def text(self, name: str) -> str:
        """An attribute that has to be there.

        Raises:
            FileError: If it is not.
        """
        if not self.attributes.get(name, "").strip():
            raise self.wrong(f"<{self.name}> has no {name}; give it one")
        return self.attributes[name].strip()

    def numbers(self, name: str, default: Sequence[float]) -> np.ndarray:
        """Numbers of an attribute, as many as the default has.

        Raises:
            FileError: If they are others, or no finite numbers.
        """
        if name not in self.attributes:
            return np.array(default, dtype=float)
        try:
            found = np.array([float(part) for part in self.attributes[name].split()])
        except ValueError:
            found = np.array([])
        if len(found) != len(default) or not np.isfinite(found).all():
            raise self.wrong(
                f"<{self.name} {name}={self.attributes[name]!r}>: expected "
                f"{len(default)} finite number{'s' if len(default) > 1 else ''}"
            )
        return found

    def number(self, name: str, default: float) -> float:
        """One number of an attribute, likewise."""
        return float(self.numbers(name, (default,))[0])


def parse(text: str, file: Path) -> Tag:
    """The outermost element of an XML file.

    Entities and document types are refused: what they include is not the robot's.

    Raises:
        FileError: If it is no XML.
    """
    if len(text) > LARGEST:
        raise _at(file, 1, 1, f"the file has {len(text)} characters; no robot needs {LARGEST}")
    parser, open_tags, outermost = expat.ParserCreate(), list[Tag](), list[Tag]()

    def begins(name: str, attributes: dict[str, str]) -> None:
        tag = Tag(name, attributes, file, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)
        (open_tags[-1].children if open_tags else outermost).append(tag)
        open_tags.append(tag)

    def refused(*_: object) -> NoReturn:
        raise _at(
            file, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1,
            "a DOCTYPE or an entity; take it out, a URDF needs none",
        )  # fmt: skip

    parser.StartElementHandler, parser.EndElementHandler = begins, lambda _: open_tags.pop()
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = refused
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        message = f"this is no XML: {expat.errors.messages[error.code]}"
        raise _at(file, error.lineno, error.offset + 1, message) from error
    return outermost[0]


def _at(file: Path, line: int, column: int, message: str) -> FileError:
    return FileError([Problem(file=file, line=line, column=column, message=message)])
