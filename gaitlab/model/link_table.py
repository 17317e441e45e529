"""Links of a robot from a table: a CSV file beside the robot's own, a row a link.

Columns that are read here:
    limb: Rows of one limb stand together; a `leg` and an `arm` come twice, left and right.
    link, parent: Names without the side. Only the trunk has no parent.
    joint, axis, lower_deg, upper_deg: The joint that carries the link, and the left one's limits;
        `lower_rad` and `upper_rad` where they are given so.
    servo: Its type, a file in `gaitlab/servos`; empty for a joint that only follows.
    mass_kg: Read by the robot, for instance with `shares`.
    source: Where the numbers of the row come from; for the reader.
Where links are and how large they look follows from a robot's lengths and is given as shapes.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from math import fsum, radians
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, cast

from gaitlab.model.tree import Axis, Box, Joint, Link, Vector

Side: TypeAlias = Literal["left", "right"]
Row: TypeAlias = Mapping[str, str]
Table: TypeAlias = tuple[Row, ...]
SIDES: tuple[Side, Side] = ("left", "right")
PAIRED = ("leg", "arm")  # limbs that come left and right
HERE: Vector = (0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """Where a link hangs and its box; of a leg or an arm, the left one's.

    Attributes:
        origin: Joint frame in the parent's frame, in [m].
        size: Edge lengths of the box, in [m].
        centre: Its centre in the link frame, in [m].
    """

    origin: Vector
    size: Vector
    centre: Vector = HERE


def below(distance: float) -> Vector:
    """A point straight below the origin, in [m]."""
    return (0.0, 0.0, -distance)


def read_table(file: Path) -> Table:
    """Rows of a CSV file by the names of its columns."""
    return tuple(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


def shares(table: Iterable[Row], mass: float) -> dict[str, float]:
    """Masses of links in the table's shares of a robot's mass, in [kg]; names without sides."""
    rows = {row["link"]: row for row in table}
    masses = {name: float(row["mass_kg"]) for name, row in rows.items()}
    total = fsum(masses[name] * (1 + (row["limb"] in PAIRED)) for name, row in rows.items())
    return {name: own * mass / total for name, own in masses.items()}


def links(
    table: Sequence[Row], shapes: Mapping[str, Shape], masses: Mapping[str, float]
) -> Iterator[Link]:
    """Links in the table's order, of each paired limb first the left one, then the right one.

    What is on the right mirrors what is on the left: places along y, and limits of joints that do
    not turn about y.

    Args:
        table: Rows, every parent before its children.
        shapes: By the links' names without their sides.
        masses: By the same names, in [kg].
    """
    for limb, rows in groupby(table, key=lambda row: row["limb"]):
        chain = list(rows)
        own = {row["link"] for row in chain}
        for side in SIDES if limb in PAIRED else (None,):
            for row in chain:
                name = row["link"]
                parent = _sided(row["parent"], side if row["parent"] in own else None)
                yield _link(row, side, parent, shapes[name], masses[name])


def _link(row: Row, side: Side | None, parent: str, shape: Shape, mass: float) -> Link:
    origin, size, centre = shape
    if side == "right":
        origin, centre = _mirrored(origin), _mirrored(centre)
    return Link(
        name=_sided(row["link"], side),
        parent=parent or None,
        origin=origin,
        joint=_joint(row, side) if parent else None,
        mass=mass,
        box=Box(size=size, centre=centre),
    )


def _joint(row: Row, side: Side | None) -> Joint:
    axis = cast(Axis, row["axis"])
    lower, upper = _limit(row, "lower"), _limit(row, "upper")
    if side == "right" and not turns_about_y(axis):
        lower, upper = -upper, -lower
    name = _sided(row["joint"], side)
    return Joint(name=name, axis=axis, lower=lower, upper=upper, servo=row["servo"] or None)


def _limit(row: Row, which: str) -> float:
    in_degrees = row.get(f"{which}_deg")
    return radians(float(in_degrees)) if in_degrees else float(row[f"{which}_rad"])


def turns_about_y(axis: Axis) -> bool:
    """Whether left and right joints about an axis turn alike, and do not mirror each other."""
    return axis in ("y", "-y")


def _sided(name: str, side: Side | None) -> str:
    return f"{side}_{name}" if side else name


def _mirrored(left: Vector) -> Vector:
    x, y, z = left
    return (x, 0.0 - y, z)
