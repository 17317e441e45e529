"""What a gait must give: poses for every instant, in the shapes and numbers that were asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitlab.errors import WrongValue
from gaitlab.gaits.eros import Gait
from gaitlab.motion import SHAPES, FeetPoses, require_feet

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
