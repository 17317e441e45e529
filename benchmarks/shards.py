"""What eight shards at once cost against one run, of the same trials on the cores of this machine.

Each round runs a grid into two empty stores: by one run with a worker a core, and by shards that
are started at once with one worker each, as tasks of a cluster are. Prints the ratios of wall time
and of CPU time, because the machine may be shared, and what a shard costs beside its trials, which
says how much of a shard of 20 minutes is work.

    python benchmarks/shards.py [--rounds 3] [--shards 8] [--trials 64]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from gaitlab.running.slurm import SHARD_SECONDS
from gaitlab.store import Store

EXPERIMENT = ["eros_table7", "--set", "surfaces=[carpet_4mm]", "--set", "horizon.cycles=9"]
EXPERIMENT += ["--set", "grid={gait.step_length: [0.04]}"]


@dataclass(frozen=True)
class Spent:
    """What commands that ran at the same time took: wall and CPU time, in [s]."""

    wall: float
    cpu: float


def spent(commands: Sequence[Sequence[str]]) -> Spent:
    """Run commands of gaitlab at once."""
    start, cpu = time.perf_counter(), 0.0
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", "gaitlab", *command],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for command in commands
    ]
    for process in processes:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.stderr is not None
        with process.stderr as said:
            if process.returncode:
                raise SystemExit(f"a run ended with exit code {process.returncode}: {said.read()}")
        cpu += usage.ru_utime + usage.ru_stime  # its workers among it, which it has waited for
    return Spent(time.perf_counter() - start, cpu)


def compared(trials: int, shards: int, cores: int) -> tuple[Spent, Spent]:
    """One run, and the shards, of the same trials."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
        run = ["run", *EXPERIMENT, "--seeds", str(trials), "-q"]
        alone = spent([[*run, "--store", one, "-j", str(cores)]])
        shared = [*run, "--store", other, "-j", "1"]
        together = spent([[*shared, "--shard", f"{n}/{shards}"] for n in range(1, shards + 1)])
        if Store(Path(one)).states() != Store(Path(other)).states():
            raise SystemExit("the shards are not the whole; nothing to compare")
    return alone, together


def main() -> None:
    """Print the ratios of each round and their medians."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--trials", type=int, default=64)
    options = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    walls, cpus, starts = [], [], []
    for _ in range(options.rounds):
        alone, together = compared(options.trials, options.shards, cores)
        walls.append(alone.wall / together.wall)
        cpus.append(alone.cpu / together.cpu)
        starts.append((together.cpu - alone.cpu) / (options.shards - 1))
        print(
            f"one run {alone.wall:.1f} s ({alone.cpu:.1f} s of CPU), {options.shards} shards "
            f"{together.wall:.1f} s ({together.cpu:.1f} s), ratio {walls[-1]:.2f} ({cpus[-1]:.2f})",
            flush=True,
        )
    more = median(starts)
    print(
        f"median ratio of wall time {median(walls):.2f}, of CPU time {median(cpus):.2f} "
        f"(n = {options.rounds}; {options.trials} trials, {cores} cores)"
    )
    print(
        f"each shard more costs {more:.1f} s of CPU: of {SHARD_SECONDS / 60:.0f} min "
        f"{SHARD_SECONDS / (SHARD_SECONDS + more):.1%} are work"
    )


if __name__ == "__main__":
    main()
