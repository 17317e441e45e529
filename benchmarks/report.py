"""How long a report of many trials takes, and how much memory: page, figures, HTML and tables.

    python benchmarks/report.py [--trials 1000 10000] [--source data] [--store FOLDER]

The trials are real: the logs and records of `eros_table7` in the source store, copied under the
names of the trials that more seeds of the same experiment plan. A store that is given is filled
once and kept. Reports run in processes of their own and twice each, to see that nothing changes.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.store import Store

EXPERIMENT = "eros_table7"
MEASURED = """
import re, sys, time
from pathlib import Path
start = time.perf_counter()
from gaitlab.experiment import load_experiment
from gaitlab.report import write_report
from gaitlab.store import Store
experiment = load_experiment(sys.argv[1], seeds=int(sys.argv[2]))
write_report([experiment], Store(Path(sys.argv[3])), Path(sys.argv[4]), html=True, tables=True)
seconds = time.perf_counter() - start
peak = re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())
print(seconds, time.process_time(), int(peak[1]) / 1024)
"""


def fill(store: Store, source: Store, seeds: int) -> int:
    """Copy the source's trials under the names of the planned ones; says how many there are."""
    experiment = load_experiment(EXPERIMENT, seeds=seeds)
    planned = list(plan(experiment).trials())
    there = store.states()
    originals = _originals(source)
    copies: dict[str, list[PlannedTrial]] = defaultdict(list)
    for item in planned:
        if item.trial.id not in there:
            cell = originals[_cell(item)]
            copies[cell[item.trial.seed % len(cell)]].append(item)
    with store.alone():
        for original, items in copies.items():
            _copy(source, original, items, store)
        store.compact()
        store.register(experiment, planned)
        store.tabulate()
    return len(planned)


def _originals(source: Store) -> dict[tuple[object, ...], list[str]]:
    """Ids of the source's trials by cell."""
    stored = source.states()
    found: dict[tuple[object, ...], list[str]] = defaultdict(list)
    for item in plan(load_experiment(EXPERIMENT)).trials():
        if item.trial.id in stored:
            found[_cell(item)].append(item.trial.id)
    return found


def _cell(item: PlannedTrial) -> tuple[object, ...]:
    return tuple(sorted(item.values.items()))


def _copy(source: Store, original: str, items: list[PlannedTrial], store: Store) -> None:
    record = source.record(original)
    log = source.log(original) if record.state == "DONE" else None
    for item in items:
        copied = replace(record, trial_id=item.trial.id, trial=item.trial.to_dict())
        store.commit(copied, log)
        store.note(copied)


class Cost(NamedTuple):
    """What one report takes.

    Attributes:
        seconds: By the clock.
        busy: Of processor time, in [s]; less than the clock's on a machine with other work.
        memory: Peak, in [MB].
    """

    seconds: float
    busy: float
    memory: float


def measure(store: Store, seeds: int, output: Path) -> Cost:
    """Cost of one report with all its forms."""
    words = [sys.executable, "-c", MEASURED, EXPERIMENT, str(seeds), str(store.path), str(output)]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
    return Cost(*(float(word) for word in done.stdout.split()))


def digest(folder: Path) -> str:
    """SHA-256 of every file of a folder and its name."""
    found = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        found.update(str(path.relative_to(folder)).encode() + path.read_bytes())
    return found.hexdigest()


def rows(sizes: list[int], source: Store, store: Store, folder: Path) -> Iterator[str]:
    """One line a size."""
    cells = plan(load_experiment(EXPERIMENT)).cell_count
    for size in sizes:
        seeds = -(-size // cells)
        start = time.perf_counter()
        trials = fill(store, source, seeds)
        filled = time.perf_counter() - start
        output = folder / str(size)
        first = measure(store, seeds, output)
        before = digest(output)
        again = measure(store, seeds, output)
        same = "equal" if digest(output) == before else "DIFFERENT"
        page = (output / "index.html").stat().st_size / 1e6
        yield (
            f"{trials:6d} trials (filled in {filled:.0f} s): {first.seconds:.1f} s, of which "
            f"{first.busy:.1f} s of a processor; again {again.seconds:.1f} s with {same} bytes; "
            f"{first.memory:.0f} MB at most; index.html {page:.1f} MB"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, nargs="+", default=[1000, 10_000])
    parser.add_argument("--source", type=Path, default=Path("data"))
    parser.add_argument("--store", type=Path, help="filled once and kept; a passing one by default")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gaitlab-report-") as folder:
        store = Store(asked.store or Path(folder) / "data")
        for row in rows(asked.trials, Store(asked.source), store, Path(folder)):
            print(row, flush=True)


if __name__ == "__main__":
    main()
