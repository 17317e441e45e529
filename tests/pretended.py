"""A stand-in for the simulation: trials of real plans that end at once in every possible way."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from gaitlab.experiment import Experiment, load_experiment
from gaitlab.running import Progress, Started, dispatch
from gaitlab.store import Store, TrialRecord
from tests import recorded

FILE = Path(__file__).parent / "data" / "pretended.yaml"


def experiment(seeds: int = 1) -> Experiment:
    """24 cells: two grounds, three step lengths, four sway amplitudes."""
    return load_experiment(FILE, seeds=seeds)


def pretend(
    trial_id: str, trial: Mapping[str, Any], store: Path, *, pause: float = 0.0, faults: bool = True
) -> TrialRecord:
    """Commit a made-up trial; on carpet some are infeasible and one crashes its worker."""
    time.sleep(pause)
    values, seed = trial["gait"]["values"], trial["seed"]
    on_carpet = trial["names"]["surface"] == "carpet_4mm"
    state = "DONE"
    if on_carpet and faults and values["step_length"] == 0.08:
        state = "INFEASIBLE"
    if on_carpet and faults and values["step_length"] == 0.0 and values["lateral_sway"] == 0.01:
        os._exit(3)
    number = int(trial_id[:6], 16)
    record = replace(
        recorded.record(number, state),
        trial_id=trial_id,
        trial=trial,
        provenance={"gaitlab_version": "0.1.0", "wall_time": time.monotonic()},
    )
    Store(store).commit(record, recorded.log(seed=seed) if state == "DONE" else None)
    return record


def pretend_slowly(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """As `pretend` without faults, in about a tenth of a second."""
    return pretend(trial_id, trial, store, pause=0.1, faults=False)


def pretend_well(
    trial_id: str, trial: Mapping[str, Any], store: Path, *, pause: float = 0.0
) -> TrialRecord:
    """As `pretend` without faults."""
    return pretend(trial_id, trial, store, pause=pause, faults=False)


def pretend_held(
    trial_id: str, trial: Mapping[str, Any], store: Path, *, hold: Path
) -> TrialRecord:
    """As `pretend_well`, once the file `hold` is gone."""
    end = time.monotonic() + 60.0
    while hold.exists():
        assert time.monotonic() < end, "nobody lets the trial go on"
        time.sleep(0.01)
    return pretend_well(trial_id, trial, store)


def pretend_late(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """On grass one never ends and one crashes its worker."""
    values, on_grass = trial["gait"]["values"], trial["names"]["surface"] != "carpet_4mm"
    if on_grass and values["step_length"] == 0.0 and values["lateral_sway"] == 0.01:
        time.sleep(60.0)
    if on_grass and values["step_length"] == 0.08 and values["lateral_sway"] == 0.01:
        os._exit(3)
    return pretend_well(trial_id, trial, store)


def pretend_falling(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """On carpet every robot falls in standing, on grass every other one in walking."""
    standing = trial["names"]["surface"] == "carpet_4mm"
    fell = standing or trial["seed"] % 2 == 0
    flags = {"stable": not fell, "fell": fell, "fell_standing": standing}
    found = recorded.record(0, **flags)
    record = replace(found, trial_id=trial_id, trial=trial)
    Store(store).commit(record, recorded.log(seed=trial["seed"]))
    return record


class Speaking(Progress):
    """Tells another process how a run goes; a signal may come at any instant, so not by `print`."""

    def started(self, trial: Started) -> None:
        os.write(1, b"started\n")

    def message(self, text: str) -> None:
        os.write(1, text.encode() + b"\n")


if __name__ == "__main__":
    import gaitlab.running.processes
    from tests import pretended  # pickled by this name, not as a function of __main__

    where, how = sys.argv[1:]
    gaitlab.running.processes.simulated = (
        partial(pretended.pretend_held, hold=Path(how))
        if Path(how).is_file()
        else partial(pretended.pretend_well, pause=float(how))
    )
    print("ready", flush=True)
    summary = dispatch(experiment(), Store(Path(where)), jobs=2, progress=Speaking())
    print(summary.planned, summary.done, summary.left, summary.interrupted, flush=True)
