"""What is wrong with a foreign robot: what can be mended is mended and noted, the rest is refused.

Inertia tensors, limits and servos of a URDF are often what an exporter put there for want of a
number. The length of a leg is the measure: nothing of a robot spins like a body larger than that.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitlab.model.foreign.anatomy import Legs, lines_of, roles
from gaitlab.model.foreign.meshes import MeshFault, sentences, vertices_of_all
from gaitlab.model.foreign.reading import LEAST_RADIUS, Bodies, Body, BodyJoint, some
from gaitlab.model.tree import box_inertia

SHORTEST_LEG, LONGEST_LEG = 0.05, 3.0  # m
LARGEST_RADIUS = 0.9  # of gyration, in leg lengths
ROUNDED = 0.01  # share by which moments that were printed with few digits may miss
LEAST_EDGE = 5e-3  # m, of a box that stands for a body
DENSITY = 1000.0  # kg/m^3, of a body without geometry
UNLIKE = 0.05  # share by which the masses of mirrored bodies may differ
LIMIT_APART = 0.02  # rad by which the limits of mirrored joints may differ
EITHER_WAY = 0.1  # a knee bends either way if the middle of its range is so near to 0, by range
UNDER_SOLE = 1e-3  # m by which other geometry may be lower than the feet's
NO_EFFORT = (0.0, 1000.0, 50_000.0)  # N m; what exporters write for want of a number
NO_VELOCITY = (0.0, 100.0)  # rad/s
ALL_ALIKE = 1.0  # N m, if every joint states it: the default of an exporter from Onshape


def mend(robot: Bodies, legs: Legs, file: Path) -> Bodies:
    """The robot with tensors that a body can have, and a note on all that a user should know.

    Args:
        robot: As it was read.
        legs: Its legs.
        file: The URDF, beside which its meshes lie.

    Raises:
        FileError: If its lengths are in no metres, or its knees contradict each other.
    """
    thigh, shank = leg_lengths(robot, legs)
    length = thigh + shank
    if not SHORTEST_LEG <= length <= LONGEST_LEG:
        raise _joint(robot, legs.left[0]).tag.wrong(
            f"from hip to ankle the legs are {length:.4g} m long; {SHORTEST_LEG:g} to "
            f"{LONGEST_LEG:g} m are expected. A URDF is in metres: mend the unit of its <origin>s"
        )
    _refuse_knees_that_contradict(robot, legs)
    faults = list[MeshFault]()
    vertices = vertices_of_all(robot, file, faults)
    bodies, replaced = [], []
    for body, corners in zip(robot.bodies, vertices, strict=True):
        if body.mass > 0.0 and not _possible(body.mass, body.inertia, length):
            replaced.append(body.name)
            body = replace(body, inertia=_replacement(body, corners, length))
        bodies.append(body)
    joints = [body.joint for body in robot.bodies if body.joint is not None]
    found: Iterable[tuple[Sequence[str], str, str, str]] = (
        (replaced, "body", "bodies",
         "an inertia that nothing of this size and mass has; that of a box around it, or of a "
         "ball of water, is taken instead"),
        ([j.name for j in joints if not np.isfinite(j.upper)], "joint", "joints",
         "no range stated, so any angle is allowed; write lower and upper into <limit>"),
        (_unlike_masses(robot, legs), "pair of leg bodies", "pairs of leg bodies",
         f"masses of left and right differ by more than {UNLIKE:.0%}; weigh them"),
        (_unlike_limits(robot, legs), "pair of leg joints", "pairs of leg joints",
         "limits of left and right are no mirror images; measure them, one of each pair is wrong"),
        (_below_the_feet(robot, legs, vertices), "body", "bodies",
         "geometry below the soles at zero angles; it may touch the ground before the feet do"),
    )  # fmt: skip
    notes = [f"{some(names, one, many)}: {text}" for names, one, many, text in found if names]
    return replace(robot, bodies=tuple(bodies), notes=(*robot.notes, *notes, *sentences(faults)))


def leg_lengths(robot: Bodies, legs: Legs) -> tuple[float, float]:
    """Hip to knee and knee to ankle of the left leg, between their pitch axes, in [m].

    A leg with other than three axes that pitch at its end is measured from its first joint to its
    last; half of that is each.
    """
    lines = lines_of(robot, legs.left)
    hip_knee_ankle = _pitching(robot, legs, legs.left)
    points = lines.points @ legs.base[[0, 2]].T  # in the sagittal plane
    if hip_knee_ankle is None:
        half = float(np.linalg.norm(points[-1] - points[0])) / 2.0
        return half, half
    hip, knee, ankle = points[list(hip_knee_ankle)]
    return float(np.linalg.norm(knee - hip)), float(np.linalg.norm(ankle - knee))


def without_servo(joint: BodyJoint, joints: Sequence[BodyJoint]) -> bool:
    """Whether effort or velocity of a joint are what an exporter writes for want of a number.

    Args:
        joint: The joint.
        joints: All of the robot.
    """
    return (
        joint.effort in NO_EFFORT
        or joint.velocity in NO_VELOCITY
        or all(other.effort == ALL_ALIKE for other in joints)
    )


def _joint(robot: Bodies, body: int) -> BodyJoint:
    joint = robot.bodies[body].joint
    assert joint is not None  # legs have no root
    return joint


def _pitching(robot: Bodies, legs: Legs, leg: Sequence[int]) -> tuple[int, int, int] | None:
    """Places in a leg of hip, knee and ankle: the last three joints that pitch."""
    letters = roles(lines_of(robot, leg).axes @ legs.base.T)
    pitching = [k for k, letter in enumerate(letters) if letter == "P"]
    return (pitching[-3], pitching[-2], pitching[-1]) if len(pitching) >= 3 else None


def _refuse_knees_that_contradict(robot: Bodies, legs: Legs) -> None:
    """An error if one knee bends forward and the other backward."""
    bends = []
    for leg in (legs.left, legs.right):
        places = _pitching(robot, legs, leg)
        if places is None:
            return
        knee = _joint(robot, leg[places[1]])
        middle, span = knee.lower + knee.upper, knee.upper - knee.lower
        if not np.isfinite(span) or abs(middle) <= EITHER_WAY * span:
            return
        pitch = lines_of(robot, leg).axes[places[1]] @ legs.base[1]
        bends.append((knee, bool(middle * pitch > 0.0)))
    (left, one), (right, other) = bends
    if one != other:
        ways = ["backward" if bend else "forward" for bend in (one, other)]
        raise right.tag.wrong(
            f"the knees contradict each other: by axis and limits {left.name!r} brings the shank "
            f"{ways[0]} and {right.name!r} {ways[1]}. Turn the axis of one around, or exchange "
            f"and negate its lower and upper"
        )


def _possible(mass: float, inertia: np.ndarray, leg: float) -> bool:
    """Whether anything on a robot with such legs can have this tensor (3, 3), in [kg m^2]."""
    if not np.isfinite(inertia).all():
        return False
    moments = np.linalg.eigvalsh(inertia)
    radius = np.sqrt(max(moments[2], 0.0) / mass)
    return bool(
        moments[0] > 0.0
        and moments[2] <= (moments[0] + moments[1]) * (1.0 + ROUNDED)
        and LEAST_RADIUS * (1.0 - ROUNDED) <= radius <= LARGEST_RADIUS * leg
    )


def _replacement(body: Body, vertices: np.ndarray, leg: float) -> np.ndarray:
    """Tensor of a uniform box around a body's geometry; of a ball of water if it has none.

    Shape (3, 3), about the body's own centre of mass, in [kg m^2].
    """
    if len(vertices):
        x, y, z = np.maximum(np.ptp(vertices, axis=0), LEAST_EDGE)
        box = np.diag(box_inertia(body.mass, (float(x), float(y), float(z))))
        if _possible(body.mass, box, leg):
            return box
    radius = max((3.0 * body.mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0), LEAST_EDGE)
    return 0.4 * body.mass * radius**2 * np.eye(3)


def _unlike_masses(robot: Bodies, legs: Legs) -> list[str]:
    names = []
    for pair in zip(legs.left, legs.right, strict=True):
        left, right = (robot.bodies[k] for k in pair)
        if abs(left.mass - right.mass) > UNLIKE * max(left.mass, right.mass):
            names.append(f"{left.name} {left.mass:.4g} kg, {right.name} {right.mass:.4g} kg")
    return names


def _unlike_limits(robot: Bodies, legs: Legs) -> list[str]:
    """Pairs of joints whose ranges do not mirror.

    What turns by an angle about (x, y, z), in the base's frame, turns in the mirror about
    (-x, y, -z) by the same.
    """
    names = []
    axes = [lines_of(robot, leg).axes @ legs.base.T for leg in (legs.left, legs.right)]
    alike = np.sum(axes[0] * [-1.0, 1.0, -1.0] * axes[1], axis=1) > 0.0
    for k, pair in enumerate(zip(legs.left, legs.right, strict=True)):
        left, right = (_joint(robot, body) for body in pair)
        image = (right.lower, right.upper) if alike[k] else (-right.upper, -right.lower)
        if not np.allclose((left.lower, left.upper), image, rtol=0.0, atol=LIMIT_APART):
            names.append(f"{left.name} and {right.name}")
    return names


def _below_the_feet(robot: Bodies, legs: Legs, vertices: Sequence[np.ndarray]) -> list[str]:
    """Bodies other than the feet with geometry below that of the feet at zero angles."""
    position, rotation = robot.at_zero
    heights = {
        k: float(((position[k] + own @ rotation[k].T) @ legs.base[2]).min())
        for k, own in enumerate(vertices)
        if len(own)
    }
    feet = {legs.left[-1], legs.right[-1]}
    soles = [heights[foot] for foot in feet if foot in heights]
    if not soles:
        return []
    lowest = min(soles) - UNDER_SOLE
    return [robot.bodies[k].name for k, at in heights.items() if at < lowest]
