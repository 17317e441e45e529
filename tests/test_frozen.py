"""What was frozen before anything was predicted stays as it was."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.simulation.trial import PHYSICS_VERSION

EXPERIMENTS = Path(__file__).parent.parent / "experiments"
FROZEN = EXPERIMENTS / "eros_frozen.yaml"


def noted(key: str) -> str:
    found = re.search(rf"^#\s+{key}:\s+(\S+)$", FROZEN.read_text(), re.MULTILINE)
    assert found, f"{FROZEN.name} notes no {key}"
    return found[1]


@pytest.mark.bullet  # the digest is that of the reference
def test_every_number_of_the_frozen_prediction_is_the_one_noted() -> None:
    assert load_experiment(FROZEN).digest == noted("frozen digest")
    assert str(PHYSICS_VERSION) == noted("physics version")


@pytest.mark.parametrize("setting", ["surface.toe_catch=1.55", "gait.hip_height=0.2241"])
def test_another_number_would_be_noticed(setting: str) -> None:
    assert load_experiment(FROZEN, [setting]).digest != noted("frozen digest")


def test_no_constant_belongs_to_one_pedestal() -> None:
    scales = ("toe_catch", "vertical_scale", "friction_scale")
    surfaces = load_experiment(FROZEN).parts.surfaces.values()
    assert len(surfaces) == 4
    for scale in scales:
        assert len({getattr(surface, scale) for surface in surfaces}) == 1


def test_the_predictions_walk_forty_seeds_and_none_of_the_ground_and_gain_searches() -> None:
    seeds = {planned.trial.seed for planned in plan(load_experiment(FROZEN)).trials()}
    assert seeds == set(range(40))
    for file in (EXPERIMENTS / "reproduction").glob("*.yaml"):
        assert set(load_experiment(file).seeds) <= seeds
