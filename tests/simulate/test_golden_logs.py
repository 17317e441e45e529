"""No change of the physics goes by unnoticed: stored results would be those of another physics."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from gaitlab.simulation.trial import PHYSICS_VERSION, Trial
from tests.data.make_golden_logs import FILE, agreeing, ids, moved, numbers, trials

STORED = json.loads(FILE.read_text(encoding="utf-8"))
TRIALS = trials()
REMAKE = "run `python tests/data/make_golden_logs.py`"


def servos(trial: Trial, **factors: float) -> Trial:
    scaled = [
        replace(servo, **{name: getattr(servo, name) * by for name, by in factors.items()})
        for servo in trial.servos
    ]
    return replace(trial, servos=tuple(scaled))


def ground(trial: Trial, **factors: float) -> Trial:
    changed = {name: getattr(trial.surface, name) * by for name, by in factors.items()}
    return replace(trial, surface=replace(trial.surface, **changed))


CHANGES: dict[str, Callable[[Trial], Trial]] = {
    "friction": lambda trial: ground(trial, friction_scale=1.01),
    "stiffness": lambda trial: ground(trial, vertical_scale=1.01),
    "damping": lambda trial: servos(trial, stall_torque=1.01),
    "speed": lambda trial: servos(trial, no_load_speed=1.01),
    "latency": lambda trial: servos(trial, latency=1.01),
}


def test_the_stored_logs_are_of_this_physics_and_of_every_robot_and_ground() -> None:
    assert STORED["physics_version"] == PHYSICS_VERSION, f"stored logs are older: {REMAKE}"
    assert list(STORED["logs"]) == list(TRIALS), f"robots or grounds have changed: {REMAKE}"


@pytest.mark.long
def test_every_trial_of_every_shipped_experiment_keeps_its_name() -> None:
    """What a store holds would not be found again."""
    found = ids()
    assert len(found) > 20
    assert found == STORED["ids"], f"raise PHYSICS_VERSION if that was wanted, then {REMAKE}"


@pytest.mark.parametrize("name", TRIALS)
def test_a_short_log_is_the_one_that_this_physics_gave(name: str) -> None:
    stored, found = STORED["logs"][name], numbers(TRIALS[name])
    assert len(stored["torque"]) >= 2, "nothing is held"
    assert agreeing(stored, found) == len(stored["torque"]), (
        f"the physics of {name} has changed: raise PHYSICS_VERSION, then {REMAKE}\n"
        f"stored {stored}\nfound  {found}"
    )


@pytest.mark.parametrize("change", CHANGES)
def test_one_per_cent_of_a_constant_is_noticed(change: str) -> None:
    """By one of the stored logs at least; a sole that does not slip knows no friction."""

    def noticed(name: str) -> bool:
        stored = STORED["logs"][name]
        return agreeing(stored, numbers(CHANGES[change](TRIALS[name]))) < len(stored["torque"])

    assert any(noticed(f"{robot} on carpet_4mm") for robot in ("eros", "nao", "flow", "bioloid"))


def test_the_last_bits_of_a_start_are_not() -> None:
    name = "eros on carpet_4mm"
    stored = STORED["logs"][name]
    assert agreeing(stored, numbers(moved(TRIALS[name]))) == len(stored["torque"])
