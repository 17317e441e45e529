"""How often the nightly gate cries wolf, and what it catches: a Markdown table of each.

False alarms: nights drawn from a pool of real walks in which nothing changed, half of the seeds as
the baseline and half as tonight, anew every night. Detection: four regressions, each walked with
the seeds of the baseline, and compared with the same and with other seeds.

    python benchmarks/gate.py --store STORE [--pool EXPERIMENT:STORE ...] [--nights 200] [--jobs 1]

Walks are kept in the store, so a second call simulates nothing; `--pool` adds experiments that
have already run.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path

import numpy as np
from scipy.stats import norm

from gaitlab.dispatch import dispatch
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.plugins import locate
from gaitlab.regression import Baseline, Outcome, compared, record
from gaitlab.regression.baseline import Walk
from gaitlab.regression.quantities import FALSE_ALARMS, Quantity
from gaitlab.statistics import wilson
from gaitlab.store import Store

NIGHTLY = "nightly"
SURFACES = ("carpet_4mm", "grass_10mm", "grass_30mm")
LESS_FRICTION = 0.9
LATE = 0.012  # s; 0.004 in the servo's file, so 8 ms later
LOW_STEP = 0.0227  # m; 5 mm below that of bases/eros.yaml
POWER = 0.8
ANKLE = "joints[:, 4] + added, ankle.lower"


def regressions(folder: Path) -> dict[str, list[str]]:
    """What is changed, as settings of the nightly experiment; files of our own go to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    robot = locate("robot", "eros").read_text()
    swapped = folder / "eros_swapped.py"
    swapped.write_text(robot.replace(f"np.clip({ANKLE}", f"np.clip(-{ANKLE}"))
    slippery = ", ".join(str(_slippery(name, folder)) for name in SURFACES)
    return {
        "friction -10 %": [f"surfaces=[{slippery}]"],
        "servo latency +8 ms": [f"servo.latency={LATE}"],
        "step height -5 mm": [f"gait.step_height={LOW_STEP}"],
        "ankle pitch with the wrong sign": [f"robot={swapped}"],
    }


def _slippery(name: str, folder: Path) -> Path:
    """A shipped ground with less friction, under the same name."""
    text = locate("surface", name).read_text()
    file = folder / f"{name}.yaml"
    pattern = r"^(friction: \{value: )([0-9.]+)"
    less = re.sub(
        pattern, lambda m: f"{m[1]}{float(m[2]) * LESS_FRICTION:.4g}", text, flags=re.MULTILINE
    )
    file.write_text(less)
    return file


def walked(experiment: Experiment, store: Store, jobs: int) -> Baseline:
    """The walks of an experiment, simulated as far as they are missing."""
    dispatch(experiment, store, jobs=jobs)
    return record(experiment, store)


def nights(pool: Baseline, count: int, *, paired: bool) -> Iterator[tuple[Baseline, Baseline]]:
    """Baseline and tonight, each with half of the seeds.

    Paired, a walk of tonight counts as the partner of one of the baseline, drawn anew in every
    cell: equal seeds whose course chance has changed. Unpaired, a seed goes to one side with all
    its cells, because it draws the same servos in each.
    """
    rng = np.random.default_rng(20)
    seeds = sorted({walk.seed for walk in pool.walks})
    half = len(seeds) // 2
    for _ in range(count):
        halves: tuple[list[Walk], list[Walk]] = ([], [])
        order = rng.permutation(seeds).tolist()
        for walks in pool.cells.values():
            if paired:
                order = rng.permutation(seeds).tolist()
            place = {seed: divmod(rank, half) for rank, seed in enumerate(order[: 2 * half])}
            for walk in (walk for walk in walks if walk.seed in place):
                side, rank = place[walk.seed]
                halves[side].append(replace(walk, seed=rank) if paired else walk)
        before, tonight = (replace(pool, walks=tuple(walks)) for walks in halves)
        yield before, tonight


def alarm_row(name: str, pool: Baseline, count: int, *, paired: bool) -> str:
    """False alarms of one pool and way of matching."""
    outcomes = [compared(*night) for night in nights(pool, count, paired=paired)]
    alarms = sum(bool(outcome.worse) for outcome in outcomes)
    low, high = wilson(alarms, count)
    drop = next(q for q in outcomes[0].quantities if q.name == "stable").detectable
    matching = "paired" if paired else "fresh seeds"
    return (
        f"| {name} | {matching} | {outcomes[0].runs.n} | {count} | {alarms} | "
        f"{100 * alarms / count:.1f} % [{100 * low:.1f}, {100 * high:.1f}] | "
        f"{100 * drop:.0f} points |"
    )


def detection_row(name: str, matching: str, outcome: Outcome) -> str:
    """What the gate says of one regression."""
    stable = outcome.quantities[0]
    found = "; ".join(f"{q.name} {q.surface}".strip() for q in outcome.worse) or "**nothing**"
    needed = "" if outcome.worse else _needed(outcome.quantities, outcome.runs.n)
    change = f"{100 * stable.before:.0f} -> {100 * stable.tonight:.0f} %"
    return f"| {name} | {matching} | {outcome.runs.n} | {change} | {found} | {needed} |"


def _needed(quantities: Sequence[Quantity], n: int) -> str:
    """Walks a side with which what came nearest to a finding would be one, four times in five."""
    seen = float(norm.isf(min(quantity.p_worse for quantity in quantities)))
    if seen <= 0.0:
        return "no change for the worse was seen"
    wanted = float(norm.isf(FALSE_ALARMS / len(quantities)) + norm.ppf(POWER))
    return f"some {ceil(n * (wanted / seen) ** 2)} walks"


def split(before: Baseline, tonight: Baseline) -> tuple[Baseline, Baseline]:
    """Half of the seeds of one and the other half of the other, so that none is shared."""
    middle = sorted({walk.seed for walk in before.walks})[len({w.seed for w in before.walks}) // 2]
    first = tuple(walk for walk in before.walks if walk.seed < middle)
    second = tuple(walk for walk in tonight.walks if walk.seed >= middle)
    return replace(before, walks=first), replace(tonight, walks=second)


def main() -> None:
    """Walk what is missing and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--store", type=Path, required=True)
    parser.add_argument("--pool", nargs="*", default=[], metavar="EXPERIMENT:STORE")
    parser.add_argument("--nights", type=int, default=200)
    parser.add_argument("--seeds", type=int, default=24, help="of the nightly pool; 0 leaves it")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    store = Store(options.store)
    pools = [entry.split(":") for entry in options.pool]
    found = {name: record(load_experiment(name), Store(Path(path))) for name, path in pools}
    if options.seeds:
        pool = load_experiment(NIGHTLY, seeds=options.seeds)
        found = {NIGHTLY: walked(pool, store, options.jobs), **found}
    print(f"False alarms; at most {FALSE_ALARMS:.0%} of nights is stated.\n")
    print("| pool | matching | walks a side | nights | alarms | share [95 %] | would notice |")
    print("|---|---|---|---|---|---|---|")
    for name, walks in found.items():
        for paired in (True, False):
            print(alarm_row(name, walks, options.nights, paired=paired), flush=True)
    before = walked(load_experiment(NIGHTLY), store, options.jobs)
    print(
        "\nDetection.\n\n| change | matching | walks a side | stable | found worse | else needs |"
    )
    print("|---|---|---|---|---|---|")
    for name, settings in regressions(options.store / "regressions").items():
        tonight = walked(load_experiment(NIGHTLY, settings), store, options.jobs)
        print(detection_row(name, "same seeds", compared(before, tonight)))
        print(detection_row(name, "fresh seeds", compared(*split(before, tonight))), flush=True)


if __name__ == "__main__":
    main()
