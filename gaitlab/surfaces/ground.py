"""A pile and the sole on it as plain arrays, and what passes between them in a tick."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.model.soles import SUPPORT_RADIUS, Sole
from gaitlab.surfaces.surface import FibreMat, TuftedPile

CELLS = 128  # cells along each side before the irregularity repeats
FORCE_SHARE = 0.35  # of the robot's weight: largest plough force of one edge element
# The plough force is an explicit spring of each edge element, whose stiffness over the foot's mass
# is at most PLOUGH_RATE, the same at every step of time. Pushed sideways a foot leans on two
# elements, turned about the vertical on four; with its inertia that makes 6 times the rate, the
# worst case. Stable is what lies below 4 / dt^2. STABLE_SHARE / dt^2 binds at steps above 4 ms
# alone: 6 times it is 1.2 / dt^2, so that larger steps are stable too, with softer edges.
PLOUGH_RATE = 12_500.0  # 1/s^2
STABLE_SHARE = 0.2  # of 1 / dt^2


class Pile(NamedTuple):
    """A pile and a sole as the kernel wants them: plain floats and arrays.

    Attributes:
        law: height, exponent, p1, p2, solid height, of the pile law; SI. Shape (5,).
        loss: eta, reach of the hysteresis over pile height, its constant part in [m]. Shape (3,).
        plough: toe_catch, nap, cos and sin of its direction, force cap in [N], stiffness cap in
            [N/m]. Shape (6,).
        relaxation_time: Damping over stiffness, in [s].
        supports: Support points in the foot link frame, in [m]. Shape (m, 3).
        corners: Corners of the sole: rear right, rear left, front right, front left. Shape (4, 3).
        ball: Radius of the balls of which the supports are the lowest points, in [m].
        size: Sole length and width, in [m]. Shape (2,).
        height_field: Relative local pile height over its mean, minus one. Shape (CELLS, CELLS).
        density_field: Factor on the plough force. Shape (CELLS, CELLS).
    """

    law: np.ndarray
    loss: np.ndarray
    plough: np.ndarray
    relaxation_time: float
    supports: np.ndarray
    corners: np.ndarray
    ball: float
    size: np.ndarray
    height_field: np.ndarray
    density_field: np.ndarray


class Footprint(NamedTuple):
    """What the pile remembers of one foot.

    Attributes:
        hysteresis: Prandtl-Dahl state q of each support point. Shape (m,).
        gap: Gap of each support point at the last tick, NaN when it was clear, in [m]. Shape (m,).
        force: Plough force of each edge element, in [N]. Shape (8,).
        stiffness: Its stiffness, in [N/m]. Shape (8,).
    """

    hysteresis: np.ndarray
    gap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray


class Support(NamedTuple):
    """What the engine is to set for one foot in this tick.

    Attributes:
        active: False when the foot is clear of the pile.
        point: A point of the tangent plane, world frame, in [m].
        turn: Its orientation, xyzw.
        stiffness: Along its normal, per support point, in [N/m].
        damping: Likewise, in [N s/m].
        plough: Plough force on the foot, world x and y, in [N].
        push: The same with what takes the sideways part of a sloping plane's force away, in [N].
        torque: Torque of `push` about the foot's centre of mass, in [N m].
    """

    active: bool
    point: tuple[float, float, float]
    turn: tuple[float, float, float, float]
    stiffness: float
    damping: float
    plough: tuple[float, float]
    push: tuple[float, float]
    torque: tuple[float, float, float]


def new_footprint(supports: int) -> Footprint:
    """Memory of a foot that has not touched the pile yet."""
    return Footprint(np.zeros(supports), np.full(supports, np.nan), np.zeros(8), np.zeros(8))


def under_right_foot(pile: Pile, sole: Sole) -> Pile:
    """The same pile under the right sole, which mirrors the left one."""
    return pile._replace(
        supports=np.ascontiguousarray(sole.supports(1)),
        corners=np.ascontiguousarray(sole.corners(1)),
    )


def pile_for(
    surface: TuftedPile | FibreMat,
    sole: Sole,
    *,
    weight: float,
    foot_mass: float,
    dt: float,
    rng: np.random.Generator,
    irregularity: float = 1.0,
) -> Pile:
    """The pile under a given left sole.

    Args:
        surface: The ground.
        sole: The sole that stands on it.
        weight: Weight of the robot, in [N]; caps the plough force.
        foot_mass: Mass of a foot link, in [kg]; caps the plough stiffness.
        dt: Time step, in [s]; matters above 4 ms alone, see PLOUGH_RATE.
        rng: Source of the pile's irregularity.
        irregularity: Factor on the surface's own noise, 0 for an even lawn.
    """
    law = surface.law()
    heights, densities = _fields(rng)
    caps = (FORCE_SHARE * weight, foot_mass * min(PLOUGH_RATE, STABLE_SHARE / dt**2))
    nap = (surface.nap, np.cos(surface.nap_direction), np.sin(surface.nap_direction))
    return Pile(
        law=np.array([law.height, law.exponent, law.p1, law.p2, law.solid_height]),
        loss=np.array([surface.hysteresis, 0.05, 2e-4]),
        plough=np.array([surface.toe_catch, *nap, *caps]),
        relaxation_time=surface.relaxation_time,
        supports=np.ascontiguousarray(sole.supports()),
        corners=np.ascontiguousarray(sole.corners()),
        ball=SUPPORT_RADIUS,
        size=np.array([sole.length, sole.width]),
        height_field=irregularity * surface.height_noise * heights,
        density_field=np.exp(irregularity * surface.density_noise * densities),
    )


def _fields(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    fields = rng.standard_normal((2, CELLS, CELLS)).clip(-2.0, 2.0)
    return fields[0], fields[1]
