"""The searches behind the constants of `experiments/eros_frozen.yaml`.

    python benchmarks/calibration.py ground [--candidates 60] [--minutes 30]
    python benchmarks/calibration.py gains

`ground` looks for three constants of the pile that all pedestals share, and the lift of the foot,
with which the plain gait stands and falls as the forward rows of the EROS paper's Table 7 say.
`gains` looks for the gains of heel strike and landing deceleration on the carpet and one grass of
Table 8; its other two grasses stay unseen. Both minimise the sum over cells of |share of stable
seeds - published verdict|; a candidate that is worse than the best before its last cell stops.
The best four walk six more seeds each, and the smallest loss over all ten seeds wins. The seeds are
none that a prediction uses.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing import Pool
from multiprocessing.pool import Pool as PoolOfWorkers

import optuna

from gaitlab.errors import Infeasible
from gaitlab.experiment import Experiment, candidate, load_experiment
from gaitlab.metrics import measure
from gaitlab.plan import plan
from gaitlab.simulate import simulate
from gaitlab.trial import Trial

SEEDS = tuple(range(1000, 1004))  # of the search
MORE_SEEDS = tuple(range(1004, 1010))  # of the final
FINALISTS = 4
Values = dict[str, str] | dict[str, float] | dict[str, str | float]  # by dotted path
Cell = tuple[str, float]  # ground, and step length in [m]: half of a row's foot travel
S, U = 1.0, 0.0


@dataclass(frozen=True)
class Search:
    """What is searched on which cells.

    Attributes:
        experiment: Base, the constants found so far in it.
        fixed: What makes the gait of the table that is answered to.
        ranges: Low, high and whether on a logarithmic scale, by dotted path.
        start: Candidates to begin with, in the order of the ranges.
        verdicts: Published verdicts, those first that tell candidates apart soonest.
    """

    experiment: str
    fixed: dict[str, str]
    ranges: dict[str, tuple[float, float, bool]]
    start: tuple[tuple[float, ...], ...]
    verdicts: dict[Cell, float]


GROUND = Search(
    experiment="eros_table7",
    fixed={},
    ranges={
        "surface.toe_catch": (1.0, 15.0, True),
        "surface.vertical_scale": (0.3, 3.0, True),
        "surface.friction_scale": (0.7, 1.3, False),
        "gait.step_height": (0.016, 0.034, False),
    },
    start=((3.0, 1.0, 1.0, 0.0277), (8.0, 1.0, 1.0, 0.0225), (5.0, 0.75, 1.0, 0.0277)),
    verdicts={
        ("grass_30mm", 0.02): U,
        ("grass_10mm", 0.06): U,
        ("grass_10mm", 0.04): S,
        ("grass_50mm", 0.0): S,
        ("grass_30mm", 0.0): S,
        ("grass_50mm", 0.02): U,
        ("carpet_4mm", 0.10): S,
        ("carpet_4mm", 0.12): U,
        ("grass_10mm", 0.02): S,
        ("grass_30mm", 0.04): U,
        ("grass_50mm", 0.04): U,
        ("grass_10mm", 0.08): U,
        ("carpet_4mm", 0.08): S,
        ("grass_30mm", 0.06): U,
        ("carpet_4mm", 0.04): S,
        ("grass_10mm", 0.0): S,
        ("grass_50mm", 0.06): U,
    },
)
GAINS = Search(
    experiment="eros_frozen",
    fixed={"gait.heel_strike": "add", "gait.landing_deceleration": "log_tail"},
    ranges={
        "gait.heel_gain": (0.1, 1.2, True),
        "gait.deceleration_gain": (0.05, 0.9, False),
        "gait.deceleration_areas": (3, 10, False),
    },
    start=((0.2865, 0.7, 5), (0.2865, 0.2, 5), (0.15, 0.4, 5)),
    verdicts={
        ("grass_30mm", 0.04): S,
        ("carpet_4mm", 0.08): S,
        ("grass_30mm", 0.08): S,
        ("grass_30mm", 0.02): S,
        ("carpet_4mm", 0.12): S,
        ("grass_30mm", 0.06): S,
        ("grass_30mm", 0.10): U,
        ("grass_30mm", 0.0): S,
        ("carpet_4mm", 0.04): S,
        ("carpet_4mm", 0.10): S,
        ("carpet_4mm", 0.0): S,
        ("grass_30mm", 0.12): U,
    },
)


def stable(trial: Trial) -> bool:
    """Whether one walk stays up; what cannot be walked does not."""
    try:
        return bool(measure(simulate(trial))["stable"])
    except Infeasible:
        return False


def trials(base: Experiment, values: Values, cell: Cell) -> Iterator[Trial]:
    surface, step_length = cell
    made = candidate(base, {**values, "gait.step_length": step_length})
    for planned in plan(made).trials():
        if planned.trial.names.surface == surface:
            yield planned.trial


def loss_of(
    pool: PoolOfWorkers, search: Search, values: Values, seeds: tuple[int, ...], best: float
) -> tuple[float, dict[str, float]]:
    """Loss, and share of each cell that was walked; each other one is taken to add 0.4."""
    base = load_experiment(search.experiment, [f"seeds={list(seeds)}"])
    loss, shares = 0.0, dict[str, float]()
    cells = list(search.verdicts.items())
    for place in range(0, len(cells), 2):
        pair = cells[place : place + 2]
        walks = [list(trials(base, {**search.fixed, **values}, cell)) for cell, _ in pair]
        ended = iter(pool.map(stable, [trial for part in walks for trial in part], chunksize=1))
        for (cell, verdict), part in zip(pair, walks, strict=True):
            share = sum(next(ended) for _ in part) / len(part)
            shares[f"{cell[0]}:{cell[1]:g}"] = share
            loss += abs(share - verdict)
        if loss > best + 0.75:
            return loss + 0.4 * (len(cells) - place - len(pair)), shares
    return loss, shares


def final(pool: PoolOfWorkers, search: Search, found: list[tuple[float, Values]]) -> None:
    """Print the finalists with more seeds, and the loss over all of them."""
    total, more = len(SEEDS) + len(MORE_SEEDS), len(MORE_SEEDS)
    for loss, values in sorted(found, key=lambda entry: entry[0])[:FINALISTS]:
        again, shares = loss_of(pool, search, values, MORE_SEEDS, 99.0)
        pooled = (loss * len(SEEDS) + again * more) / total
        line = {"final": round(pooled, 3), "in_search": loss, "more": round(again, 3)}
        print(json.dumps({**line, **values, "shares": shares}), flush=True)


def main() -> None:
    """Print every candidate as it is done, then the finalists."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("search", choices=("ground", "gains"))
    parser.add_argument("--candidates", type=int, default=60)
    parser.add_argument("--minutes", type=float, default=30.0)
    options = parser.parse_args()
    search = {"ground": GROUND, "gains": GAINS}[options.search]
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(seed=1, n_startup_trials=14, multivariate=True)
    study = optuna.create_study(sampler=sampler)
    for start in search.start:
        study.enqueue_trial(dict(zip(search.ranges, start, strict=True)))

    def objective(trial: optuna.Trial) -> float:
        values: dict[str, float] = {}
        for path, (low, high, log) in search.ranges.items():
            suggest = trial.suggest_int if isinstance(low, int) else trial.suggest_float
            values[path] = suggest(path, low, high, log=log)
        done = [t.value for t in study.trials if t.value is not None]
        began = time.monotonic()
        loss, shares = loss_of(pool, search, values, SEEDS, min(done, default=99.0))
        line = {"n": trial.number, "loss": round(loss, 3), "s": round(time.monotonic() - began)}
        print(json.dumps({**line, **values, "shares": shares}), flush=True)
        return loss

    with Pool(2) as pool:
        study.optimize(objective, n_trials=options.candidates, timeout=60.0 * options.minutes)
        ended = [t for t in study.trials if t.value is not None]
        final(pool, search, [(float(t.value), t.params) for t in ended if t.value is not None])


if __name__ == "__main__":
    main()
