"""The section `design:` of an experiment file, checked to the last value.

design:
  type: sobol           # a scrambled Sobol' sequence; or lhs, a Latin hypercube
  points: 64
  seed: 1
  box:
    robot.mass: {low: 3.0, high: 4.0}
    surface.vertical_scale: {low: 0.5, high: 2.0, log: true}
    robot.sole.length: {low: 0.10, high: 0.15, with: {robot.sole.heel: [0.044, 0.066]}}

A path of grounds moves those that have it: `surface.bonding` every grass and no carpet.
What stands under `with:` moves in a straight line from its first value, where the swept parameter
is lowest, to its second.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Literal

from gaitlab.documents import Node, Reader, check, read_each, read_mapping
from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment.design import MOST_POINTS, Design, Follower, Quantity
from gaitlab.experiment.parts import Parts, owned
from gaitlab.experiment.search_reading import read_range
from gaitlab.parameters import Parameter

KEYS = {  # of the section, beside the box
    item.name: item
    for item in (
        Parameter(
            name="type", type=Literal["sobol", "lhs"], default="sobol", doc="how they are spread"
        ),
        Parameter(name="points", type=int, low=2, high=MOST_POINTS, doc="points in the box"),
        Parameter(name="seed", type=int, default=0, low=0, high=2**32 - 1, doc="of the points"),
    )
}
EXPECTED = "expected {low: ..., high: ...}"


def box_paths(section: Node | None) -> Iterator[tuple[str, Node]]:
    """Every path that a design moves, with the place of its key."""
    box = section.mapping.get("box") if section else None
    if box is None:
        return
    for path, node in box.mapping.items():
        yield path, box.keys[path]
        moved = node.mapping.get("with", node)
        if moved is not node:
            yield from ((name, moved.keys[name]) for name in moved.mapping)


def low_values(section: Node | None) -> dict[str, Node]:
    """A value of every swept path, for parameters that only the design gives."""
    box = section.mapping.get("box") if section else None
    found = box.mapping.items() if box else ()
    return {path: node.mapping["low"] for path, node in found if "low" in node.mapping}


def read_design(section: Node | None, parts: Parts) -> Design | None:
    """The sweep; None if the file has none.

    Raises:
        FileError: All mistakes.
    """
    if section is None:
        return None
    if section.value is not None and not section.mapping:
        raise FileError([section.problem(f"design: found {section.found()}; expected a mapping")])
    nothing = Node(file=section.file, line=section.line, column=section.column, value=None)
    whole = section if "box" in section.mapping else section.replaced(box=nothing)
    keys: dict[str, Reader] = {**KEYS, "box": partial(_read_box, parts=parts)}
    expected = "write `points: 64` for instance"
    given = read_mapping("", whole, keys, required=("points",), expected=expected)
    usual = {name: item.default for name, item in KEYS.items()}
    design = Design(**{**usual, **given})
    _require_different(section, design)
    _require_moved(section, design, parts)
    return design


def _read_box(node: Node, parts: Parts) -> tuple[Quantity, ...]:
    if not node.mapping:
        message = (
            f"design: box: found {node.found()}; expected lines of the form "
            "`robot.mass: {low: 3.0, high: 4.0}`"
        )
        raise FileError([node.problem(message)])
    return tuple(read_each(node.mapping, lambda path: _read_quantity(path, node, parts)))


def _read_quantity(path: str, box: Node, parts: Parts) -> Quantity:
    """One edge of the box."""
    item = _known(path, box.keys[path], parts)
    followers: dict[str, Reader] = {"with": partial(_read_followers, path, parts=parts)}
    numbers, given = read_range(item, box.mapping[path], followers, EXPECTED)
    return Quantity(range=numbers, followers=given.get("with", ()))


def _known(path: str, key: Node, parts: Parts) -> Parameter:
    """What is known of a path that has a range."""
    try:
        item = replace(parts.parameter(path), name=path)
    except WrongValue as error:
        raise FileError([key.problem(f"design: {error}")]) from None
    if item.type not in (int, float):
        message = f"design: {path} is no number; vary it under grid or zip"
        raise FileError([key.problem(message)])
    return item


def _read_followers(path: str, node: Node, parts: Parts) -> tuple[Follower, ...]:
    if not node.mapping:
        message = f"{path}: with: found {node.found()}; expected {{robot.sole.heel: [0.04, 0.06]}}"
        raise FileError([node.problem(message)])
    return tuple(read_each(node.mapping, lambda name: _read_follower(name, node, parts)))


def _read_follower(path: str, moved: Node, parts: Parts) -> Follower:
    item, node = _known(path, moved.keys[path], parts), moved.mapping[path]
    if len(node.items) != 2:
        found = f"{len(node.items)} values" if node.items else node.found()
        message = f"{path}: found {found}; expected two, [at the low end, at the high end]"
        raise FileError([node.problem(message)])
    low, high = read_each(node.items, partial(check, item))
    return Follower(path=path, low=low, high=high, integer=item.type is int)


def _require_different(section: Node, design: Design) -> None:
    """Refuse a box of whole numbers that has fewer points than are asked for."""
    different = len(set(design.axis().rows))
    if different < design.points:
        message = (
            f"design: only {different} of the {design.points} points differ, because the box holds "
            "few whole numbers; ask for fewer points or list them under grid"
        )
        raise FileError([section.mapping["points"].problem(message)])


def _require_moved(section: Node, design: Design, parts: Parts) -> None:
    """Refuse a ground on which all points are the same walk."""
    paths = [path for item in design.box for path in item.paths]
    if not all(path.startswith("surface.") for path in paths):
        return
    for name, surface in parts.surfaces.items():
        if not owned(surface, {path.removeprefix("surface."): 0.0 for path in paths}):
            message = (
                f"design: box: {name} has none of {', '.join(paths)}, so that all points are the "
                "same there; take it off `surfaces:` or sweep something that it has"
            )
            raise FileError([section.keys["box"].problem(message)])
