"""Where a foreign robot has its legs: found by geometry, never by names.

Two legs are two chains of joints that hang on one body and mirror each other in a plane. Axes are
compared as lines, since a joint may be drawn anywhere on its own. Names only say which of two
mirrored legs is the left one, and where they say nothing the positive side of the plane is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gaitlab.errors import FileError, Problem
from gaitlab.model.foreign.reading import Bodies
from gaitlab.plugins import suggestion

SHORTEST = 4  # joints of a chain that could be a leg
USUAL = (5, 6)
ANGLE = 0.2  # rad by which mirrored axes may differ
APART = 0.004  # m by which mirrored lines may be apart, beside a share of the chain's extent
APART_SHARE = 0.05
MISFITS = 0.25  # share of the joints that may not mirror
LOWEST = 0.02  # m; pairs that end so near to the lowest one are candidates
LATERAL = 0.9  # of an axis along the lateral one, from which on its joint pitches
ALONG = 0.3  # of an axis along a plane's normal, below which its line has a place across the plane
LEFT = re.compile(r"(^|[^a-z])l([^a-z]|$)|left", re.IGNORECASE)
RIGHT = re.compile(r"(^|[^a-z])r([^a-z]|$)|right", re.IGNORECASE)


class AxisLines(NamedTuple):
    """Axes of joints at zero angles: unit vectors (n, 3), and a point on each (n, 3), in [m]."""

    axes: np.ndarray
    points: np.ndarray


class Pair(NamedTuple):
    """Two chains of bodies and how well they mirror.

    Attributes:
        first: Places of the bodies of one chain, from above.
        second: Of the other.
        normal: Unit vector across the plane, in the root's frame. Shape (3,).
        offset: Distance of the plane from the root's origin along it, in [m].
        misfits: Joints whose axes do not mirror.
        apart: Largest distance of mirrored lines among those that do, in [m].
        foot_height: Of the lower of the last two joints, in the root's frame, in [m].
    """

    first: tuple[int, ...]
    second: tuple[int, ...]
    normal: np.ndarray
    offset: float
    misfits: int
    apart: float
    foot_height: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Legs:
    """The two legs of a robot.

    Attributes:
        left: Places of the bodies of the left leg, from the hip down.
        right: Of the right one.
        pelvis: Place of the body that both hang on.
        base: Rows are forward, left and up in the root's frame. Shape (3, 3).
        middle: A point of the mirror plane in the root's frame, in [m]. Shape (3,).
        apart: Largest distance of mirrored axes, in [m].
        named: Joints and feet whose names say the side that was found, of those that say one.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]
    pelvis: int
    base: np.ndarray
    middle: np.ndarray
    apart: float
    named: tuple[int, int]


def find_legs(
    robot: Bodies, file: Path, *, feet: tuple[str, str] | None = None, forward: str | None = None
) -> Legs:
    """The two legs.

    Args:
        robot: Bodies of the URDF.
        file: The URDF.
        feet: Names of the left and the right foot link, where geometry is not to decide.
        forward: Axis of the root link that points ahead, `x` or `-y` for instance, likewise.

    Raises:
        FileError: If no two chains mirror each other; names the nearest. If no link is called so.
    """
    normals = np.eye(3) if forward is None else _lateral(forward)[None]
    if feet is not None:
        first, second = (_chain_to(robot, link, file) for link in feet)
        shared = sum(a == b for a, b in zip(first, second, strict=False))
        first, second = first[shared:], second[shared:]
        if not len(first) == len(second) >= SHORTEST:
            message = (
                f"the legs to {feet[0]} and {feet[1]} have {len(first)} and {len(second)} joints; "
                f"as many on both sides are expected, at least {SHORTEST}"
            )
            raise FileError([Problem(file=file, line=None, column=None, message=message)])
        fits = [_mirrored(robot, first, second, normal) for normal in normals]
        return _sided(robot, min(fits, key=lambda p: (p.misfits, p.apart)), first, forward)
    pairs = list(_pairs(robot, normals))
    found = [pair for pair in pairs if pair.misfits <= MISFITS * len(pair.first)]
    if not found:
        raise FileError([Problem(file=file, line=None, column=None, message=_none(robot, pairs))])
    lowest = min(pair.foot_height for pair in found)
    near = [pair for pair in found if pair.foot_height <= lowest + LOWEST]
    best = min(near, key=lambda p: (len(p.first) not in USUAL, p.misfits, -len(p.first), p.apart))
    return _sided(robot, best, None, forward)


def _lateral(forward: str) -> np.ndarray:
    """The left of what points forward along an axis of the root."""
    ahead = np.eye(3)["xyz".index(forward[-1])] * (-1.0 if forward.startswith("-") else 1.0)
    return np.cross(np.array([0.0, 0.0, 1.0]), ahead)


def _chain_to(robot: Bodies, link: str, file: Path) -> tuple[int, ...]:
    """From the root down to the body of a link, without the root."""
    body = next((k for k, each in enumerate(robot.bodies) if link in each.links), None)
    if body is None:
        known = suggestion(link, [name for each in robot.bodies for name in each.links])
        message = f"legs: no link is called {link!r}{known}"
        raise FileError([Problem(file=file, line=None, column=None, message=message)])
    return _way_to(robot, body)


def lines_of(robot: Bodies, chain: Sequence[int]) -> AxisLines:
    """Axes of a chain's joints in the root's frame at zero angles."""
    position, rotation = robot.at_zero
    axes = [rotation[k] @ _joint_axis(robot, k) for k in chain]
    return AxisLines(np.array(axes).reshape(-1, 3), position[list(chain)])


def roles(axes: np.ndarray) -> str:
    """What each joint of a leg does, `YRPPPR` for instance; a small letter for a slanted axis.

    Args:
        axes: In the base's frame: forward, left, up. Shape (n, 3).
    """
    letters = "RPY"
    largest = np.abs(axes).argmax(axis=1)
    clear = np.abs(axes).max(axis=1) > LATERAL
    return "".join(
        letters[k] if sure else letters[k].lower() for k, sure in zip(largest, clear, strict=True)
    )


def _joint_axis(robot: Bodies, body: int) -> np.ndarray:
    joint = robot.bodies[body].joint
    assert joint is not None  # the root is in no chain
    return joint.axis


def _chains(robot: Bodies) -> list[tuple[int, ...]]:
    """From the root down to each body that carries no other; without the root."""
    parents = {body.parent for body in robot.bodies}
    chains = list[tuple[int, ...]]()
    for leaf in range(1, len(robot.bodies)):
        if leaf in parents:
            continue
        chains.append(_way_to(robot, leaf))
    return chains


def _way_to(robot: Bodies, body: int) -> tuple[int, ...]:
    """From the root down to a body, without the root."""
    chain = list[int]()
    while body > 0:
        chain.insert(0, body)
        body = robot.bodies[body].parent
    return tuple(chain)


def _pairs(robot: Bodies, normals: np.ndarray) -> Iterator[Pair]:
    """Every two chains of equal length below what they share, in the plane that fits them best."""
    for one, other in combinations(_chains(robot), 2):
        shared = sum(a == b for a, b in zip(one, other, strict=False))
        first, second = one[shared:], other[shared:]
        if len(first) == len(second) >= SHORTEST:
            fits = [_mirrored(robot, first, second, normal) for normal in normals]
            yield min(fits, key=lambda pair: (pair.misfits, pair.apart))


def _mirrored(
    robot: Bodies, first: tuple[int, ...], second: tuple[int, ...], normal: np.ndarray
) -> Pair:
    """Two chains beside each other's mirror image."""
    a, b = lines_of(robot, first), lines_of(robot, second)
    placed = (np.abs(a.axes @ normal) < ALONG) & (np.abs(b.axes @ normal) < ALONG)
    both = (a.points + b.points) @ normal / 2.0
    offset = float(np.median(both[placed])) if placed.any() else float(np.median(both))
    axes = a.axes - 2.0 * np.outer(a.axes @ normal, normal)
    points = a.points - 2.0 * np.outer(a.points @ normal - offset, normal)
    cosine = np.abs(np.einsum("ij,ij->i", axes, b.axes))
    gap = b.points - points
    across = gap - b.axes * np.einsum("ij,ij->i", gap, b.axes)[:, None]
    apart = np.linalg.norm(across, axis=1)
    extent = np.ptp(np.vstack([a.points, b.points]), axis=0).max()
    fits = (cosine >= np.cos(ANGLE)) & (apart <= APART + APART_SHARE * extent)
    on_both_sides = np.abs((a.points - b.points) @ normal)[placed]
    if not len(on_both_sides) or on_both_sides.max() < APART:
        fits[:] = False  # both in the plane: no left and no right
    height = min(float(a.points[-1, 2]), float(b.points[-1, 2]))
    most = float(apart[fits].max()) if fits.any() else float(apart.max())
    return Pair(first, second, normal, offset, int((~fits).sum()), most, height)


def _sided(
    robot: Bodies, pair: Pair, named_left: tuple[int, ...] | None, forward: str | None
) -> Legs:
    """The pair with its left leg first: as the user says, as names say, on the positive side."""
    votes = [_votes(robot, chain) for chain in (pair.first, pair.second)]
    lead = (votes[0][0] - votes[0][1]) - (votes[1][0] - votes[1][1])
    a, b = lines_of(robot, pair.first), lines_of(robot, pair.second)
    ahead = float(np.sum((a.points - b.points) @ pair.normal))  # the first on the positive side
    first_is_left = lead > 0 if lead else ahead > 0.0
    if forward is not None:
        first_is_left = ahead > 0.0  # the normal is the left
    if named_left is not None:
        first_is_left = pair.first == named_left
    left, right = (pair.first, pair.second) if first_is_left else (pair.second, pair.first)
    lateral = pair.normal * np.sign(ahead) * (1.0 if first_is_left else -1.0)
    up = np.array([0.0, 0.0, 1.0])
    base = np.array([np.cross(lateral, up), lateral, up])
    agree = votes[0 if first_is_left else 1][0] + votes[1 if first_is_left else 0][1]
    return Legs(
        left=left,
        right=right,
        pelvis=robot.bodies[left[0]].parent,
        base=base,
        middle=pair.offset * pair.normal,
        apart=pair.apart,
        named=(agree, sum(map(sum, votes))),
    )


def _votes(robot: Bodies, chain: Sequence[int]) -> tuple[int, int]:
    """How many names of a chain's joints, and of its foot, say left and right."""
    names = [joint.name for k in chain if (joint := robot.bodies[k].joint) is not None]
    names.append(robot.bodies[chain[-1]].name)
    return sum(bool(LEFT.search(n)) for n in names), sum(bool(RIGHT.search(n)) for n in names)


def _none(robot: Bodies, pairs: Sequence[Pair]) -> str:
    """Why there are no legs."""
    chains = [
        f"{robot.bodies[chain[-1]].name} ({len(chain)} joints)"
        for chain in sorted(_chains(robot), key=len, reverse=True)[:6]
    ]
    message = f"no two chains of joints mirror each other; the longest end at {', '.join(chains)}"
    if pairs:
        near = min(pairs, key=lambda pair: (pair.misfits / len(pair.first), pair.apart))
        feet = " and ".join(robot.bodies[k[-1]].name for k in (near.first, near.second))
        message += f". Nearest are {feet}: {near.misfits} of {len(near.first)} axes do not mirror"
    return f"{message}. Name the feet: `legs: {{left: LINK, right: LINK}}`"
