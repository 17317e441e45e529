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

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.errors import Infeasible, WrongValue
from gaitlab.model.compiled import njit
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
    legs = lower_legs(robot)
    boxes = [_boxes(robot, links) for links in legs]
    placed = [(poses.position[:, links], poses.rotation[:, links]) for links in map(list, legs)]
    (left, right), (a, b) = placed, boxes
    return _gaps(*map(np.ascontiguousarray, (*left, *a, *right, *b)))


def _boxes(robot: Robot, links: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Centres in the link frames and half edges of links' boxes, in [m]. Shape (links, 3) each."""
    shapes = [shape_of(robot, link) for link in links]
    return np.array([s.centre for s in shapes]), 0.5 * np.array([s.size for s in shapes])


@njit
def _gaps(
    position_a: np.ndarray, rotation_a: np.ndarray, centre_a: np.ndarray, half_a: np.ndarray,
    position_b: np.ndarray, rotation_b: np.ndarray, centre_b: np.ndarray, half_b: np.ndarray,
) -> np.ndarray:  # fmt: skip
    found = np.empty(len(position_a))
    for k in range(len(position_a)):
        smallest = np.inf
        for i in range(len(centre_a)):
            ra = rotation_a[k, i]
            pa = position_a[k, i] + ra @ centre_a[i]
            for j in range(len(centre_b)):
                rb = rotation_b[k, j]
                apart = position_b[k, j] + rb @ centre_b[j] - pa
                # Balls around the boxes: no nearer than this.
                least = (
                    np.sqrt(apart @ apart)
                    - np.sqrt(half_a[i] @ half_a[i])
                    - np.sqrt(half_b[j] @ half_b[j])
                )
                if least < smallest:
                    smallest = min(smallest, _gap(apart, ra, half_a[i], rb, half_b[j]))
        found[k] = smallest
    return found


@njit
def _gap(apart: np.ndarray, ra: np.ndarray, a: np.ndarray, rb: np.ndarray, b: np.ndarray) -> float:
    """Largest separation of two boxes along an axis, in [m]; negative where they overlap."""
    turn, offset = ra.T @ rb, ra.T @ apart
    best = -np.inf
    for i in range(3):
        reach = a[i]
        for j in range(3):
            reach += b[j] * abs(turn[i, j])
        best = max(best, abs(offset[i]) - reach)
    for j in range(3):
        reach, along = b[j], 0.0
        for i in range(3):
            reach += a[i] * abs(turn[i, j])
            along += offset[i] * turn[i, j]
        best = max(best, abs(along) - reach)
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
    # Commands are held between the gait's own instants: each is looked at once.
    changed = np.flatnonzero(np.any(np.diff(joints, axis=0) != 0.0, axis=1)) + 1
    instants = np.concatenate([[0], changed])
    gaps = _commanded_gaps(robot, joints[instants])
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


def _posed(robot: Robot, joints: np.ndarray) -> LinkPoses:
    """Poses of all links for joint positions over time, the trunk at the origin."""
    n = len(joints)
    return robot.tree.poses(np.zeros((n, 3)), np.broadcast_to(np.eye(3), (n, 3, 3)), joints)


def _commanded_gaps(robot: Robot, joints: np.ndarray) -> np.ndarray:
    return legs_gap(robot, _posed(robot, joints))


def links_apart(robot: Robot, joints: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of links, neither of which carries the other, whose boxes are apart in a pose.

    Args:
        robot: The robot.
        joints: Positions of all joints, in [rad]. Shape (joints,).
    """
    tree, count, poses = robot.tree, len(robot.tree.links), _posed(robot, joints[None])
    boxes = [_boxes(robot, [k]) for k in range(count)]
    placed = [
        (np.ascontiguousarray(poses.position[:, [k]]), np.ascontiguousarray(poses.rotation[:, [k]]))
        for k in range(count)
    ]
    return [
        (a, b)
        for a in range(count)
        for b in range(a + 1, count)
        if tree.links[b].parent != tree.links[a].name
        and _gaps(*placed[a], *boxes[a], *placed[b], *boxes[b])[0] > APART
    ]


def require_own_space(robot: Robot) -> None:
    """Refuse a robot whose lower legs overlap when all its joints are at zero.

    Raises:
        WrongValue: Says by how much.
    """
    joints = np.zeros(len(robot.tree.joints))
    if _commanded_gaps(robot, joints[None])[0] < -TOUCHING:
        raise WrongValue(
            f"the lower legs of the robot {robot.name!r} overlap by {_sideways(robot, joints):.1f} "
            "mm when it stands with all joints at zero; set its hips wider apart or make its soles "
            "narrower"
        )
