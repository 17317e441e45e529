"""How firmly a sole stands against tipping: the closed form against the pile law itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.model.soles import Sole
from gaitlab.robots.eros import Robot
from gaitlab.surfaces.files import load_surface
from gaitlab.surfaces.surface import FibreMat, RigidFloor, SoftLayer, TuftedPile
from gaitlab.surfaces.tipping import (
    SUPPORTS,
    Support,
    in_series,
    mean_square,
    settled,
    tilted,
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


STIFFNESSES = st.lists(st.floats(1e-3, 1e6), min_size=2, max_size=4)


@given(STIFFNESSES)
def test_springs_in_series_are_softer_than_each_and_may_change_places(springs: list[float]) -> None:
    found = in_series(*springs)
    assert found < min(springs)
    assert in_series(*reversed(springs)) == pytest.approx(found)
    assert in_series(*springs, np.inf) == pytest.approx(found)
    assert in_series(np.inf, np.inf) == np.inf


def ratio(name: str, axis: Literal["x", "y"], **given: float) -> float:
    return tipping_ratio(
        pedestal(name), SOLE, weight=WEIGHT, com_height=0.25, support="flat", axis=axis, **given
    )


@pytest.mark.parametrize("name", PEDESTALS)
@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_yielding_servo_takes_from_what_the_ground_holds(
    name: str, axis: Literal["x", "y"]
) -> None:
    ratios = [ratio(name, axis, servo=k) for k in (1.0, 50.0, 1e9)]
    assert ratios == sorted(ratios)
    assert ratios[1] < ratio(name, axis)
    assert ratios[2] == pytest.approx(ratio(name, axis), rel=1e-6)
    assert ratios[0] < 1.0 / (WEIGHT * 0.25)


@pytest.mark.parametrize("name", PEDESTALS)
def test_in_pitch_two_feet_are_two_springs_at_half_the_load(name: str) -> None:
    one = tipping_stiffness(pedestal(name), SOLE, WEIGHT / 2.0, "flat", "x")
    both = 2.0 * in_series(one, 50.0) / (WEIGHT * 0.25)
    assert ratio(name, "x", servo=50.0, stance_width=0.109) == pytest.approx(both)


@pytest.mark.parametrize("name", PEDESTALS)
def test_in_roll_two_feet_meet_what_their_sinking_apart_gives(name: str) -> None:
    """Restoring moment of two points b apart under half the weight each, by finite differences."""
    surface, width, turn = pedestal(name), 0.109, 1e-5
    law, area = surface.law(), SOLE.length * SOLE.width
    gap = law.height - settled(surface, SOLE, WEIGHT / 2.0).sink
    gaps = gap + np.array([-0.5, 0.5]) * width * turn
    forces = area * law.pressure(gaps)
    moment_at = float(forces[0] - forces[1]) * width / 2.0
    own = 2.0 * tipping_stiffness(surface, SOLE, WEIGHT / 2.0, "flat", "y")
    expected = (moment_at / turn + own) / (WEIGHT * 0.25)
    assert ratio(name, "y", stance_width=width) == pytest.approx(expected, rel=1e-3)
    assert ratio(name, "y", stance_width=width) > ratio(name, "y", stance_width=0.05)


@pytest.mark.parametrize("name", PEDESTALS)
@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_plate_tilts_as_its_stiffness_says_and_more_under_more(
    name: str, axis: Literal["x", "y"]
) -> None:
    surface = pedestal(name)
    stiffness = tipping_stiffness(surface, SOLE, WEIGHT, "uniform", axis)
    little, twice = (tilted(surface, SOLE, WEIGHT, m * stiffness, axis) for m in (1e-4, 2e-4))
    assert little.angle == pytest.approx(1e-4, rel=0.01)
    assert twice.angle == pytest.approx(2.0 * little.angle, rel=0.01)
    level = tilted(surface, SOLE, WEIGHT, 0.0, axis)
    assert level.angle == pytest.approx(0.0, abs=1e-9)
    assert level.sink == pytest.approx(settled(surface, SOLE, WEIGHT).sink, rel=1e-6)


def test_no_ground_holds_a_moment_that_lifts_the_load_over_the_edge() -> None:
    edge = WEIGHT * SOLE.length / 2.0
    assert np.isnan(tilted(pedestal("grass_50mm"), SOLE, WEIGHT, edge, "x").angle)
