"""One stance of a point mass on massless legs."""

from __future__ import annotations

import json
from math import cos
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.gaits.biped import Gait
from gaitlab.kinematics.belt_leg import (
    ankle_position,
    belt_torques,
    effort,
    joint_torques,
    segment_angles,
    stance_effort,
)

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "biped.json").read_text())
MODEL = GOLDEN["stance_model_massless_legs"]
LEG = {"mass": MODEL["params"]["M"], "segment": MODEL["params"]["l"]}
TIME = np.linspace(0.0, 2.0, 8001)  # s, one stance of 2 t_f
DT = TIME[1]


def straight() -> np.ndarray:
    """Thigh and shank of the leg that supports the first full stride."""
    return Gait(stand_time=0.0, full_strides=1).joint_motion(1.0 + TIME).position[:, 1]


def bent(fraction: float) -> np.ndarray:
    hips = MODEL["params"]["S"] * (TIME / 2.0 - 0.5)
    ankle = np.stack([-hips, np.full_like(hips, -2.0 * LEG["segment"] * fraction)], axis=-1)
    return segment_angles(ankle, LEG["segment"])


def hip_acceleration(angles: np.ndarray) -> np.ndarray:
    hips = -ankle_position(angles, LEG["segment"])
    return np.gradient(np.gradient(hips, DT, axis=0), DT, axis=0)


@pytest.mark.parametrize("name", [name for name in MODEL if name != "params"])
def test_a_stance_costs_what_the_reference_says(name: str) -> None:
    wanted = MODEL[name]
    angles = straight() if name == "straight" else bent(float(name[-4:].replace("_", ".")))
    found = stance_effort(angles, hip_acceleration(angles), DT, **LEG)
    numbers = [found.belts.peak, found.belts.work, found.belts.heat]
    numbers += [found.joints.peak, found.joints.work, found.joints.heat]
    names = ("peak_t1", "belt_pos_work", "belt_t2", "peak_th", "serial_pos_work", "serial_t2")
    expected = [wanted[key] for key in names]
    expected[3] = max(wanted["peak_th"], wanted["peak_tk"])
    np.testing.assert_allclose(numbers, expected, rtol=0.01)


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_the_motors_give_the_power_that_the_point_mass_takes(numbers: list[float]) -> None:
    angles, speed = np.array([numbers[:2]]), np.array([numbers[2:]])
    acceleration = np.array([[0.7, -1.3]])
    torque = belt_torques(angles, acceleration, **LEG)
    ahead = ankle_position(angles + 1e-6 * speed, LEG["segment"])
    back = ankle_position(angles - 1e-6 * speed, LEG["segment"])
    hips = -(ahead - back) / 2e-6
    force = LEG["mass"] * (acceleration + np.array([0.0, 9.81]))
    assert float((torque * speed).sum()) == pytest.approx(float((force * hips).sum()), abs=1e-6)


def test_standing_on_a_straight_upright_leg_costs_nothing() -> None:
    torque = belt_torques(np.zeros((1, 2)), np.zeros((1, 2)), **LEG)
    np.testing.assert_allclose(torque, 0.0, atol=1e-12)


def test_motors_in_the_joints_do_the_work_of_the_belt_motors() -> None:
    belt, speed = np.random.default_rng(5).normal(size=(2, 20, 2))
    relative = np.column_stack([speed[:, 0], speed[:, 1] - speed[:, 0]])
    work = (joint_torques(belt) * relative).sum(axis=1)
    np.testing.assert_allclose(work, (belt * speed).sum(axis=1), atol=1e-12)


def test_a_rise_on_straightening_legs_costs_at_least_the_lift() -> None:
    angles = straight()
    found = stance_effort(angles, hip_acceleration(angles), DT, **LEG)
    lift = 2.0 * LEG["segment"] * (1.0 - cos(angles[0, 0]))
    assert found.belts.work > LEG["mass"] * 9.81 * lift


def test_braking_motors_give_nothing_back() -> None:
    torque, speed = np.ones((11, 1)), -np.ones((11, 1))
    assert effort(torque, speed, 0.1).work == 0.0
    assert effort(torque, -speed, 0.1).work == pytest.approx(1.0)
