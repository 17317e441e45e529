"""Memory of one worker over many short trials, simulated and committed as in a run.

    python benchmarks/worker_memory.py [TRIALS]

A worker is replaced after 50 trials; here it is not, so that what it leaks would show.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.executor import Job
from gaitlab.running.processes import Processes
from gaitlab.running.worker import simulated
from gaitlab.store import Store, TrialRecord

EXPERIMENT = Path(__file__).parent.parent / "tests" / "data" / "pretended.yaml"
SHORTEST = (
    "surfaces=[hard_floor]",
    "horizon.cycles=0.5",
    "horizon.time=0.1",
    "gait.stand_time=0.0",
    "grid.gait.step_length=[0.0]",
    "grid.gait.lateral_sway=[0.01]",
)
PRINTED = 20  # lines


def noted(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Simulate, commit, and write down how much memory is in use, in [kB]."""
    record = simulated(trial_id, trial, store)
    status = Path("/proc/self/status").read_text()
    used = status.partition("VmRSS:")[2].split()[0]
    with (store / "memory").open("a") as notes:
        notes.write(f"{os.getpid()} {used}\n")
    return record


def main() -> None:
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    experiment = load_experiment(EXPERIMENT, settings=SHORTEST, seeds=trials)
    jobs = [
        Job(trial_id=item.trial.id, trial=item.trial.to_dict(), timeout=120.0)
        for item in plan(experiment).trials()
    ]
    with tempfile.TemporaryDirectory(prefix="gaitlab-memory-") as folder:
        start = time.perf_counter()
        executor = Processes(partial(noted, store=Path(folder)), 1, max_trials=trials + 1)
        ended = [outcome.record for outcome in executor.run(jobs)]
        notes = [line.split() for line in (Path(folder) / "memory").read_text().splitlines()]
        states = {record.state for record in ended if record is not None}
        assert len(Store(Path(folder)).states()) == trials
    used = [int(memory) / 1024 for _, memory in notes]
    print(f"{trials} trials {states} in {time.perf_counter() - start:.0f} s")
    for index in range(0, trials, max(1, trials // PRINTED)):
        print(f"after {index + 1:5d} trials  {used[index]:7.1f} MB")
    print(f"after {trials:5d} trials  {used[-1]:7.1f} MB, {len({pid for pid, _ in notes})} worker")
    print(f"growth after the first tenth: {used[-1] - used[trials // 10]:.1f} MB")


if __name__ == "__main__":
    import worker_memory  # a worker process finds its task by the name of a module, not in this one

    worker_memory.main()
