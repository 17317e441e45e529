import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.kinematics.fsr import (
    averaged,
    crossings,
    fluctuation,
    foot_zmp,
    load_index,
    normalised,
    normalised_zmp,
    sensor_loads,
)
from gaitlab.robots.nao import Robot

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "nao.json").read_text())
SENSORS = np.stack([Robot().sole.sensors(foot) for foot in range(2)])
feet = pytest.mark.parametrize("foot", [0, 1], ids=["left", "right"])


def inside(foot: int, n: int) -> np.ndarray:
    """Points inside the sensors' quadrilateral: mixtures of its corners."""
    shares = np.random.default_rng(foot).dirichlet(np.ones(4), n)
    return shares @ SENSORS[foot]


@feet
def test_loads_have_the_force_as_sum_and_its_centre_as_centre(foot: int) -> None:
    centre, force = inside(foot, 500), np.linspace(0.1, 60.0, 500)
    loads = sensor_loads(force, centre, SENSORS[foot])
    assert np.all(loads >= 0.0)
    np.testing.assert_allclose(loads.sum(axis=1), force, rtol=1e-12)
    np.testing.assert_allclose(foot_zmp(loads, SENSORS[foot]), centre, atol=1e-12)


@feet
def test_a_centre_on_a_sensor_loads_that_sensor_alone(foot: int) -> None:
    loads = sensor_loads(np.full(4, 10.0), SENSORS[foot], SENSORS[foot])
    np.testing.assert_allclose(loads, 10.0 * np.eye(4), atol=1e-9)


@feet
def test_a_centre_ahead_of_all_sensors_unloads_the_rear_ones_and_keeps_the_force(foot: int) -> None:
    ahead = np.array([[0.11, SENSORS[foot][:, 1].mean()]])
    loads = sensor_loads(np.array([25.0]), ahead, SENSORS[foot])
    np.testing.assert_allclose(loads[0, 2:], 0.0, atol=1e-12)
    assert loads.sum() == pytest.approx(25.0)
    assert foot_zmp(loads, SENSORS[foot])[0, 0] == pytest.approx(0.07025)


def test_a_foot_in_the_air_reads_nothing_and_has_no_zmp() -> None:
    loads = sensor_loads(np.zeros(2), np.full((2, 2), np.nan), SENSORS[0])
    assert np.all(loads == 0.0)
    assert np.all(np.isnan(foot_zmp(loads, SENSORS[0])))


@pytest.mark.parametrize("case", GOLDEN["fsr_zmp"])
def test_foot_zmp_equals_the_reference(case: dict[str, Any]) -> None:
    sensors = SENSORS["LR".index(case["side"])]
    found = foot_zmp(np.array(case["f"], dtype=float), sensors)
    np.testing.assert_allclose(found, case["zmp_exact"], atol=1e-8)


@pytest.mark.parametrize("case", GOLDEN["normalised_printed"])
def test_normalised_equals_the_reference(case: dict[str, Any]) -> None:
    found = normalised(np.array(case["left"]), np.array(case["right"]))
    expected = np.nan if case["value"] is None else case["value"]
    np.testing.assert_allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("case", GOLDEN["load_index"])
def test_load_index_equals_the_reference(case: dict[str, Any]) -> None:
    found = load_index(np.array(case["F_left"]), np.array(case["F_right"]))
    expected = np.nan if case["value"] is None else case["value"]
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_one_foot_in_the_air_makes_the_normalised_zmp_one_or_minus_one() -> None:
    on, off = np.full((3, 4), 8.0), np.zeros((3, 4))
    np.testing.assert_allclose(normalised_zmp(on, off, SENSORS), 1.0)
    np.testing.assert_allclose(normalised_zmp(off, on, SENSORS), -1.0)


def test_normalised_stays_within_one_exactly_when_both_have_one_sign() -> None:
    left, right = np.random.default_rng(3).uniform(-0.05, 0.05, (2, 1000))
    found = np.abs(normalised(left, right))
    assert np.array_equal(found <= 1.0, left * right >= 0.0)


def test_quiet_standing_makes_the_normalised_y_singular() -> None:
    equal = np.full((1, 4), 12.0)
    centre = SENSORS.mean(axis=1)
    assert centre[0, 1] == pytest.approx(-centre[1, 1])  # the feet mirror each other across y
    assert np.isnan(normalised_zmp(equal, equal, SENSORS)[0, 1])


def test_load_index_changes_its_sign_when_the_feet_swap() -> None:
    left, right = np.random.default_rng(4).uniform(0.0, 50.0, (2, 100))
    np.testing.assert_array_equal(load_index(left, right), -load_index(right, left))


def test_one_clean_transition_an_exchange_does_not_fluctuate() -> None:
    signal = np.cos(np.pi * np.linspace(0.0, 6.0, 601))
    assert fluctuation(signal, 6.0) == pytest.approx(0.0, abs=1e-12)
    assert crossings(signal) == 6
    there_and_back = np.array([1.0, -1.0, 1.0, -1.0])
    assert fluctuation(there_and_back, 1.0) == pytest.approx(2.0)


def test_undefined_instants_and_zeros_are_left_out() -> None:
    signal = np.array([1.0, np.nan, 0.0, -1.0])
    assert fluctuation(signal, 1.0) == pytest.approx(0.0)
    assert crossings(signal) == 1


def test_averaging_keeps_the_mean_and_drops_the_rest() -> None:
    table = np.arange(22.0).reshape(11, 2)
    means = averaged(table, 5)
    assert means.shape == (2, 2)
    np.testing.assert_allclose(means.mean(axis=0), table[:10].mean(axis=0))
    np.testing.assert_array_equal(averaged(table, 1), table)
