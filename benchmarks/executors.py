"""What a trial costs beside itself in each executor: wall time of trials that do nothing.

The same trials, as long as a real one's data and done at once, go through this process, through
worker processes and through Dask's workers of this machine, in turn. The start of the workers is
left out, their replacement is not. The machine may be shared, so each is also given as a ratio to
the worker processes of the same round.

    python benchmarks/executors.py [--trials 10000] [--rounds 1] [--jobs 2]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.dask_cluster import DaskCluster
from gaitlab.running.executor import Executor, Job, Serial, job_of
from gaitlab.running.processes import Processes
from gaitlab.store import Store, TrialRecord

Task = Callable[..., TrialRecord]


def nothing(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """A trial that is done at once; its file is empty, for a cluster waits until it is seen."""
    path = Store(store).file(trial_id)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return TrialRecord(
        trial_id=trial_id, state="DONE", reason="", trial=trial, metrics={}, provenance={}
    )


def jobs(count: int) -> Iterator[Job]:
    """So many trials with the data of a real one."""
    trial = next(plan(load_experiment("eros_quick")).trials()).trial.to_dict()
    for number in range(count):
        yield job_of(f"{number:032x}", trial, 1.0)


def milliseconds(executor: Executor, count: int, workers: int) -> float:
    """Wall time of a trial, in [ms]; from the moment on when each worker has done some."""
    warm = 10 * workers
    ended = executor.run(jobs(count + warm))
    for _ in range(warm):
        next(ended)
    start = time.perf_counter()
    done = sum(outcome.record is not None for outcome in ended)
    if done != count:
        raise SystemExit(f"{done} of {count} trials are done; nothing to compare")
    return 1e3 * (time.perf_counter() - start) / count


def main() -> None:
    """Print each executor's time a trial."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    times: dict[str, list[float]] = {"serial": [], "processes": [], "dask": []}
    for _ in range(options.rounds):
        for name, found in times.items():
            with (
                tempfile.TemporaryDirectory() as folder,
                DaskCluster("local", jobs=options.jobs) as cluster,
            ):
                store, task = Path(folder), partial(nothing, store=Path(folder))
                executor: Executor = {
                    "serial": lambda task=task: Serial(task),
                    "processes": lambda task=task: Processes(task, options.jobs),
                    "dask": lambda store=store, cluster=cluster: cluster.executor(
                        store, nothing, print
                    ),
                }[name]()
                found.append(milliseconds(executor, options.trials, options.jobs))
            ratio = found[-1] / times["processes"][-1] if times["processes"] else 0.0
            beside = f", {ratio:.2f} times the processes'" if ratio else ""
            print(f"{name:<10} {found[-1]:7.2f} ms a trial{beside}", flush=True)
    if options.rounds > 1:
        for name, found in times.items():
            print(f"{name:<10} median {median(found):.2f} ms")
    print(f"{options.trials} trials, {options.jobs} workers, n = {options.rounds}")


if __name__ == "__main__":
    import executors  # a worker process finds its task by the name of a module, and not in this one

    executors.main()
