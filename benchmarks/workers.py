"""How much faster two workers finish a grid than one, and what a tick costs in the store.

Runs the same grid into two empty stores, first with one worker process, then with two; the start
of the processes counts. Repeats and prints each ratio, because the machine may be shared.

    python benchmarks/workers.py [--rounds 3] [--trials 24]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median

from gaitlab.experiment import load_experiment
from gaitlab.running import dispatch
from gaitlab.store import Store

SETTINGS = ["surfaces=[carpet_4mm]", "grid={gait.step_length: [0.04]}", "horizon.cycles=9"]


def seconds(jobs: int, trials: int, folder: Path) -> float:
    """Wall time of the grid with a number of workers, in [s]."""
    experiment = load_experiment("eros_table7", SETTINGS, seeds=trials)
    store = Store(folder)
    start = time.perf_counter()
    summary = dispatch(experiment, store, jobs=jobs)
    if summary.done != trials:
        raise SystemExit(f"{summary.done} of {trials} trials are done; nothing to compare")
    return time.perf_counter() - start


def bytes_a_tick(folder: Path) -> tuple[float, int]:
    """Size of the trials' files over their ticks, and the number of ticks."""
    store = Store(folder)
    ticks = sum(len(store.log(trial_id)) for trial_id in store.states())
    size = sum(
        file.stat().st_size for file in folder.rglob("*.parquet") if file.stem in store.states()
    )
    return size / ticks, ticks


def read_milliseconds(folder: Path) -> float:
    """Median time to read one trial back, in [ms]."""
    store, spent = Store(folder), []
    for trial_id in list(store.states())[:20]:
        start = time.perf_counter()
        store.log(trial_id)
        spent.append(1e3 * (time.perf_counter() - start))
    return median(spent)


def main() -> None:
    """Print the ratio of each round and the store's figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--trials", type=int, default=24)
    options = parser.parse_args()
    ratios = []
    for _ in range(options.rounds):
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            single = seconds(1, options.trials, Path(one))
            double = seconds(2, options.trials, Path(two))
            ratios.append(single / double)
            print(
                f"one worker {single:.1f} s, two {double:.1f} s, ratio {ratios[-1]:.2f}", flush=True
            )
            size, ticks = bytes_a_tick(Path(two))
            read = read_milliseconds(Path(two))
    print(f"median ratio {median(ratios):.2f} (n = {options.rounds})")
    print(f"{size:.0f} bytes a tick over {ticks} ticks; a trial is read back in {read:.0f} ms")


if __name__ == "__main__":
    main()
