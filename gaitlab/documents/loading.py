"""YAML as a tree of values that know where they stand. Loading never runs code.

YAML 1.2, so `1e-3` is a number, `no` is text and `012` is twelve. Tags, merge keys and
directives are refused; anchors are allowed as long as they do not multiply.

References:
    YAML-1.2: YAML Ain't Markup Language, version 1.2, revision 1.2.2, 2021.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, ScalarNode
from ruamel.yaml.nodes import Node as YamlNode
from ruamel.yaml.reader import ReaderError
from ruamel.yaml.representer import SafeRepresenter

from gaitlab.documents.nodes import LONGEST_NUMBER, MINUSES, Node, Scalar, instead
from gaitlab.documents.printable import is_utf8
from gaitlab.errors import FileError, Problem

# What is refused within a second, for ruamel.yaml reads some 10^4 values or 10^5 characters in one.
LARGEST_FILE = 2**18  # bytes; twenty times the largest file that is shipped
MOST_WRITTEN = 20_000  # values and keys as they stand in the file
MOST_KEYS = 500  # of one mapping
MOST_ANCHORS = 500  # of a file
MOST_VALUES = 200_000  # nodes after anchors are followed, against files that multiply
DEEPEST = 20  # levels; an experiment needs five
TOO_DEEP = f"nested too deep; at most {DEEPEST} levels are allowed"
LEADING_ZERO = re.compile(r"0\d")
BEFORE_COMMA = re.compile(rf"[{MINUSES}+]?[\d.]{{1,20}},$")
TAG = "tag:yaml.org,2002:"
DATE = re.compile(r"\d{4}-")  # begins what YAML takes for an instant; here it is text
PLAIN = re.compile(r"[A-Za-z_./][\w./ -]*\w|[A-Za-z_]")  # ruamel still quotes `yes` and the like

BARE = re.compile(r"(\.{0,2}/)?[A-Za-z_][\w./-]*", re.ASCII)  # needs no quotes on a line


class _Representer(SafeRepresenter):
    """Quotes every text that is not plainly a name, a path or a phrase of words.

    Left alone, ruamel.yaml writes `:a` bare inside braces, where it cannot read it again.
    """


def _text_node(representer: SafeRepresenter, text: str) -> ScalarNode:
    style = None if PLAIN.fullmatch(text) else '"'
    return representer.represent_scalar(f"{TAG}str", text, style=style)


_Representer.add_representer(str, _text_node)


class _TooMuch(MarkedYAMLError):
    """More than any experiment has."""


class _Composer(Composer):
    """Gives up at once where a file has more of something than any experiment."""

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self.warn_double_anchors, self.written = False, 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self.written += 1
        keys = len(parent.value) if isinstance(parent, MappingNode) else 0
        for count, most, problem in (
            (self.depth, DEEPEST, TOO_DEEP),
            (keys, MOST_KEYS, f"more than {MOST_KEYS} keys in one mapping; write fewer"),
            (len(self.anchors), MOST_ANCHORS, f"more than {MOST_ANCHORS} anchors; write fewer"),
            (self.written, MOST_WRITTEN, f"more than {MOST_WRITTEN} values; write fewer"),
        ):
            if count > most:
                mark = self.parser.peek_event().start_mark
                raise _TooMuch(problem=problem, problem_mark=mark)
        return super().compose_node(parent, index)


def dump(data: object) -> str:
    """Plain data as YAML text in block style, keys in order."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = _Representer
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    stream = io.StringIO()
    yaml.dump(_listed(data), stream)
    return stream.getvalue()


def _listed(data: object) -> object:
    if isinstance(data, Mapping):
        return {key: _listed(value) for key, value in data.items()}
    return [_listed(value) for value in data] if isinstance(data, tuple | list) else data


def inline(value: object) -> str:
    """A value as YAML on one line: a text in quotes where it needs them, a list, a mapping."""
    if isinstance(value, Mapping):
        entries = (f"{inline(str(key))}: {inline(item)}" for key, item in value.items())
        return "{" + ", ".join(entries) + "}"
    if isinstance(value, tuple | list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if not isinstance(value, str):
        return json.dumps(value)
    if BARE.fullmatch(value) and value.lower() not in ("true", "false", "null"):
        return value
    return "'" + value.replace("'", "''") + "'" if value.isprintable() else json.dumps(value)


def load(path: Path) -> Node:
    """Root mapping of a YAML file.

    Raises:
        FileError: If it cannot be read, is not YAML or holds no mapping; says where.
    """
    node = parse(_text(path), path)
    if not isinstance(node.value, Mapping) or not node.value:
        what = "the file is empty" if node.value in (None, {}) else f"found {node.found()}"
        raise FileError([node.problem(f"{what}; expected lines of the form `key: value`")])
    return node


def _text(path: Path) -> str:
    try:
        if path.is_dir():
            raise _whole(path, "is a directory; give a .yaml file in it")
        with path.open("rb") as file:
            raw = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _whole(path, f"cannot be read: {reason}; check the name and the folder") from error
    if len(raw) > LARGEST_FILE:
        raise _whole(path, f"has more than {LARGEST_FILE} bytes; no experiment needs so many")
    return _decoded(path, raw)


def _decoded(path: Path, raw: bytes) -> str:
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = raw[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        message = f"byte {raw[error.start]:#04x} is not text; save the file as UTF-8 YAML"
        raise FileError([Problem(file=path, line=line, column=column, message=message)]) from error


def _whole(path: Path, message: str) -> FileError:
    return FileError([Problem(file=path, line=None, column=None, message=message)])


@lru_cache(maxsize=128)  # a robot's grounds are also those of the next
def parse(text: str, file: Path, *, placed: bool = True) -> Node:
    """Tree of a YAML text; `placed` is False for a value from the command line.

    Raises:
        FileError: If the text is not the YAML that is allowed here.
    """
    if len(text) > LARGEST_FILE:
        raise _whole(file, f"is {len(text)} characters long; at most {LARGEST_FILE} are allowed")
    directive = re.match(r"(?:\s*#.*\n|\s*\n)*%", text)
    if directive:
        line = text[: directive.end()].count("\n") + 1
        message = "a %-directive; files are YAML 1.2 without directives, delete the line"
        raise FileError([Problem(file=file, line=line, column=1, message=message)])
    try:
        yaml = YAML(typ="safe", pure=True)
        yaml.Composer = _Composer
        root = yaml.compose(text)
    except YAMLError as error:
        problem = _syntax_problem(error, file, text)
        raise FileError([problem if placed else _unplaced(problem)]) from error
    if root is None:
        return Node(file=file, line=1 if placed else None, column=1 if placed else None, value=None)
    return _Reader(file, text, placed).node(root, 0)


def _control_character(error: ReaderError, file: Path, text: str) -> Problem:
    before = text[: error.position]
    line, column = before.count("\n") + 1, error.position - before.rfind("\n")
    message = "a control character, which is no text; delete it or save the file as UTF-8 YAML"
    return Problem(file=file, line=line, column=column, message=message)


def _syntax_problem(error: YAMLError, file: Path, text: str) -> Problem:
    if isinstance(error, ReaderError):
        return _control_character(error, file, text)
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        message = f"not YAML: {str(error).splitlines()[0]}; check brackets, colons and indentation"
        return Problem(file=file, line=None, column=None, message=message)
    mark, start = error.problem_mark, error.context_mark
    if isinstance(error, _TooMuch):
        message = str(error.problem)
        return Problem(file=file, line=mark.line + 1, column=mark.column + 1, message=message)
    begun = ""
    if start is not None and start.line < mark.line and "flow" in f"{error.context}":
        begun = f" (the bracket was opened in line {start.line + 1})"
    if start is not None and start.line < mark.line and "quoted" in f"{error.context}":
        begun = f" (the quote was opened in line {start.line + 1})"
    message = f"not YAML: {error.problem}{begun}; {_advice(str(error.problem), text, mark.line)}"
    return Problem(file=file, line=mark.line + 1, column=mark.column + 1, message=message)


def _advice(problem: str, text: str, line: int) -> str:
    """What usually is behind a complaint of the YAML library."""
    if "\\t" in problem or "tab" in problem:
        return "YAML is indented with spaces, never with tabs"
    if "\N{NO-BREAK SPACE}" in "".join(text.splitlines()[max(0, line - 1) : line + 1]):
        return "there is a no-break space in this line or above; type the spaces anew"
    if "mapping values" in problem:
        return "a line has two colons, or the line above lacks its colon and a space after it"
    return "check brackets, colons and indentation"


def _unplaced(problem: Problem) -> Problem:
    return Problem(file=problem.file, line=None, column=None, message=problem.message)


class _Reader:
    """Turns the nodes of the YAML library into ours and refuses what is not wanted."""

    def __init__(self, file: Path, text: str, placed: bool) -> None:
        self.file, self.text, self.placed, self.count = file, text, placed, 0

    def node(self, source: YamlNode, depth: int) -> Node:
        self.count += 1
        if depth > DEEPEST:
            raise self.wrong(source, TOO_DEEP)
        if self.count > MOST_VALUES:
            raise self.wrong(source, f"anchors expand to over {MOST_VALUES} values; write fewer")
        if isinstance(source, MappingNode):
            return self.mapping(source, depth)
        if isinstance(source, ScalarNode):
            return self.placed_node(source, self.scalar(source))
        self.tag(source, "seq")
        for item in source.value:
            if isinstance(item, ScalarNode) and LEADING_ZERO.match(str(item.value)):
                self.refuse_comma(item)
        return self.placed_node(source, tuple(self.node(n, depth + 1) for n in source.value))

    def mapping(self, source: MappingNode, depth: int) -> Node:
        self.tag(source, "map")
        values: dict[str, Node] = {}
        keys: dict[str, Node] = {}
        for key_source, value_source in source.value:
            key = self.key(key_source)
            name = str(key.value)
            if name in keys:
                first = f" (first in line {keys[name].line})" if self.placed else ""
                raise FileError([key.problem(f"duplicate key {name!r}{first}; keep one of them")])
            value = self.node(value_source, depth + 1)
            # A value left empty has the place of whatever comes next; its key is nearer.
            empty = value_source.start_mark.index == value_source.end_mark.index
            keys[name], values[name] = key, key.holding(value) if empty else value
        node = self.placed_node(source, values)
        return Node(file=node.file, line=node.line, column=node.column, value=values, keys=keys)

    def key(self, source: YamlNode) -> Node:
        if source.tag == f"{TAG}merge":
            raise self.wrong(source, "merge keys (<<) are not read; use `include: file.yaml`")
        if not isinstance(source, ScalarNode) or source.tag != f"{TAG}str":
            self.refuse_comma(source)
            raise self.wrong(source, "a key is a name, such as step_height; write it as text")
        return self.placed_node(source, self.words(source))

    def refuse_comma(self, source: YamlNode) -> None:
        """Refuse digits that stand right behind digits and a comma: what was meant is 0.03.

        Raises:
            FileError: If they do.
        """
        before = BEFORE_COMMA.search(self.text[: source.start_mark.index])
        if isinstance(source, ScalarNode) and before and str(source.value).isdigit():
            typed = f"{before[0]}{source.value}"
            meant = instead(typed) or "write the number with a point"
            raise self.wrong(source, f"found {typed}; a comma parts values, {meant}")

    def scalar(self, source: ScalarNode) -> Scalar:
        short, text = str(source.tag).removeprefix(TAG), str(source.value)
        if short == "str" or (short == "timestamp" and DATE.match(text)):
            return self.words(source)
        if short == "null" and text.lower() in ("", "~", "null"):
            return None
        if short == "bool" and text.lower() in ("true", "false"):
            return text.lower() == "true"
        if short in ("int", "float"):
            try:
                return self.number(source)
            except ValueError:
                pass
        if short in ("null", "bool", "int", "float", "timestamp"):
            message = f"{text[:60]!r} does not fit its tag !!{short}; write the value without a tag"
            raise self.wrong(source, message)
        raise self.wrong(source, f"the tag {source.tag} is not allowed; write the value alone")

    def words(self, source: ScalarNode) -> str:
        text = str(source.value)
        if not is_utf8(text):
            message = f"{text[:60]!r} holds half of a character; write the character itself"
            raise self.wrong(source, message)
        return text

    def number(self, source: ScalarNode) -> int | float:
        text = str(source.value).replace("_", "").lower()
        if len(text) > LONGEST_NUMBER:
            raise self.wrong(source, f"a number of {len(text)} digits; write it shorter")
        if text.lstrip("+-") in (".inf", ".nan"):
            return float(text.replace(".", ""))
        if str(source.tag) == f"{TAG}float":
            return float(text)
        prefixed = text.lstrip("+-").startswith(("0x", "0o", "0b"))
        return int(text, 0 if prefixed else 10)

    def tag(self, source: YamlNode, wanted: str) -> None:
        if source.tag != f"{TAG}{wanted}":
            raise self.wrong(source, f"the tag {source.tag} is not allowed; write the value alone")

    def placed_node(self, source: YamlNode, value: Scalar | tuple[Node, ...] | dict) -> Node:
        if not self.placed:
            return Node(file=self.file, value=value)
        mark = source.start_mark
        return Node(file=self.file, line=mark.line + 1, column=mark.column + 1, value=value)

    def wrong(self, source: YamlNode, message: str) -> FileError:
        return FileError([self.placed_node(source, None).problem(message)])
