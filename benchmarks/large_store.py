"""How a store of a hundred thousand trials bears up: resume scan, query, memory.

    python benchmarks/large_store.py [TRIALS]

The records have every metric; the trials' files are 500 bytes of nothing, because none of these
steps opens a file whose name and size the index knows. What is measured is the bookkeeping.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.metrics import names as metric_names
from gaitlab.store import Store, TrialRecord
from gaitlab.store.entry import entry
from gaitlab.store.index import write_entries

EXPERIMENT = Path(__file__).parent.parent / "tests" / "data" / "pretended.yaml"
CELLS = 24

SQL = "SELECT surface, avg(stable::int) AS stable, count(*) AS n FROM trials GROUP BY 1"
STEPS = {
    "resume scan": "store.compact()",
    "query": f"store.query({SQL!r})",
    "query, table gathered anew": f"store._table_file.remove(); store.query({SQL!r})",
}
MEASURED = """
import re, sys, time
from pathlib import Path
import duckdb, pandas, pyarrow.parquet
from gaitlab.store import Store
import gaitlab.store.tables
store = Store(Path(sys.argv[1]))
start = time.perf_counter()
{step}
seconds = time.perf_counter() - start
peak = re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())
print(seconds, int(peak[1]) / 1024)
"""


def fill(store: Store, trials: int) -> None:
    """Small files of their own for every planned trial, and the index and list that go with them.

    The files are written plainly: a hundred thousand fsyncs measure the disk and nothing else.
    """
    experiment = load_experiment(EXPERIMENT, seeds=max(1, trials // CELLS))
    planned = list(plan(experiment).trials())
    content = b"x" * 500
    entries = []
    for item in planned:
        trial_id = item.trial.id
        number = int(hashlib.sha256(trial_id.encode()).hexdigest()[:8], 16)
        path = store.file(trial_id)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        metrics = {name: (number % 997) / 997 for name in metric_names()}
        names = {"robot": "eros", "gait": "eros", "surface": item.values["surface"]}
        record = TrialRecord(
            trial_id=trial_id,
            state="DONE",
            reason="",
            trial={"names": names, "seed": item.trial.seed},
            metrics={**metrics, "stable": number % 2 == 0, "fell": number % 2 == 1},
            provenance={"gaitlab_version": "0.1.0", "platform": "linux-x86_64"},
        )
        entries.append(entry(record, len(content)))
    write_entries(store.path / "index.jsonl", entries)
    store.register(experiment, planned)
    store.tabulate()


def measure(store: Store, step: str) -> tuple[float, float]:
    """Seconds and peak memory in [MB] of one step in a process of its own."""
    script = MEASURED.format(step=step)
    done = subprocess.run(
        [sys.executable, "-c", script, str(store.path)], capture_output=True, text=True, check=True
    )
    seconds, memory = (float(word) for word in done.stdout.split())
    return seconds, memory


def main() -> None:
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    with tempfile.TemporaryDirectory(prefix="gaitlab-large-") as folder:
        store = Store(Path(folder) / "data")
        start = time.perf_counter()
        fill(store, trials)
        print(f"{trials} trials filled in {time.perf_counter() - start:.0f} s", flush=True)
        for name, step in STEPS.items():
            seconds, memory = measure(store, step)
            print(f"{name:28s} {seconds:6.2f} s  {memory:6.0f} MB", flush=True)


if __name__ == "__main__":
    main()
