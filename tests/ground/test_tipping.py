"""How firmly a sole stands against tipping: the closed form against the pile law itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from gaitlab.model.soles import Sole
from gaitlab.robots.eros import Robot
from gaitlab.surfaces.files import load_surface
from gaitlab.surfaces.surface import FibreMat, RigidFloor, SoftLayer, TuftedPile
from gaitlab.surfaces.tipping import (
    SUPPORTS,
    Support,
    mean_square,
    settled,
    tipping_ratio,
    tipping_stiffness,
)

SOLE: Sole = Robot().sole
WEIGHT = 3.5 * 9.81  # N
PEDESTALS = ("grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm")


def pedestal(name: str) -> TuftedPile | FibreMat:
    surface = load_surface(name)
    assert isinstance(surface, (TuftedPile, FibreMat))
    return surface


def moment(surface: TuftedPile | FibreMat, support: Support, angle: float, axis: int) -> float:
    """Restoring moment of a sole turned about its centre at its settled gap, in [N m]."""
    law, area = surface.law(), SOLE.length * SOLE.width
    gap = law.height - settled(surface, SOLE, WEIGHT).sink
    if support == "uniform":
        span = (SOLE.length, SOLE.width)[axis]
        x = (np.arange(4000) + 0.5) / 4000 * span - span / 2.0
    else:
        x = replace(SOLE, kind=support).supports()[:, axis]
        x = x - x.mean()
    return float(area * np.mean(law.pressure(gap + angle * x) * x))


@pytest.mark.parametrize("name", PEDESTALS)
@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("axis", ["x", "y"])
def test_stiffness_is_the_slope_of_the_restoring_moment(
    name: str, support: Support, axis: Literal["x", "y"]
) -> None:
    surface, turn = pedestal(name), 1e-4
    column = "xy".index(axis)
    ends = [moment(surface, support, sign * turn, column) for sign in (-1.0, 1.0)]
    slope = (ends[0] - ends[1]) / (2.0 * turn)
    expected = tipping_stiffness(surface, SOLE, WEIGHT, support, axis)
    assert slope == pytest.approx(expected, rel=2e-3)  # the law bends over 6 micrometres


@pytest.mark.parametrize("name", PEDESTALS)
def test_a_settled_sole_carries_its_load(name: str) -> None:
    surface = pedestal(name)
    law, area = surface.law(), SOLE.length * SOLE.width
    gap = law.height - settled(surface, SOLE, WEIGHT).sink
    assert area * float(law.pressure(np.array(gap))) == pytest.approx(WEIGHT, rel=1e-6)


def test_four_rows_corners_and_even_pressure_have_their_known_shares() -> None:
    length, width = SOLE.length**2, SOLE.width**2
    shares = {s: length / mean_square(SOLE, s, "x") for s in SUPPORTS}
    assert shares == pytest.approx({"flat": 7.2, "studs": 4.0, "uniform": 12.0})
    shares = {s: width / mean_square(SOLE, s, "y") for s in SUPPORTS}
    assert shares == pytest.approx({"flat": 6.0, "studs": 4.0, "uniform": 12.0})


def test_a_stiffer_layer_holds_in_proportion_and_a_floor_without_bound() -> None:
    soft = SoftLayer(friction=0.5, height=0.01, stiffness=1e4, damping=10.0)
    firm = replace(soft, stiffness=3e4)
    ratios = [
        tipping_ratio(ground, SOLE, weight=WEIGHT, com_height=0.25, support="flat", axis="x")
        for ground in (soft, firm, RigidFloor(friction=0.5))
    ]
    assert ratios[1] == pytest.approx(3.0 * ratios[0])
    assert np.isinf(ratios[2])
