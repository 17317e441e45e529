"""What a gait must give: poses for every instant, in the shapes and numbers that were asked for."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from gaitlab.errors import WrongValue
from gaitlab.gaits.eros import Gait
from gaitlab.gaits.stand import Gait as Stand
from gaitlab.model.gait import SHAPES, FeetPoses, first_step, require_feet
from gaitlab.plugins import load_class, names

COUNT = 40
INSTANTS = 0.05 * np.arange(COUNT)  # s


def feet(**changes: object) -> FeetPoses:
    return replace(Gait(step_length=0.02).feet(INSTANTS), **changes)


def test_the_shipped_gait_gives_what_is_asked_for() -> None:
    require_feet(feet(joints={"head_pan": np.zeros(COUNT)}), COUNT)


@pytest.mark.parametrize("name", SHAPES)
def test_an_array_for_other_instants_is_named_with_both_shapes(name: str) -> None:
    short = getattr(feet(), name)[:-1]
    with pytest.raises(WrongValue) as caught:
        require_feet(feet(**{name: short}), COUNT)
    for part in (name, str(short.shape), str((COUNT, *SHAPES[name]))):
        assert part in str(caught.value)


@pytest.mark.parametrize("name", sorted(set(SHAPES) - {"phase", "swing", "step_index"}))
def test_a_number_that_is_none_is_named_with_its_tick(name: str) -> None:
    broken = getattr(feet(), name).copy()
    broken[7:] = np.nan
    with pytest.raises(WrongValue, match=f"{name} at tick 7"):
        require_feet(feet(**{name: broken}), COUNT)


def test_a_joint_set_for_other_instants_is_named() -> None:
    with pytest.raises(WrongValue, match="head_pan"):
        require_feet(feet(joints={"head_pan": np.zeros(3)}), COUNT)


@pytest.mark.parametrize("given", [None, np.zeros((COUNT, 2, 3)), {"position": 1}])
def test_anything_else_is_named_by_its_type(given: object) -> None:
    with pytest.raises(WrongValue, match=type(given).__name__):
        require_feet(given, COUNT)


def test_the_first_step_is_the_first_foot_meant_to_be_in_the_air() -> None:
    swing = np.zeros((COUNT, 2), dtype=bool)
    swing[9:, 1] = True
    assert first_step(feet(swing=swing, trunk_pitch=np.arange(COUNT) * 0.01)) == 9


def test_a_motion_without_steps_begins_with_its_first_movement() -> None:
    still = np.zeros((COUNT, 2), dtype=bool)
    stand = Stand().feet(INSTANTS)
    moved = np.where(np.arange(COUNT) >= 6, 0.1, 0.0)
    assert first_step(stand) == inf
    assert first_step(replace(stand, joints={"waist": moved})) == 6
    assert first_step(replace(stand, trunk_pitch=moved)) == 6
    assert first_step(replace(stand, swing=still | (moved > 0)[:, None])) == 6


@pytest.mark.parametrize(
    "name", sorted(set(names("gait")) - {"keyframes", "policy", "program", "stand", "trajectory"})
)
def test_every_walk_that_is_shipped_means_its_feet_to_be_in_the_air(name: str) -> None:
    gait = load_class("gait", name)()
    t = 0.01 * np.arange(round(2.0 * (gait.startup_time + gait.gait_period) / 0.01))
    feet = gait.feet(t)
    begun = first_step(feet)
    assert begun == np.flatnonzero(feet.swing.any(axis=1))[0]
    assert 0.0 < t[int(begun)] <= gait.startup_time
    assert feet.swing.any(axis=0).all()
