"""How firmly a sole on a pile stands against tipping, and whether that is enough.

A sole of area A that stands on m equal supports at x_i about its centre, pressed to a gap h and
turned by a small angle a, meets the moment M(a) = (A/m) sum p(h + x_i a) x_i of the pile law p.
With K = -A p'(h), the stiffness below the whole sole, its slope at a = 0 is

    -dM/da = K mean(x_i^2)

so that what counts besides the pile is how the supports are spread: K L^2/4 for studs in the
corners of a sole of length L, K L^2/7.2 for four equal rows (at L/2 and L/6 on either side), and
K L^2/12 for a pressure that is the same everywhere. A body of weight W whose centre of mass is h_c
over the sole falls by itself unless this slope exceeds W h_c. Derived here; neither the friction
between blades nor the yielding of servos is in it, and a sole that lifts off on one side holds
less.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.model.soles import Sole
from gaitlab.surfaces.surface import FibreMat, RigidFloor, SoftLayer, Surface, TuftedPile

Support = Literal["flat", "studs", "uniform"]
SUPPORTS: tuple[Support, ...] = ("flat", "studs", "uniform")


class Settled(NamedTuple):
    """A sole at rest on the ground under a load.

    Attributes:
        sink: Depth below the top of the pile, in [m].
        stiffness: K, force over depth for the whole sole at that depth, in [N/m].
    """

    sink: float
    stiffness: float


def settled(surface: Surface, sole: Sole, load: float) -> Settled:
    """Where a level sole comes to rest under a load in [N], by the quasi-static law.

    A layer that is pressed to the base leaves the rest of the load to that.
    """
    match surface:
        case RigidFloor():
            return Settled(0.0, inf)
        case SoftLayer():
            return Settled(min(load / surface.stiffness, surface.height), surface.stiffness)
        case TuftedPile() | FibreMat():
            law, area = surface.law(), sole.length * sole.width
            gap = law.gap_under(load / area)
            return Settled(law.height - gap, area * float(law.stiffness(np.array(gap))))


def mean_square(sole: Sole, support: Support, axis: Literal["x", "y"]) -> float:
    """Mean square distance of the supports from the sole's centre along x or y, in [m^2]."""
    if support == "uniform":
        return (sole.length if axis == "x" else sole.width) ** 2 / 12.0
    points = replace(sole, kind=support).supports()[:, 0 if axis == "x" else 1]
    return float(np.var(points))


def tipping_stiffness(
    surface: Surface, sole: Sole, load: float, support: Support, axis: Literal["x", "y"]
) -> float:
    """Restoring moment over angle of a settled sole, in [N m/rad].

    Args:
        surface: The ground.
        sole: The sole; its own kind is not looked at.
        load: In [N].
        support: How the sole stands.
        axis: `x` for pitch, which moves the supports along x; `y` for roll.
    """
    return settled(surface, sole, load).stiffness * mean_square(sole, support, axis)


def tipping_ratio(
    surface: Surface,
    sole: Sole,
    *,
    weight: float,
    com_height: float,
    support: Support,
    axis: Literal["x", "y"],
) -> float:
    """Tipping stiffness on one foot over W h_c; below 1 a stiff robot cannot stand on it.

    Args:
        surface: The ground.
        sole: The sole.
        weight: W, in [N].
        com_height: h_c, centre of mass over the sole, in [m].
        support: How the sole stands.
        axis: `x` for pitch, `y` for roll.
    """
    return tipping_stiffness(surface, sole, weight, support, axis) / (weight * com_height)
