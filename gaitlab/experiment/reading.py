"""The file of an experiment as one tree: its base files included, its settings applied."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from gaitlab.documents import Node, load, merged, parse
from gaitlab.errors import FileError, UsageError
from gaitlab.plugins import label as label_of
from gaitlab.plugins import suggestion

PATH = re.compile(r"\w+(\.\w+)*")
LONGEST_SHOWN = 200  # characters of a setting that a message quotes
DEEPEST_INCLUDE = 8  # files
HANDED_DOWN = ("robot", "gait", "balance", "servo", "engine")  # sections that belong to a walker
WALKER_KEYS = ("name", "include", *HANDED_DOWN)
LISTED = ("variants", "metrics")  # of the report: a name alone stands for a list of one
STAND = "stand"  # a gait that holds the first pose of the walk below it
TYPED = ("robot", "gait", "balance", "servo")  # sections that may be a bare name
PATHS_AS_KEYS = ("grid", "zip", "one_at_a_time")  # sections whose keys are dotted paths
RANGED = ("study.search.", "design.box.")  # what the dotted path of a range follows
ENDS = ("low", "high", "step", "log")  # keys of a range that can be set alone
OWN = ("name", "title", "description")  # keys that a base file does not hand down


def read_tree(path: Path) -> tuple[Node, bool]:
    """Root mapping of an experiment file on top of the files it includes, and if there are any.

    Raises:
        FileError: If one of them is wrong or they include each other.
    """
    return _read(path, (path.resolve(),))


def _read(path: Path, chain: tuple[Path, ...]) -> tuple[Node, bool]:
    tree = load(path)
    include = tree.mapping.get("include")
    tree = _with_types(tree.without("include"))
    if include is None:
        return tree, False
    base, _ = _read(*_included(path, include, chain))
    return _on_base(base.without(*OWN), tree), True


def _included(path: Path, include: Node, chain: tuple[Path, ...]) -> tuple[Path, tuple[Path, ...]]:
    if not isinstance(include.value, str):
        message = f"include: found {include.found()}; expected one .yaml file, relative to this one"
        raise FileError([include.problem(message)])
    base = _resolved(path.parent / include.value, include)
    if base in chain or len(chain) > DEEPEST_INCLUDE:
        route = " -> ".join(file.name for file in (*chain, base))
        message = f"include: files include each other or too deep ({route}); leave one out"
        raise FileError([include.problem(message)])
    if not base.is_file():
        what = "a directory is at" if base.is_dir() else "there is no file"
        message = f"include: {what} {base}; give a .yaml file relative to {path.parent}"
        raise FileError([include.problem(message)])
    return base, (*chain, base)


def _resolved(file: Path, include: Node) -> Path:
    try:
        base = Path(os.path.realpath(file))
        with suppress(FileNotFoundError, NotADirectoryError):
            os.stat(base)
        return base
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"include: {str(file)[:200]!r} leads nowhere: {reason}; give a .yaml file"
        raise FileError([include.problem(message)]) from error


def _with_types(tree: Node) -> Node:
    """`gait: eros` written as `gait: {type: eros}`."""
    entries = {}
    for name in TYPED:
        node = tree.mapping.get(name)
        if node is not None and isinstance(node.value, str):
            entries[name] = _mapping_at(node).replaced(type=node)
    return _with_list(tree.replaced(**entries))


def _with_list(tree: Node) -> Node:
    """`variants: gait.heel_strike` written as `variants: [gait.heel_strike]`, one map as a list."""
    report = tree.mapping.get("report", tree)
    if report is tree:
        return tree
    given = report.mapping
    listed = {k: _list_of(given[k]) for k in LISTED if k in given and _is_text(given[k])}
    maps = given.get("maps")
    if maps and maps.items and all(_is_text(item) for item in maps.items):
        listed["maps"] = _list_of(maps)
    return tree.replaced(report=report.replaced(**listed)) if listed else tree


def _is_text(node: Node) -> bool:
    return isinstance(node.value, str)


def _list_of(node: Node) -> Node:
    return Node(file=node.file, line=node.line, column=node.column, value=(node,))


def _mapping_at(node: Node) -> Node:
    return Node(file=node.file, line=node.line, column=node.column, value={})


def _on_base(base: Node, child: Node) -> Node:
    """The child wins; another `type` leaves the parameters of the base's type behind.

    A key with nothing after it leaves out what the base has there. A gait that only stands keeps
    the base's gait as the walk from whose first pose it takes its own.
    """
    child = _with_walk(base, child)
    dropped = [name for name in TYPED if _changes_type(base, child, name)]
    empty = [key for key, node in child.mapping.items() if node.value is None]
    left_out = [key for key in empty if key in base.mapping]
    return merged(base.without(*dropped, *left_out), child.without(*left_out))


def _with_walk(base: Node, child: Node) -> Node:
    gait, walk = child.mapping.get("gait"), base.mapping.get("gait")
    if gait is None or walk is None or not _changes_type(base, child, "gait"):
        return child
    if gait.mapping["type"].value != STAND or "walk" in gait.mapping:
        return child
    return child.replaced(gait=gait.replaced(walk=walk))


def _changes_type(base: Node, child: Node, name: str) -> bool:
    old, new = (tree.mapping.get(name) for tree in (base, child))
    if old is None or new is None or "type" not in new.mapping or "type" not in old.mapping:
        return False
    return old.mapping["type"].value != new.mapping["type"].value


def walker_trees(tree: Node) -> dict[str, Node]:
    """The experiment of each walker by what it is called; empty when the file lists none.

    Raises:
        FileError: If a walker is no mapping of robot, gait and servo, or two are called alike.
    """
    node = tree.mapping.get("walkers")
    if node is None:
        return {}
    problems = [
        tree.keys[key].problem(f"{key}: the walkers have their own; move it to each of them")
        for key in ("robot", "gait")
        if key in tree.mapping
    ]
    if not node.items:
        message = f"walkers: found {node.found()}; expected a list of {{robot: ..., gait: ...}}"
        problems.append(node.problem(message))
    if problems:
        raise FileError(problems)
    shared, found = tree.without("walkers"), {}
    for item in node.items:
        label, walker = _walker(item)
        if label in found:
            message = f"walkers: {label!r} is there already; give one of them a `name`"
            raise FileError([item.problem(message)])
        found[label] = merged(shared, walker)
    return found


def _walker(item: Node) -> tuple[str, Node]:
    """What a walker is called, and its own sections on top of the file it includes."""
    unknown = [key for key in item.mapping if key not in WALKER_KEYS]
    if unknown or not item.mapping:
        place = item.keys[unknown[0]] if unknown else item
        what = f"unknown key {unknown[0]!r}" if unknown else f"found {item.found()}"
        hint = suggestion(unknown[0] if unknown else "", WALKER_KEYS)
        raise FileError([place.problem(f"walkers: {what}{hint}")])
    own, include = _with_types(item.without("name", "include")), item.mapping.get("include")
    if include is not None:
        base, _ = _read(*_included(item.file, include, (item.file.resolve(),)))
        own = _on_base(base.without(*(key for key in base.mapping if key not in HANDED_DOWN)), own)
    name = item.mapping.get("name") or own.mapping.get("robot", item).mapping.get("type", item)
    if not isinstance(name.value, str):
        raise FileError(
            [name.problem("walkers: each has a `robot` and a `gait`, or includes them")]
        )
    return label_of(name.value), own


def apply_setting(tree: Node, setting: str) -> Node:
    """Tree with one `path=value` of the command line applied; the value is read as YAML.

    Raises:
        UsageError: If it has no `=`, or names a parameter that the file varies.
        FileError: If the value is no YAML.
    """
    path, equals, text = setting.partition("=")
    path, shown = path.strip(), setting[:LONGEST_SHOWN]
    if not equals or not PATH.fullmatch(path):
        raise UsageError(
            f"--set {shown}: write path=value, gait.step_height=0.03 for instance; a path is "
            "names with dots between them"
        )
    for section in PATHS_AS_KEYS:
        if path in _varied(tree, section):
            raise UsageError(
                f"--set {setting}: the file varies {path} under {section}, so the value would "
                f"change nothing; write --set {shlex.quote(f'{section}.{path}=[{text}]')}"
            )
    if path in _searched(tree):
        raise UsageError(
            f"--set {setting}: the study searches {path}, so the value would change nothing; "
            f"write --set 'study.search.{path}={{low: ..., high: ...}}', or delete it from "
            "the file's search"
        )
    if path in _swept(tree):
        raise UsageError(
            f"--set {setting}: the file sweeps {path} under design, so the value would change "
            f"nothing; write --set 'design.box.{path}={{low: ..., high: ...}}'"
        )
    value = parse(text, Path(f"--set {shown}"), placed=False)
    changed = _set(tree, _steps(path), value)
    if path == "gait" and value.value == STAND:
        changed = _with_walk(tree, _with_types(changed))
    return _with_types(_on_base(tree, changed) if path in TYPED else changed)


def _varied(tree: Node, section: str) -> set[str]:
    node = tree.mapping.get(section)
    parts = (node, *node.items) if node is not None else ()
    return {path for part in parts for path in part.mapping}


def _searched(tree: Node) -> set[str]:
    study = tree.mapping.get("study", tree)
    return set(study.mapping["search"].mapping) if "search" in study.mapping else set()


def _swept(tree: Node) -> set[str]:
    design = tree.mapping.get("design")
    box = design.mapping.get("box") if design else None
    found = box.mapping.items() if box else ()
    return {path for key, node in found for path in (key, *_moved_with(node))}


def _moved_with(node: Node) -> tuple[str, ...]:
    return tuple(node.mapping["with"].mapping) if "with" in node.mapping else ()


def _steps(path: str) -> list[str]:
    for start in RANGED:
        if path.startswith(start):
            parameter, dot, end = path.removeprefix(start).rpartition(".")
            whole = [f"{parameter}{dot}{end}"] if end not in ENDS else [parameter, end]
            return [*start.strip(".").split("."), *whole]
    head, _, rest = path.partition(".")
    return [head, rest] if head in PATHS_AS_KEYS and rest else path.split(".")


def _set(node: Node, steps: Sequence[str], value: Node) -> Node:
    if not steps:
        return value
    if not node.mapping:
        node = Node(file=value.file, value={})
    child = node.mapping.get(steps[0], Node(file=value.file, value={}))
    return node.replaced(**{steps[0]: _set(child, steps[1:], value)})
