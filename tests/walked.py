"""A short real walk on grass, for tests of what shows and exports it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gaitlab.log import TrialLog
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
from gaitlab.store import Store, TrialRecord
from tests.trials import trial


@cache
def walked(surface: str = "grass_50mm", seed: int = 0) -> tuple[Trial, TrialLog]:
    """A trial and its log, simulated once in a test run."""
    walking = trial(surface, cycles=0.5, seed=seed, step_length=0.04)
    return walking, simulate(walking)


def record(walking: Trial, log: TrialLog) -> TrialRecord:
    """What a store keeps of it."""
    fell = log.fall_index is not None
    metrics = {"fell": fell, "distance": log.distance}
    return TrialRecord(
        trial_id=walking.id,
        state="DONE",
        reason="",
        trial=walking.to_dict(),
        metrics=metrics,
        provenance={},
    )


def commit(folder: Path) -> str:
    """Put the walk into a store; its trial's name."""
    walking, log = walked()
    Store(folder).commit(record(walking, log), log)
    return walking.id
