"""Searches of a real study whose trials are pretended: a pure function of gait, ground and seed.

Everything around the trials is real: plans, processes, Parquet, Optuna, SQLite.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import gaitlab.running.processes
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.log import TrialLog
from gaitlab.search import Candidate
from gaitlab.search.database import history
from gaitlab.search.search import SearchCallback, SearchResult, optimize
from gaitlab.store import Store, TrialRecord

FILE = Path(__file__).parent.parent / "data" / "pretended_study.yaml"
BEST_HEIGHT, BEST_SWAY = 0.035, 0.03  # m
TOO_HIGH = 0.055  # m, out of reach


@contextmanager
def folder() -> Iterator[Path]:
    """A folder that is gone afterwards."""
    with tempfile.TemporaryDirectory() as place:
        yield Path(place)


def study(*settings: str) -> Experiment:
    return load_experiment(FILE, settings)


def pretend(
    trial_id: str,
    trial: Mapping[str, Any],
    store: Path,
    *,
    pause: float = 0.0,
    log: TrialLog | None = None,
) -> TrialRecord:
    """Commit a trial that walks the faster the nearer it is to the best values."""
    time.sleep(pause)
    values, seed = trial["gait"]["values"], trial["seed"]
    state = "INFEASIBLE" if values["step_height"] > TOO_HIGH else "DONE"
    metrics = _metrics(values, trial["names"]["surface"], seed) if state == "DONE" else {}
    record = TrialRecord(
        trial_id=trial_id,
        state=state,
        reason="left_leg at tick 3: out of reach" if state == "INFEASIBLE" else "",
        trial=trial,
        metrics=metrics,
        provenance={"gaitlab_version": "0.1.0"},
    )
    Store(store).commit(record, log if state == "DONE" else None)
    return record


def _metrics(values: Mapping[str, float], surface: str, seed: int) -> dict[str, Any]:
    noise = np.random.default_rng([seed, int(values["step_height"] * 1e6)])
    off = abs(values["step_height"] - BEST_HEIGHT) / 0.02
    off += abs(values["lateral_sway"] - BEST_SWAY) / 0.02
    fell = bool(noise.random() < 0.5 * off - 0.5)
    ground = 0.02 if surface == "carpet_4mm" else 0.0
    speed = 0.15 - 0.05 * off + ground + 0.01 * noise.standard_normal()
    walked = 1.0 + noise.random() if fell else 4.0
    return {
        "walking_speed": float(speed),
        "fell": fell,
        "stable": not fell,
        "stable_strict": not fell,
        "distance": float(speed * walked),
        "walked_time": float(walked),
        "time_to_fall": float(walked) if fell else None,
    }


def pretend_slowly(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    return pretend(trial_id, trial, store, pause=0.02)


def fall(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Every robot falls, the sooner the lower it lifts its feet."""
    walked = 10.0 * trial["gait"]["values"]["step_height"]
    metrics = {"walking_speed": 0.1, "fell": True, "stable": False}
    record = TrialRecord(
        trial_id=trial_id,
        state="DONE",
        reason="",
        trial=trial,
        metrics={**metrics, "walked_time": walked, "time_to_fall": walked},
        provenance={},
    )
    Store(store).commit(record, None)
    return record


@contextmanager
def walked_by(task: Any) -> Iterator[None]:
    """Trials are walked by this function, in workers too."""
    before = gaitlab.running.processes.simulated
    gaitlab.running.processes.simulated = task
    try:
        yield
    finally:
        gaitlab.running.processes.simulated = before


def search(
    store: Store,
    *settings: str,
    jobs: int = 0,
    task: Any = pretend,
    callback: SearchCallback | None = None,
    storage: str | None = None,
) -> SearchResult:
    with walked_by(task):
        return optimize(study(*settings), store, jobs=jobs, callback=callback, storage=storage)


def told(store: Store, *settings: str, storage: str | None = None) -> tuple[Candidate, ...]:
    return history(study(*settings), store, storage).candidates
