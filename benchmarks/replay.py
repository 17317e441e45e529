"""What ten seconds of walking on 50 mm grass cost in 3-D and as a film, 25 frames a second.

python benchmarks/replay.py
"""

from __future__ import annotations

import gzip
import os
import resource
import tempfile
import time
from pathlib import Path

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.render import Clip, Recorded, clip_of, write_replay
from gaitlab.simulation.simulate import simulate

SETTINGS = [
    "surfaces=[grass_50mm]",
    "grid={gait.step_length: [0.0]}",
    "seeds=[2]",
    "horizon.cycles=10",
]
JOBS = 2


def main() -> None:
    trial = next(iter(plan(load_experiment("eros_table7", SETTINGS)).trials())).trial
    shown = Recorded(trial.id, trial, simulate(trial))
    clip = clip_of([shown.log], begin=0.0, end=10.0, fps=25.0)
    print(
        f"{clip.end - clip.begin:.1f} s of walking, {len(clip.instants)} frames, {JOBS} processes"
    )
    with tempfile.TemporaryDirectory() as folder:
        for name in ("walk.html", "walk.mp4", "walk.gif"):
            measure([shown], Path(folder) / name, clip)
        for name in ("both.html", "both.gif"):
            measure([shown, shown], Path(folder) / name, clip)


def measure(shown: list[Recorded], path: Path, clip: Clip) -> None:
    before, started = processor_time(), time.perf_counter()
    written = write_replay(shown, path, clip, jobs=JOBS)
    wall, busy = time.perf_counter() - started, processor_time() - before
    packed = len(gzip.compress(path.read_bytes()))
    print(
        f"{path.name}: {wall:.1f} s wall, {busy:.1f} s of processor, "
        f"{1000 * busy / written.pictures:.0f} ms a frame, {written.size / 1e6:.2f} MB, "
        f"{packed / 1e6:.2f} MB gzipped; "
        f"load of the machine {os.getloadavg()[0]:.1f}"
    )


def processor_time() -> float:
    """Of this process and its children, in [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


if __name__ == "__main__":
    main()
