"""Small sweeps of real plans whose trials are a pure function of their identity.

The simulation is pretended, everything around it is real: plans, processes, signals, Parquet,
folders. A pretended trial notes beside the store in `simulated` that it was started, and in `twice`
when it was although its file was there.
"""

from __future__ import annotations

import ctypes
import os
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.running import Summary, dispatch
from gaitlab.running.worker import simulated
from gaitlab.store import Store, TrialRecord, fingerprint
from tests import recorded

FILE = Path(__file__).parent.parent / "data" / "pretended.yaml"
NAME = "pretended"
SMALL = (
    "grid.gait.step_length=[0.0, 0.04]",
    "grid.gait.lateral_sway=[0.01, 0.02]",
)  # 8 cells
EATEN = 1 << 28  # byte at a time, untouched, so that eating takes no time
TICKS_OF_A_LONG_LOG = 6000


def experiment(*settings: str, seeds: int = 1) -> Experiment:
    """Under its own name whatever is set, as if the file itself said so."""
    return replace(load_experiment(FILE, settings=settings, seeds=seeds), form="")


def given(trial_id: str, trial: Mapping[str, Any]) -> TrialRecord:
    """What a trial gives: its numbers hang on its identity and on nothing else."""
    number = int(trial_id[:6], 16)
    done = {"stable": number % 2 == 0, "fell": number % 2 == 1, "distance": number / 1e6}
    return replace(
        recorded.record(number),
        trial_id=trial_id,
        trial=trial,
        metrics=done,
        provenance={"gaitlab_version": "0.1.0"},
    )


def pretend(
    trial_id: str,
    trial: Mapping[str, Any],
    store: Path,
    *,
    pause: float = 0.0,
    ticks: int = 40,
) -> TrialRecord:
    results = Store(store)
    _note(store.parent / "simulated", trial_id)
    if results.file(trial_id).exists():
        _note(store.parent / "twice", trial_id)
    time.sleep(pause)
    record = given(trial_id, trial)
    results.commit(record, recorded.log(ticks, seed=int(trial_id[:6], 16)))
    return record


def _note(file: Path, trial_id: str) -> None:
    with file.open("a") as notes:
        notes.write(f"{trial_id}\n")


def slow(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    return pretend(trial_id, trial, store, pause=0.03)


def held(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Two end at once, the others when somebody has written the file `go` beside the store."""
    end = time.monotonic() + 60.0
    while committed(Store(store)) >= 2 and not (store.parent / "go").exists():
        assert time.monotonic() < end, "nobody says go"
        time.sleep(0.005)
    return pretend(trial_id, trial, store)


def long(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """With a log of about a megabyte."""
    return pretend(trial_id, trial, store, ticks=TICKS_OF_A_LONG_LOG)


def hang() -> None:
    while True:
        time.sleep(1.0)


def eat() -> None:
    eaten = []
    while True:
        eaten.append(np.empty(EATEN, dtype=np.uint8))


def stuck(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Notes its process, and never ends."""
    (store / f"stuck-{os.getpid()}").touch()
    hang()
    raise AssertionError


DEEDS = {
    "work": lambda: None,
    "segfault": lambda: ctypes.string_at(0),
    "hang": hang,
    "exit": lambda: os._exit(3),
    "eat": eat,
}


def deed(seed: int) -> str:
    return tuple(DEEDS)[seed % len(DEEDS)]


def misbehave(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Four trials of five end their worker, each kind in its own way."""
    DEEDS[deed(trial["seed"])]()
    return pretend(trial_id, trial, store)


TASKS = {task.__name__: task for task in (pretend, slow, held, long, stuck, misbehave, simulated)}


def run(store: Store, *settings: str, seeds: int = 1, jobs: int = 0) -> Summary:
    """The sweep in this process or in workers, with trials that are pretended."""
    import gaitlab.running.processes

    before = gaitlab.running.processes.simulated
    gaitlab.running.processes.simulated = pretend
    try:
        return dispatch(experiment(*settings, seeds=seeds), store, jobs=jobs)
    finally:
        gaitlab.running.processes.simulated = before


def expected(*settings: str, seeds: int = 1) -> dict[str, dict[str, object]]:
    """The table of a sweep as a function of its plan: trial id to what its row says."""
    return {item.trial.id: _row(item) for item in plan(experiment(*settings, seeds=seeds)).trials()}


def _row(item: PlannedTrial) -> dict[str, object]:
    record = given(item.trial.id, {})
    return {"state": "DONE", "seed": item.trial.seed, **record.metrics, **item.values}


def table(store: Store) -> dict[str, dict[str, object]]:
    """The rows of the sweep's table by trial id, as far as they are a function of the plan."""
    rows = store.table(NAME).to_dict("records")
    names = ("state", "seed", "stable", "fell", "distance", "surface")
    return {
        str(row["trial_id"]): {
            name: value for name, value in row.items() if name in names or "." in str(name)
        }
        for row in rows
    }


def content(store: Store, name: str = NAME) -> dict[str, bytes]:
    """Every byte that must not depend on how a run went: index, list, every trial's file."""
    files = [store.path / "index.jsonl", store.path / "experiments" / name / "trials.jsonl"]
    files += sorted((store.path / "trials").rglob("*"))
    return {str(f.relative_to(store.path)): f.read_bytes() for f in files if f.is_file()}


def logs(store: Store) -> dict[str, str]:
    """What every trial gave, bit for bit."""
    return {trial_id: fingerprint(store.file(trial_id)) for trial_id in store.states()}


def twice(store: Store) -> list[str]:
    """Trials that were started although their file was there."""
    return _notes(store.path.parent / "twice")


def simulated_more_than_once(store: Store) -> list[str]:
    """Trials that were started more than once, by whomever."""
    counts = Counter(_notes(store.path.parent / "simulated"))
    return [trial_id for trial_id, count in counts.items() if count > 1]


def _notes(file: Path) -> list[str]:
    return file.read_text().split() if file.exists() else []


def committed(store: Store) -> int:
    return len(list((store.path / "trials").glob("*/*.parquet")))
