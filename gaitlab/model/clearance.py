"""How far a robot's two lower legs are apart, and which of their links can meet.

Links are boxes, a foot the plate of its sole. The gap of two boxes is their largest separation
along the fifteen axes that can part them, the faces' normals and the edges' cross products
[Gottschalk1996]. Where faces or edges lie opposite one another it is the distance; from corner to
corner it is less; overlapping boxes have minus the depth by which one of them would have to move.

References:
    Gottschalk1996: Gottschalk, Lin, Manocha, OBBTree: A Hierarchical Structure for Rapid
        Interference Detection, SIGGRAPH 1996.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.kinematics.compiled import njit
from gaitlab.model.gait import changes
from gaitlab.model.robot import Robot
from gaitlab.model.tree import Box, LinkPoses, Tree

PLATE = 0.012  # m, thickness of a sole's plate
KNEE = 0.4  # of the way from hip to ankle, beyond which a leg's links are its lower leg
TOUCHING = 1e-6  # m, by which commanded boxes may overlap
APART = 5e-3  # m between links of a robot that are to collide with each other at all
HALVINGS = 40  # of a metre, to less than a nanometre


class LowerLegs(NamedTuple):
    """Links that collide with those of the other leg, as indices into the tree's links.

    Attributes:
        left: Those of the left leg, its foot among them.
        right: Those of the right leg.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]


def lower_legs(robot: Robot) -> LowerLegs:
    """What lies below the knees, and all that hangs on it."""
    left, right = (_lower_leg(robot.tree, foot) for foot in robot.feet)
    return LowerLegs(left, right)


def _lower_leg(tree: Tree, foot: str) -> tuple[int, ...]:
    chain = [tree.index(foot)]
    while (parent := tree.links[chain[-1]].parent) is not None:
        chain.append(tree.index(parent))
    chain.reverse()  # trunk first
    steps = [float(np.linalg.norm(tree.links[k].origin)) for k in chain]
    # The way down a leg begins behind the first step from the trunk, which goes to the hip.
    way = np.cumsum([0.0, 0.0, *steps[2:]])
    lower = {k for k, down in zip(chain, way, strict=True) if down > KNEE * way[-1]}
    for k, link in enumerate(tree.links):
        if link.parent is not None and tree.index(link.parent) in lower:
            lower.add(k)
    return tuple(sorted(lower | {chain[-1]}))


def shape_of(robot: Robot, link: int) -> Box:
    """Box of a link for contact with other links: a foot's is the plate of its sole."""
    found = robot.tree.links[link]
    if found.name not in robot.feet:
        return found.box
    sole = robot.sole
    x, y, z = sole.centre_of(robot.feet.index(found.name))
    thickness = min(PLATE, 0.5 * sole.height)
    return Box(size=(sole.length, sole.width, thickness), centre=(x, y, z + 0.5 * thickness))


def legs_gap(robot: Robot, poses: LinkPoses) -> np.ndarray:
    """Smallest gap of the two lower legs at each instant, in [m]. Shape (n,)."""
    return _smallest_gap(robot, poses, *lower_legs(robot))


def _smallest_gap(
    robot: Robot, poses: LinkPoses, a: Sequence[int], b: Sequence[int], most: float = np.inf
) -> np.ndarray:
    """Smallest gap of any of the links a to any of the links b, in [m]. Shape (n,).

    Gaps of `most` and more are not told apart: it stands for all of them.
    """
    position, rotation = (np.ascontiguousarray(np.moveaxis(part, 0, -1)) for part in poses)
    return _gaps(position, rotation, _boxes(robot, a), _boxes(robot, b), most)


class _Boxes(NamedTuple):
    """Links, and centres in their frames and half edges of their boxes, in [m]. (m,), (m, 3) x 2"""

    link: np.ndarray
    centre: np.ndarray
    half: np.ndarray


def _boxes(robot: Robot, links: Sequence[int]) -> _Boxes:
    shapes = [shape_of(robot, link) for link in links]
    centres, sizes = np.array([s.centre for s in shapes]), np.array([s.size for s in shapes])
    return _Boxes(np.array(links), centres, 0.5 * sizes)


@njit
def _gaps(
    position: np.ndarray, rotation: np.ndarray, a: _Boxes, b: _Boxes, most: float
) -> np.ndarray:
    """Those of `_smallest_gap`; positions (links, 3, n), rotations (links, 3, 3, n)."""
    count_a, count_b = len(a.link), len(b.link)
    balls = np.empty((count_a, count_b))  # sum of the radii of the balls around two boxes
    for i in range(count_a):
        for j in range(count_b):
            balls[i, j] = np.sqrt(np.sum(a.half[i] ** 2)) + np.sqrt(np.sum(b.half[j] ** 2))
    at_a, turned_a = np.empty((count_a, 3)), np.empty((count_a, 3, 3))
    at_b, turned_b = np.empty((count_b, 3)), np.empty((count_b, 3, 3))
    apart, turn = np.empty(3), np.empty((3, 3))
    found = np.empty(position.shape[-1])
    for k in range(len(found)):
        _place(position, rotation, a, k, at_a, turned_a)
        _place(position, rotation, b, k, at_b, turned_b)
        smallest = most
        for i in range(count_a):
            for j in range(count_b):
                distance = 0.0
                for axis in range(3):
                    apart[axis] = at_b[j, axis] - at_a[i, axis]
                    distance += apart[axis] ** 2
                if np.sqrt(distance) - balls[i, j] < smallest:  # balls may be nearer than that
                    gap = _separation(
                        apart, turned_a[i], a.half[i], turned_b[j], b.half[j], smallest, turn
                    )
                    smallest = min(smallest, gap)
        found[k] = smallest
    return found


@njit(inline="always")
def _place(
    position: np.ndarray, rotation: np.ndarray, boxes: _Boxes, k: int,
    at: np.ndarray, turned: np.ndarray,
) -> None:  # fmt: skip
    """Fill in where boxes are at instant k, and how they are turned."""
    for number, link in enumerate(boxes.link):
        for row in range(3):
            moved = 0.0
            for column in range(3):
                part = rotation[link, row, column, k]
                turned[number, row, column] = part
                moved += part * boxes.centre[number, column]
            at[number, row] = position[link, row, k] + moved


@njit(inline="always")
def _separation(
    apart: np.ndarray, ra: np.ndarray, a: np.ndarray, rb: np.ndarray, b: np.ndarray,
    enough: float, turn: np.ndarray,
) -> float:  # fmt: skip
    """Largest separation of two boxes along an axis, in [m]; negative where they overlap.

    Once it is known to be `enough` it is not looked for any further. Writes to `turn`, (3, 3).
    """
    best = -np.inf
    for i in range(3):
        reach, along = a[i], 0.0
        for j in range(3):
            turn[i, j] = ra[0, i] * rb[0, j] + ra[1, i] * rb[1, j] + ra[2, i] * rb[2, j]
            reach += b[j] * abs(turn[i, j])
            along += ra[j, i] * apart[j]
        best = max(best, abs(along) - reach)
        if best >= enough:
            return best
    for j in range(3):
        reach, along = b[j], 0.0
        for i in range(3):
            reach += a[i] * abs(turn[i, j])
            along += apart[i] * rb[i, j]
        best = max(best, abs(along) - reach)
        if best >= enough:
            return best
    offset = (
        ra[0, 0] * apart[0] + ra[1, 0] * apart[1] + ra[2, 0] * apart[2],
        ra[0, 1] * apart[0] + ra[1, 1] * apart[1] + ra[2, 1] * apart[2],
        ra[0, 2] * apart[0] + ra[1, 2] * apart[1] + ra[2, 2] * apart[2],
    )
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            sine = np.sqrt(max(1.0 - turn[i, j] ** 2, 0.0))
            if sine < 1e-6:  # parallel edges part along a face's normal
                continue
            along = offset[i2] * turn[i1, j] - offset[i1] * turn[i2, j]
            reach = a[i1] * abs(turn[i2, j]) + a[i2] * abs(turn[i1, j])
            reach += b[j1] * abs(turn[i, j2]) + b[j2] * abs(turn[i, j1])
            best = max(best, (abs(along) - reach) / sine)
            if best >= enough:
                return best
    return best


def require_apart(robot: Robot, joints: np.ndarray, dt: float) -> None:
    """Refuse joint positions in which the lower legs overlap.

    Args:
        robot: The robot.
        joints: Commanded positions of all joints over time, in [rad]. Shape (n, joints).
        dt: Time between two of them, in [s].

    Raises:
        Infeasible: Names the first such instant and the depth, and the deepest.
    """
    instants = changes(joints).first
    gaps = _commanded_gaps(robot, joints[instants], most=-TOUCHING)
    over = np.flatnonzero(gaps < -TOUCHING)
    if not len(over):
        return
    tick, worst = int(instants[over[0]]), int(np.argmin(gaps))
    raise Infeasible(
        limb="lower legs",
        tick=tick,
        reason=(
            f"the gait has them overlap by {_sideways(robot, joints[tick]):.1f} mm {tick * dt:.2f} "
            f"s after the start, and by {_sideways(robot, joints[instants[worst]]):.1f} mm at "
            f"{instants[worst] * dt:.2f} s; widen step_width or the hips, or narrow the soles"
        ),
    )


def _sideways(robot: Robot, joints: np.ndarray) -> float:
    """By how much a leg of an overlapping pair has to move sideways to be free, in [mm]."""
    legs, poses = lower_legs(robot), _posed(robot, joints[None])
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        shift, moved = 0.5 * (low + high), poses.position.copy()
        moved[:, legs.right, 1] -= shift
        apart = legs_gap(robot, LinkPoses(moved, poses.rotation))[0] >= 0.0
        low, high = (low, shift) if apart else (shift, high)
    return 1e3 * high


def _posed(robot: Robot, joints: np.ndarray, wanted: Iterable[int] | None = None) -> LinkPoses:
    """Poses of links for joint positions over time, the trunk at the origin."""
    n = len(joints)
    upright = np.broadcast_to(np.eye(3), (n, 3, 3))
    return robot.tree.poses(np.zeros((n, 3)), upright, joints, wanted)


def _commanded_gaps(robot: Robot, joints: np.ndarray, most: float = np.inf) -> np.ndarray:
    left, right = lower_legs(robot)
    return _smallest_gap(robot, _posed(robot, joints, left + right), left, right, most)


def links_apart(robot: Robot, joints: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of links, neither of which carries the other, whose boxes are apart in a pose.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
    """
    tree, count, poses = robot.tree, len(robot.tree.links), _posed(robot, joints[None])
    return [
        (a, b)
        for a in range(count)
        for b in range(a + 1, count)
        if tree.links[b].parent != tree.links[a].name
        and _smallest_gap(robot, poses, [a], [b])[0] > APART
    ]


def legs_beside(robot: Robot, joints: np.ndarray) -> bool:
    """Whether a plane across y parts the lower legs in a pose; if not, they may still be apart.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
    """
    left, right = lower_legs(robot)
    position, rotation = (part[0] for part in _posed(robot, joints[None], left + right))

    def ends(links: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        boxes = _boxes(robot, links)
        across = rotation[list(links), 1]
        middle = position[list(links), 1] + np.sum(across * boxes.centre, axis=-1)
        half = np.sum(np.abs(across) * boxes.half, axis=-1)
        return middle - half, middle + half

    return bool(ends(left)[0].min() >= ends(right)[1].max())


def require_own_space(robot: Robot) -> None:
    """Refuse a robot whose lower legs overlap when all its joints are at zero.

    Raises:
        WrongValue: Says by how much.
    """
    joints = np.zeros(len(robot.tree.joints))
    if legs_beside(robot, joints):
        return  # so do nearly all robots, which then need no compiled code to be read
    if _commanded_gaps(robot, joints[None])[0] < -TOUCHING:
        raise WrongValue(
            f"the lower legs of the robot {robot.name!r} overlap by {_sideways(robot, joints):.1f} "
            "mm when it stands with all joints at zero; set its hips wider apart or make its soles "
            "narrower"
        )
