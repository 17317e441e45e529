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
from dataclasses import dataclass, replace
from typing import Literal

from gaitlab.documents import Node, build, check, collected
from gaitlab.errors import FileError, Problem, WrongValue
from gaitlab.experiment.design import MOST_POINTS, Design, Follower, Quantity
from gaitlab.experiment.parts import Parts, owned
from gaitlab.experiment.ranges import read_ends, unknown_keys
from gaitlab.experiment.study import Numbers
from gaitlab.parameters import Parameter, parameter

LARGEST_SEED = 2**32 - 1
KEYS = ("low", "high", "log", "with")
EXPECTED = "expected {low: ..., high: ...}"


@dataclass(frozen=True, kw_only=True)
class DesignSections:
    """Keys of the section."""

    type: Literal["sobol", "lhs"] = parameter(
        "sobol", unit="-", doc="scrambled Sobol' sequence, or Latin hypercube"
    )
    points: int = parameter(unit="-", low=2, high=MOST_POINTS, doc="points in the box")
    seed: int = parameter(0, unit="-", low=0, high=LARGEST_SEED, doc="of the points")
    box: Node | None = parameter(None, unit="-", doc="dotted paths, each with its range")


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
    problems: list[Problem] = []
    keys = collected(problems, lambda: build(DesignSections, section, skip=()))
    box = _box(section, parts, problems) if section.mapping else ()
    if problems or keys is None:
        raise FileError(problems)
    design = Design(type=keys.type, points=keys.points, seed=keys.seed, box=tuple(box))
    _require_different(section, design)
    _require_moved(section, design, parts)
    return design


def _box(section: Node, parts: Parts, problems: list[Problem]) -> list[Quantity]:
    node = section.mapping.get("box")
    if node is None or not node.mapping:
        place = node or section
        found = "nothing" if node is None or node.value in ({}, (), None) else node.found()
        message = (
            f"design: box: found {found}; expected lines of the form "
            "`robot.mass: {low: 3.0, high: 4.0}`"
        )
        problems.append(place.problem(message))
        return []
    found_items = (_quantity(path, node, parts, problems) for path in node.mapping)
    return [item for item in found_items if item is not None]


def _quantity(path: str, box: Node, parts: Parts, problems: list[Problem]) -> Quantity | None:
    """One edge of the box; its mistakes go to `problems`."""
    node = box.mapping[path]
    item = _known(path, box.keys[path], parts, problems)
    if item is None:
        return None
    if not node.mapping:
        problems.append(node.problem(f"{path}: found {node.found()}; {EXPECTED}"))
        return None
    problems += unknown_keys(item, node, KEYS)
    followers = _followers(path, node.mapping.get("with"), parts, problems)
    ends = collected(problems, lambda: read_ends(item, node.without("step"), EXPECTED))
    if ends is None:
        return None
    low, high, _, log = ends
    numbers = Numbers(path=path, low=low, high=high, log=log, integer=item.type is int)
    return Quantity(range=numbers, followers=tuple(followers))


def _known(path: str, key: Node, parts: Parts, problems: list[Problem]) -> Parameter | None:
    """What is known of a path that has a range."""
    try:
        item = replace(parts.parameter(path), name=path)
    except WrongValue as error:
        problems.append(key.problem(f"design: {error}"))
        return None
    if item.type not in (int, float):
        problems.append(key.problem(f"design: {path} is no number; vary it under grid or zip"))
        return None
    return item


def _followers(
    path: str, node: Node | None, parts: Parts, problems: list[Problem]
) -> list[Follower]:
    if node is None:
        return []
    if not node.mapping:
        message = f"{path}: with: found {node.found()}; expected {{robot.sole.heel: [0.04, 0.06]}}"
        problems.append(node.problem(message))
    found = (_follower(name, node, parts, problems) for name in node.mapping)
    return [follower for follower in found if follower is not None]


def _follower(path: str, moved: Node, parts: Parts, problems: list[Problem]) -> Follower | None:
    node = moved.mapping[path]
    item = _known(path, moved.keys[path], parts, problems)
    if item is None:
        return None
    if len(node.items) != 2:
        found = f"{len(node.items)} values" if node.items else node.found()
        message = f"{path}: found {found}; expected two, [at the low end, at the high end]"
        problems.append(node.problem(message))
        return None
    ends = collected(problems, lambda: [check(item, value) for value in node.items])
    if ends is None:
        return None
    low, high = ends
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
