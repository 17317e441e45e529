"""How long a report of many trials takes, and how much memory: page, figures, HTML and tables.

    python benchmarks/report.py [--trials 1000 10000] [--source data] [--store FOLDER]
                                [--set engine.name=mujoco] [--forms html tables]

The trials are real: the logs and records of `eros_table7` in the source store, copied under the
names of the trials that more seeds of the same experiment plan. A store that is given is filled
once and kept. Reports run in processes of their own and twice each, to see that nothing changes,
and what it saves that figures which show the same are not drawn again.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
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
name, seeds, store, output, settings, forms = sys.argv[1:]
experiment = load_experiment(name, settings.split(), int(seeds))
asked = {form: True for form in forms.split()}
write_report([experiment], Store(Path(store)), Path(output), **asked)
seconds = time.perf_counter() - start
peak = re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())
print(seconds, time.process_time(), int(peak[1]) / 1024)
"""


def fill(store: Store, source: Store, seeds: int, settings: Sequence[str]) -> int:
    """Copy the source's trials under the names of the planned ones; says how many there are."""
    experiment = load_experiment(EXPERIMENT, settings, seeds)
    planned = list(plan(experiment).trials())
    there = store.states()
    originals = _originals(source, settings)
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


def _originals(source: Store, settings: Sequence[str]) -> dict[tuple[object, ...], list[str]]:
    """Ids of the source's trials by cell."""
    stored = source.states()
    found: dict[tuple[object, ...], list[str]] = defaultdict(list)
    for item in plan(load_experiment(EXPERIMENT, settings)).trials():
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


def measure(store: Store, seeds: int, output: Path, asked: argparse.Namespace) -> Cost:
    """Cost of one report in the forms that are asked for."""
    words = [sys.executable, "-c", MEASURED, EXPERIMENT, str(seeds), str(store.path), str(output)]
    words += [" ".join(asked.settings), " ".join(asked.forms)]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
    return Cost(*(float(word) for word in done.stdout.split()))


def digest(folder: Path) -> str:
    """SHA-256 of every file of a folder and its name."""
    found = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        found.update(str(path.relative_to(folder)).encode() + path.read_bytes())
    return found.hexdigest()


def rows(asked: argparse.Namespace, store: Store, folder: Path) -> Iterator[str]:
    """One line a size."""
    source = Store(asked.source)
    cells = plan(load_experiment(EXPERIMENT)).cell_count
    for size in asked.trials:
        seeds = -(-size // cells)
        start = time.perf_counter()
        trials = fill(store, source, seeds, asked.settings)
        filled = time.perf_counter() - start
        output = folder / str(size)
        first = measure(store, seeds, output, asked)
        before = digest(output)
        again = measure(store, seeds, output, asked)
        same = "equal" if digest(output) == before else "DIFFERENT"
        page = output / "index.html"
        html = f"; index.html {page.stat().st_size / 1e6:.1f} MB" if page.is_file() else ""
        yield (
            f"{trials:6d} trials (filled in {filled:.0f} s): {first.seconds:.1f} s, of which "
            f"{first.busy:.1f} s of a processor; again {again.seconds:.1f} s, {again.busy:.1f} s "
            f"of a processor, with {same} bytes; {first.memory:.0f} MB at most{html}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, nargs="+", default=[1000, 10_000])
    parser.add_argument("--source", type=Path, default=Path("data"))
    parser.add_argument("--store", type=Path, help="filled once and kept; a passing one by default")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--forms", nargs="*", default=["html", "tables"], help="beside Markdown")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gaitlab-report-") as folder:
        store = Store(asked.store or Path(folder) / "data")
        for row in rows(asked, store, Path(folder)):
            print(row, flush=True)


if __name__ == "__main__":
    main()
