"""What racing saves, and what it costs: the same search with and without, five times.

Every repeat has a sampler's seed of its own. The winners walk again with 20 seeds that no search
saw. About a quarter of an hour on two idle cores.

    python benchmarks/racing.py [--repeats 5] [--trials 24] [--jobs 2] [--store FOLDER]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from repeated import Result, difference, opened, searched

STUDY = "eros_small"
SEEDS = ("seeds=8",)
ON, OFF = "study.racing={rounds: [2, 4, 8]}", "study.racing=off"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--trials", type=int, default=24)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--store", type=Path, default=Path("/tmp/gaitlab-racing"))
    given = parser.parse_args()
    store = opened(given.store)
    print("| repeat | with racing [s] | without [s] | saved | winner, fresh | without, fresh |")
    print("|---|---|---|---|---|---|")
    rows: list[tuple[Result, Result]] = []
    for repeat in range(given.repeats):
        pair = []
        for name, racing in (("raced", ON), ("whole", OFF)):
            settings = (*SEEDS, racing, f"study.trials={given.trials}", f"study.seed={repeat}")
            settings = (*settings, f"name=racing_{name}_{repeat}")
            pair.append(searched(STUDY, settings, store, given.jobs))
        on, off = pair
        rows.append((on, off))
        saved = f"{100.0 * (1.0 - on.used / off.used):.0f} %"
        print(f"| {repeat} | {on.used:.0f} | {off.used:.0f} | {saved} ", end="")
        print(f"| {on.fresh:.4f} | {off.fresh:.4f} |", flush=True)
    used, whole = sum(on.used for on, _ in rows), sum(off.used for _, off in rows)
    print(f"\nSimulated time saved: {100.0 * (1.0 - used / whole):.0f} %")
    found = difference([on.fresh for on, _ in rows], [off.fresh for _, off in rows])
    print(f"Winner with racing minus without, on fresh seeds: {found}")


if __name__ == "__main__":
    main()
