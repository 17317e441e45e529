"""How often the nightly gate cries wolf, and what it catches: a Markdown table of each.

    python benchmarks/gate.py --store STORE [--nights 2000] [--jobs 1] [--regressions]

Walks the nightly experiment with some more seeds than it has, once: a second call simulates
nothing. Nights are then drawn from these walks, in which nothing changed, in three ways:

- one partner for all cells: a seed of the baseline is compared with another seed, the same one in
  every cell, as if what a seed draws had been drawn anew;
- a partner in each cell: with another seed in each, as if only the course of each walk had;
- fresh seeds: both sides without a common seed.

Power: the same nights, in which walks of tonight are made to fall or a metric is made worse.
`--regressions` walks four changes of the robot as well, which takes four times as long.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import TypeAlias

import numpy as np
from scipy.stats import norm

from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.plugins import locate
from gaitlab.regression import Baseline, GateResult, compared, record
from gaitlab.regression.baseline import Walk
from gaitlab.regression.matching import matched
from gaitlab.regression.quantities import FALSE_ALARMS, Quantity, tested
from gaitlab.running import dispatch
from gaitlab.statistics import wilson
from gaitlab.store import Store, listed

NIGHTLY = "nightly"
ALL, EACH, FRESH = "one for all cells", "one in each cell", "fresh seeds"
MOST_CHANGED = 300  # nights of each change; their share scatters by 3 points
Change: TypeAlias = Callable[[Walk, np.random.Generator], Walk]
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
    grounds = load_experiment(NIGHTLY).parts.surfaces
    slippery = ", ".join(str(_slippery(name, folder)) for name in grounds)
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


def nights(
    pool: Baseline, count: int, how: str, change: Change
) -> Iterator[tuple[Baseline, Baseline]]:
    """Baseline and tonight, with as many seeds as the nightly experiment has.

    Every seed of a night is an ordered pair of two seeds of the pool, drawn anew, so that either
    of the two is as likely to be tonight's. Without common seeds, each side has seeds of its own.
    """
    rng = np.random.default_rng(20)
    cells = [{walk.seed: walk for walk in walks} for walks in pool.cells.values()]
    names = sorted(set.intersection(*(set(cell) for cell in cells)))
    n = len({found.seed for found in map(listed, plan(load_experiment(NIGHTLY)).trials())})
    for _ in range(count):
        pairs = _pairs(rng, names, n)
        sides: tuple[list[Walk], list[Walk]] = ([], [])
        for cell in cells:
            if how == EACH:
                pairs = _pairs(rng, names, n)
            for seed, (then, now) in enumerate(pairs):
                sides[0].append(replace(cell[then], seed=seed))
                tonight = replace(cell[now], seed=seed + (n if how == FRESH else 0))
                sides[1].append(change(tonight, rng))
        before, tonight_walks = (replace(pool, walks=tuple(walks)) for walks in sides)
        yield before, tonight_walks


def _pairs(rng: np.random.Generator, names: list[int], n: int) -> list[tuple[int, int]]:
    drawn = [rng.choice(len(names), 2, replace=False) for _ in range(n)]
    return [(names[first], names[second]) for first, second in drawn]


def same(walk: Walk, rng: np.random.Generator) -> Walk:
    """No change."""
    return walk


def falling(share: float) -> Change:
    """This share of the walks that stay up falls."""

    def change(walk: Walk, rng: np.random.Generator) -> Walk:
        lost = {"stable": False, "stable_strict": False} if rng.random() < share else {}
        return replace(walk, metrics={**walk.metrics, **lost})

    return change


def scaled(name: str, factor: float) -> Change:
    """A metric is this many times what it was."""

    def change(walk: Walk, rng: np.random.Generator) -> Walk:
        value = walk.metrics[name]
        moved = {} if value is None else {name: factor * float(value)}
        return replace(walk, metrics={**walk.metrics, **moved})

    return change


CHANGES = {
    "one in ten stable walks falls": ("stable", falling(0.1)),
    "one in four stable walks falls": ("stable", falling(0.25)),
    "half of the stable walks fall": ("stable", falling(0.5)),
    "pitch amplitude +10 %": ("pitch_amplitude", scaled("pitch_amplitude", 1.1)),
    "cost of transport +5 %": ("cost_of_transport", scaled("cost_of_transport", 1.05)),
    "distance -10 %": ("distance", scaled("distance", 0.9)),
}


def night_row(
    pool: Baseline, count: int, how: str, name: str, quantity: str, change: Change
) -> str:
    """Nights with an alarm; of this quantity if one is named."""
    alarms = 0
    for before, tonight in nights(pool, count, how, change):
        worse = [q.name for q in tested(matched(before, tonight)) if q.finding == "worse"]
        alarms += quantity in worse if quantity else bool(worse)
    low, high = wilson(alarms, count)
    return (
        f"| {name} | {how} | {count} | {alarms} | "
        f"{100 * alarms / count:.1f} % [{100 * low:.1f}, {100 * high:.1f}] |"
    )


def notice(pool: Baseline) -> Iterator[str]:
    """What the page of a night without any change says that it would notice."""
    for how in (ALL, FRESH):
        for quantity in compared(*next(nights(pool, 1, how, same))).quantities:
            on = quantity.surface or "all"
            yield (
                f"| {quantity.name} | {on} | {how} | {quantity.n} | {quantity.seeds} | "
                f"{quantity.before:.3g} | {quantity.detectable:.2g} |"
            )


def detection_row(name: str, matching: str, outcome: GateResult) -> str:
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
    """Walk what is missing and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--store", type=Path, required=True)
    parser.add_argument("--nights", type=int, default=2000)
    parser.add_argument("--seeds", type=int, default=30, help="that nights draw from")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--regressions", action="store_true", help="walk four changes as well")
    options = parser.parse_args()
    store = Store(options.store)
    pool = walked(load_experiment(NIGHTLY, seeds=options.seeds), store, options.jobs)
    stable = sum(walk.stable for walk in pool.walks)
    print(f"Drawn from {len(pool.walks)} walks of {options.seeds} seeds, {stable} stable.\n")
    print(f"False alarms; at most {FALSE_ALARMS:.0%} of nights is stated. Then power.\n")
    print("| change | partner | nights | alarms | share [95 %] |\n|---|---|---|---|---|")
    for how in (ALL, EACH, FRESH):
        print(night_row(pool, options.nights, how, "none", "", same), flush=True)
    for name, (quantity, change) in CHANGES.items():
        for how in (ALL, EACH, FRESH):
            count = min(options.nights, MOST_CHANGED)
            print(night_row(pool, count, how, name, quantity, change), flush=True)
    print("\nWould notice, as the page of the first night says.\n")
    print(
        "| quantity | on | partner | n | seeds | baseline | loss |\n|---|---|---|---|---|---|---|"
    )
    print("\n".join(notice(pool)), flush=True)
    if options.regressions:
        detect(store, options.jobs)


def detect(store: Store, jobs: int) -> None:
    """Print what the gate says of changes that were walked."""
    before = walked(load_experiment(NIGHTLY), store, jobs)
    print(
        "\nDetection.\n\n| change | matching | walks a side | stable | found worse | else needs |"
    )
    print("|---|---|---|---|---|---|")
    for name, settings in regressions(store.path / "regressions").items():
        tonight = walked(load_experiment(NIGHTLY, settings), store, jobs)
        print(detection_row(name, "same seeds", compared(before, tonight)))
        print(detection_row(name, "fresh seeds", compared(*split(before, tonight))), flush=True)


if __name__ == "__main__":
    main()
