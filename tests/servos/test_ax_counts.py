import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitlab.servos.counts import ax_counts

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "bioloid.json").read_text())
LEGS = ("alpha", "beta", "gamma", "theta", "omega")


@pytest.mark.parametrize("case", GOLDEN["ax12_conversion"])
def test_counts_equal_the_reference(case: dict[str, Any]) -> None:
    assert ax_counts(np.radians(case["angle_deg"]), case["direction"]) == case["count"]


@pytest.mark.parametrize("case", GOLDEN["ik_table2"])
@pytest.mark.parametrize(("direction", "name"), [(1, "units_plus"), (-1, "units_minus")])
def test_the_five_poses_have_the_reference_s_counts(
    case: dict[str, Any], direction: int, name: str
) -> None:
    counts = ax_counts(np.radians([case[angle] for angle in LEGS]), direction)
    assert dict(zip(LEGS, counts.tolist(), strict=True)) == case[name]


def test_directions_mirror_about_the_centre() -> None:
    angles = np.linspace(-2.5, 2.5, 101)
    both = ax_counts(angles, 1) + ax_counts(-angles, 1)
    assert set(both.tolist()) <= {1023, 1024, 1025}
    assert ax_counts(0.0) == 512


def test_angles_beyond_the_servo_stop_at_its_ends() -> None:
    assert ax_counts(np.array([-4.0, 4.0])).tolist() == [0, 1023]
