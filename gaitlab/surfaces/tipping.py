"""How firmly a sole on a pile stands against tipping, and whether that is enough.

A sole of area A that stands on m equal supports at x_i about its centre, pressed to a gap h and
turned by a small angle a, meets the moment M(a) = (A/m) sum p(h + x_i a) x_i of the pile law p.
With K = -A p'(h), the stiffness below the whole sole, its slope at a = 0 is

    -dM/da = K mean(x_i^2)

so that what counts besides the pile is how the supports are spread: K L^2/4 for studs in the
corners of a sole of length L, K L^2/7.2 for four equal rows (at L/2 and L/6 on either side), and
K L^2/12 for a pressure that is the same everywhere. A body of weight W whose centre of mass is h_c
over the sole falls by itself unless this slope exceeds W h_c.

The ankle's servo yields too. At rest a proportional controller turns a position error e into the
torque K_s e up to its limit, with K_s = gain x stall torque / no-load speed (`servos.law`), so that
a moment turns sole and ankle one after the other: 1/K = 1/K_ground + 1/K_s. With both feet down at
half the load each their stiffnesses add; in roll one sole sinks and the other rises by half the
stance width b for each radian, which adds 2 k (b/2)^2 = k b^2 / 2 for the vertical stiffness k
below one sole at half the load. Hips and knees are held stiff, which flatters the robot; the
friction between blades is left out, and a sole that lifts off on one side holds less. All derived
here but for the pile law (`pile`) and the motor's.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.model.soles import Sole
from gaitlab.surfaces.surface import FibreMat, RigidFloor, SoftLayer, Surface, TuftedPile

Support = Literal["flat", "studs", "uniform"]
Axis = Literal["x", "y"]  # along which supports move: x in pitch, y in roll
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


def mean_square(sole: Sole, support: Support, axis: Axis) -> float:
    """Mean square distance of the supports from the sole's centre along x or y, in [m^2]."""
    if support == "uniform":
        return (sole.length if axis == "x" else sole.width) ** 2 / 12.0
    points = replace(sole, kind=support).supports()[:, 0 if axis == "x" else 1]
    return float(np.var(points))


def tipping_stiffness(
    surface: Surface, sole: Sole, load: float, support: Support, axis: Axis
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


def in_series(*stiffnesses: float) -> float:
    """Stiffness of springs that one moment turns one after the other, each above zero."""
    return 1.0 / compliance if (compliance := sum(1.0 / k for k in stiffnesses)) else inf


def tipping_ratio(
    surface: Surface,
    sole: Sole,
    *,
    weight: float,
    com_height: float,
    support: Support,
    axis: Axis,
    servo: float = inf,
    stance_width: float | None = None,
) -> float:
    """Tipping stiffness over W h_c; below 1 a robot that moves nothing falls.

    Args:
        surface: The ground.
        sole: The sole.
        weight: W, in [N].
        com_height: h_c, centre of mass over the sole, in [m].
        support: How the sole stands.
        axis: `x` for pitch, `y` for roll.
        servo: Stiffness of the ankle's servo, in [N m/rad]; by default it does not yield.
        stance_width: Between the centres of both soles, in [m]; None for standing on one foot.
    """
    feet = 1 if stance_width is None else 2
    load = weight / feet
    foot = in_series(tipping_stiffness(surface, sole, load, support, axis), servo)
    stiffness = feet * foot
    if stance_width is not None and axis == "y":
        stiffness += settled(surface, sole, load).stiffness * stance_width**2 / 2.0
    return stiffness / (weight * com_height)


class Tilted(NamedTuple):
    """A plate that a load presses and a moment turns.

    Attributes:
        sink: Of its centre below the top of the pile, in [m].
        angle: In [rad]; NaN where the ground holds no such moment.
    """

    sink: float
    angle: float


STRIPS = 200  # of a plate, each of even pressure
STEEPEST = 0.5  # rad; a plate that leans more has slipped off its load


def tilted(
    surface: TuftedPile | FibreMat, sole: Sole, load: float, moment: float, axis: Axis
) -> Tilted:
    """How a stiff plate of a sole's size rests under a load through its centre and a moment.

    The law of the pile below every strip of it, lifted off where the gap exceeds the pile; angles
    are searched for up to where the restoring moment is largest.

    Args:
        surface: The ground.
        sole: Length and width of the plate.
        load: In [N].
        moment: In [N m].
        axis: `x` to turn it along its length, `y` along its width.
    """
    span = sole.length if axis == "x" else sole.width
    law, area = surface.law(), sole.length * sole.width
    x = ((np.arange(STRIPS) + 0.5) / STRIPS - 0.5) * span

    def rest(angle: float) -> tuple[float, float]:
        """Gap below the centre that carries the load, and the restoring moment there."""
        low, high = -span * angle, law.height + span * angle
        for _ in range(60):
            middle = 0.5 * (low + high)
            carried = area * float(np.mean(law.pressure(middle + angle * x)))
            low, high = (middle, high) if carried > load else (low, middle)
        pressure = law.pressure(low + angle * x)
        return low, -area * float(np.mean(pressure * x))

    angles = np.linspace(0.0, STEEPEST, 51)
    moments = [rest(float(angle))[1] for angle in angles]
    reached = next((i for i, held in enumerate(moments) if held >= moment), None)
    if reached is None:
        return Tilted(law.height - rest(0.0)[0], nan)
    low, high = float(angles[max(0, reached - 1)]), float(angles[reached])
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rest(middle)[1] < moment else (low, middle)
    return Tilted(law.height - rest(high)[0], high)
