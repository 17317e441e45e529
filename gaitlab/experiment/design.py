"""A space-filling sweep: few points that cover a box of parameters evenly.

Where a grid of k parameters needs n^k cells, a Sobol' sequence or a Latin hypercube of some tens
of points varies all of them at once, each over its whole range. A scrambled Sobol' sequence,
[Owen1998], is random like any draw from the box but more even, and its first points are a sweep by
themselves: more points extend a smaller sweep. It is balanced when their number is a power of two.

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

References:
    McKay1979: McKay, Beckman and Conover, A comparison of three methods for selecting values of
        input variables in the analysis of output from a computer code, Technometrics, 1979.
    Owen1998: Owen, Scrambling Sobol' and Niederreiter-Xing points, J. of Complexity, 1998.
    Sobol1967: Sobol', On the distribution of points in a cube and the approximate evaluation of
        integrals, USSR Computational Mathematics and Mathematical Physics, 1967.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import exp, floor, log
from typing import Literal

import numpy as np

from gaitlab.documents import Node, Reader, check, read_each, read_mapping
from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment.axes import Axis
from gaitlab.experiment.parts import Parts, Value, owned
from gaitlab.experiment.search_reading import read_range
from gaitlab.experiment.study import Numbers
from gaitlab.parameters import Parameter

DIGITS = 6  # significant ones of a value, so that no library's last bit names a trial
MOST_POINTS = 65_536
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


@dataclass(frozen=True, kw_only=True)
class Follower:
    """A parameter that moves in a straight line with a swept one.

    Attributes:
        path: Dotted path.
        low: Its value where the swept one is lowest, in its own unit.
        high: Its value where the swept one is highest; may lie below `low`.
        integer: Whether only whole numbers are allowed.
    """

    path: str
    low: float
    high: float
    integer: bool = False


@dataclass(frozen=True, kw_only=True)
class SweptRange:
    """One edge of the box.

    Attributes:
        range: The swept parameter and its ends.
        followers: Parameters that move with it.
    """

    range: Numbers
    followers: tuple[Follower, ...] = ()

    @property
    def paths(self) -> tuple[str, ...]:
        """The swept path and those that move with it."""
        return (self.range.path, *(follower.path for follower in self.followers))

    def values(self, place: float) -> tuple[Value, ...]:
        """Values of the paths at a place in [0, 1) along the edge."""
        value = _at(self.range, place)
        share = (value - self.range.low) / (self.range.high - self.range.low)
        others = (_line(follower, share) for follower in self.followers)
        return (value, *others)

    def place(self, value: float) -> float:
        """Place of a value of the swept parameter along the edge, 0 at its low end."""
        ends = np.array([self.range.low, self.range.high, value], dtype=float)
        low, high, at = np.log(ends) if self.range.log else ends
        return float((at - low) / (high - low))


@dataclass(frozen=True, kw_only=True)
class Design:
    """Points spread over a box.

    Attributes:
        type: `sobol`, a scrambled Sobol' sequence [Sobol1967], or `lhs`, a Latin hypercube
            [McKay1979].
        points: How many.
        seed: Of scrambling or drawing.
        box: The swept parameters.
    """

    type: Literal["sobol", "lhs"]
    points: int
    seed: int
    box: tuple[SweptRange, ...]

    @property
    def texts(self) -> Mapping[str, str]:
        """How each path is spread, in words, by dotted path: `64 points, 3 to 4`."""
        kind = {"sobol": "Sobol' points", "lhs": "Latin hypercube points"}[self.type]
        ranges = {item.range.path: f"{self.points} {kind}, {item.range.text}" for item in self.box}
        followers = [(item.range.path, other) for item in self.box for other in item.followers]
        lines = {o.path: f"{o.low:g} to {o.high:g} with {path}" for path, o in followers}
        return {path: {**ranges, **lines}[path] for item in self.box for path in item.paths}

    def axis(self) -> Axis:
        """The points as one axis of the experiment, the swept paths before their followers'."""
        paths = tuple(path for quantity in self.box for path in quantity.paths)
        return Axis(paths=paths, rows=tuple(self._rows()))

    def _rows(self) -> Iterator[tuple[Value, ...]]:
        for places in unit_points(self.type, self.points, len(self.box), self.seed).tolist():
            pairs = zip(self.box, places, strict=True)
            yield tuple(value for quantity, place in pairs for value in quantity.values(place))


def unit_points(kind: Literal["sobol", "lhs"], points: int, across: int, seed: int) -> np.ndarray:
    """Points in the unit box. Shape (points, across)."""
    # scipy.stats takes half a second to import, which only a sweep should pay.
    from scipy.stats import qmc

    generator = np.random.default_rng(seed)
    if kind == "lhs":
        return np.asarray(qmc.LatinHypercube(across, rng=generator).random(points))
    sequence = qmc.Sobol(across, scramble=True, rng=generator)
    return np.asarray(sequence.random_base2((points - 1).bit_length())[:points])


def _at(numbers: Numbers, place: float) -> float:
    low, high = numbers.low, numbers.high
    if numbers.integer:  # each whole number, or each ratio, gets an equal share of the edge
        low, high = low - 0.5, high + 0.5
    if numbers.log:
        value = exp(log(low) + place * (log(high) - log(low)))
    else:
        value = low + place * (high - low)
    return _rounded(value, numbers.low, numbers.high, numbers.integer)


def _line(follower: Follower, share: float) -> float:
    value = follower.low + share * (follower.high - follower.low)
    low, high = sorted((follower.low, follower.high))
    return _rounded(value, low, high, follower.integer)


def _rounded(value: float, low: float, high: float, integer: bool) -> float:
    found = floor(value + 0.5) if integer else float(f"{value:.{DIGITS}g}")
    return min(max(found, low), high)


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


def _read_box(node: Node, parts: Parts) -> tuple[SweptRange, ...]:
    if not node.mapping:
        message = (
            f"design: box: found {node.found()}; expected lines of the form "
            "`robot.mass: {low: 3.0, high: 4.0}`"
        )
        raise FileError([node.problem(message)])
    return tuple(read_each(node.mapping, lambda path: _read_quantity(path, node, parts)))


def _read_quantity(path: str, box: Node, parts: Parts) -> SweptRange:
    """One edge of the box."""
    item = _known(path, box.keys[path], parts)
    followers: dict[str, Reader] = {"with": partial(_read_followers, path, parts=parts)}
    numbers, given = read_range(item, box.mapping[path], followers, EXPECTED)
    return SweptRange(range=numbers, followers=given.get("with", ()))


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
