"""How long something takes is guessed from what this machine has simulated."""

from __future__ import annotations

import socket
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.pace import LEAST, USUAL, Pace
from gaitlab.simulation.trial import Trial
from gaitlab.store import TrialRecord
from tests import recorded


@pytest.fixture(scope="module")
def trials() -> dict[str, Trial]:
    """One trial of each ground, by its name, in Bullet."""
    planned = plan(load_experiment("eros_quick")).trials()
    return {trial.names.surface: trial for trial in (item.trial for item in planned)}


def record(trial: Trial, pace: float, simulated: float, host: str = "") -> TrialRecord:
    walked = simulated - trial.gait.startup_time
    return replace(
        recorded.record(1),
        metrics={"fell": False, "walked_time": walked},
        provenance={"host": host or socket.gethostname(), "processor_time": pace * simulated},
    )


@given(pace=st.floats(1e-3, 10.0), count=st.integers(3, 40))
def test_an_even_pace_is_learned_whatever_is_forgotten(
    trials: dict[str, Trial], pace: float, count: int
) -> None:
    learned, trial = Pace(None), next(iter(trials.values()))
    for _ in range(count):
        learned.learn(trial, record(trial, pace, 2 * LEAST))
    assert learned.of(trial) == pytest.approx(pace)


def test_what_is_not_known_is_taken_to_be_as_what_is_like_it(trials: dict[str, Trial]) -> None:
    learned, (one, other, *_) = Pace(None), trials.values()
    assert learned.of(one) == USUAL["bullet"]
    learned.learn(one, record(one, 0.123, 3 * LEAST))
    assert learned.of(other) == pytest.approx(0.123)
    in_mujoco = replace(other, engine=replace(other.engine, name="mujoco"))
    assert learned.of(in_mujoco) == USUAL["mujoco"]
    learned.learn(other, record(other, 0.5, 3 * LEAST))
    if one.surface.type != other.surface.type:
        assert learned.of(one) == pytest.approx(0.123)


def test_a_machine_learns_from_its_own_trials_and_only_from_those_that_walked(
    trials: dict[str, Trial],
) -> None:
    learned, trial = Pace(None), next(iter(trials.values()))
    learned.learn(trial, record(trial, 9.0, 3 * LEAST, host="another"))
    learned.learn(trial, replace(record(trial, 9.0, 3 * LEAST), state="FAILED"))
    learned.learn(trial, replace(record(trial, 9.0, 3 * LEAST), provenance={}))
    assert learned.of(trial) == USUAL["bullet"]


def test_what_was_learned_is_kept_and_damage_costs_only_that(
    trials: dict[str, Trial], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.running.pace.cache_folder", lambda: Folder(tmp_path))
    learned, trial = Pace.here(), next(iter(trials.values()))
    learned.learn(trial, record(trial, 0.2, 3 * LEAST))
    learned.save()
    assert Pace.here().of(trial) == learned.of(trial)
    (file,) = tmp_path.iterdir()
    content = file.read_bytes()
    for damaged in (b"", content[:-1], b"[[1]]", b"{}", b"[[[], {}, 1]]", b"\xff"):
        file.write_bytes(damaged)
        assert Pace.here().of(trial) == USUAL["bullet"], damaged
    file.unlink()
    file.mkdir()
    Pace.here().save()


class Folder:
    def __init__(self, path: Path) -> None:
        self.path = path
