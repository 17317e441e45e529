"""Does a search beat guessing? The same number of candidates by the sampler and at random.

Both race alike and start from the hand-set values; every repeat has a seed of its own. The winners
walk again with 20 seeds that no search saw. About twenty minutes on two idle cores.

    python benchmarks/search.py [--repeats 5] [--trials 40] [--sampler tpe] [--jobs 2]
        [--study eros_small] [--set PATH=VALUE ...] [--store FOLDER]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from repeated import Result, difference, opened, searched

SETTINGS = ("seeds=8", "study.racing={rounds: [2, 4, 8]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--sampler", default="tpe")
    parser.add_argument("--study", default="eros_small")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--store", type=Path, default=Path("/tmp/gaitlab-search"))
    given = parser.parse_args()
    store = opened(given.store)
    samplers = (given.sampler, "random")
    heads = [
        f"{sampler}, {what}" for what in ("[s]", "fresh", "final, fresh") for sampler in samplers
    ]
    print(f"| repeat | {' | '.join(heads)} |\n|---|{'---|' * len(heads)}")
    rows: list[tuple[Result, Result]] = []
    for repeat in range(given.repeats):
        one, two = (
            searched(given.study, _settings(given, sampler, repeat), store, given.jobs)
            for sampler in samplers
        )
        rows.append((one, two))
        print(f"| {repeat} | {one.used:.0f} | {two.used:.0f} ", end="")
        print(
            f"| {one.fresh:.4f} | {two.fresh:.4f} | {one.final:.4f} | {two.final:.4f} |", flush=True
        )
    for what in ("searched", "fresh", "final"):
        sides = [[getattr(result, what) for result in side] for side in zip(*rows, strict=True)]
        print(f"\n{given.sampler} minus random, {what}: {difference(*sides)}")


def _settings(given: argparse.Namespace, sampler: str, repeat: int) -> tuple[str, ...]:
    own = (f"study.sampler={sampler}", f"study.seed={repeat}", f"study.trials={given.trials}")
    return (*SETTINGS, *given.settings, *own, f"name={given.study}_{sampler}_{repeat}")


if __name__ == "__main__":
    main()
