"""The two searches behind the constants of EROS that nobody published.

    python benchmarks/calibration.py gait [--candidates 20 --variations 16]
    python benchmarks/calibration.py gains [--candidates 12 --variations 0]

Both walk on the carpet and the hard floor alone, where a team tunes its robot; no grass is looked
at. `gait` draws rhythm, stance and servo gain at random for the plain gait. `gains` then draws heel
strike and landing deceleration for the gait that was found, which both must be in. A candidate
climbs a ladder of step lengths forward and backward and counts, on each rung, its share of runs
that stayed up and covered half of the commanded distance. The best four are varied, the best four
of all walk as many runs again with other seeds, and the largest count over both wins. No
prediction uses these seeds.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from multiprocessing import Pool
from multiprocessing.pool import Pool as PoolOfWorkers
from typing import NamedTuple

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.model.settings import Horizon
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
from gaitlab.surfaces.files import load_surface

LADDER = (0.0, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, -0.04, -0.08)  # m
SEARCH = (("carpet_4mm", 1000), ("hard_floor", 1001), ("carpet_4mm", 1002))  # surface and seed
FINAL = (("hard_floor", 1003), ("carpet_4mm", 1004), ("hard_floor", 1005))
FINALISTS = 4

Candidate = dict[str, float | int | str]  # parameters of the gait, and `position_gain`


RANGES = {  # of the plain gait
    "tick_increment": (np.radians(3.5), np.radians(8.0)),  # rad
    "lateral_sway": (0.012, 0.045),  # m
    "step_height": (0.012, 0.04),  # m
    "hip_height": (0.214, 0.228),  # m
    "com_offset": (-0.008, 0.015),  # m
    "trunk_pitch": (0.0, 0.12),  # rad
}
SHARE = 0.12  # of its range, the standard deviation of a variation


def draw_gait(rng: np.random.Generator) -> Candidate:
    """Rhythm, stance and servo gain of the plain gait; half of the candidates stand upright."""
    ranges = {name: limits for name, limits in RANGES.items() if name != "trunk_pitch"}
    made: Candidate = {name: round(float(rng.uniform(*r)), 4) for name, r in ranges.items()}
    made["trunk_pitch"] = round(float(rng.choice([0.0, rng.uniform(0.0, 0.12)])), 4)
    made["position_gain"] = float(rng.choice([17.0, 30.0, 45.0, 60.0, 90.0]))  # the factory's up
    return made


def draw_gains(rng: np.random.Generator) -> Candidate:
    """C_H, C_DC and n of the optimised gait."""
    return {
        "heel_gain": round(float(np.exp(rng.uniform(np.log(0.1), np.log(1.2)))), 3),
        "deceleration_gain": round(float(rng.uniform(0.05, 0.9)), 3),
        "deceleration_areas": int(rng.integers(3, 11)),
        "heel_strike": "add",
        "landing_deceleration": "log_tail",
    }


def vary(rng: np.random.Generator, made: Candidate) -> Candidate:
    """A candidate near another one; what is drawn from a list or is a switch stays."""
    near = dict(made)
    for name, (low, high) in RANGES.items():
        if name in made:
            moved = float(made[name]) + SHARE * (high - low) * rng.standard_normal()
            near[name] = round(float(np.clip(moved, low, high)), 4)
    return near


SEARCHES: dict[str, Callable[[np.random.Generator], Candidate]] = {
    "gait": draw_gait,
    "gains": draw_gains,
}


def walks(base: Trial, made: Candidate, step: float, surface: str, seed: int) -> bool:
    """Whether one run stays up and covers half of its commanded distance."""
    gait = {name: value for name, value in made.items() if name != "position_gain"}
    trial = replace(
        base,
        gait=replace(base.gait, **gait, step_length=step),
        surface=load_surface(surface),
        horizon=Horizon(cycles=6),
        seed=seed,
    )
    if "position_gain" in made:
        servos = (replace(servo, position_gain=made["position_gain"]) for servo in base.servos)
        trial = replace(trial, servos=tuple(servos))
    try:
        log = simulate(trial)
    except Infeasible:
        return False
    return log.fall_index is None and not log.stalled


class Climb(NamedTuple):
    """How a candidate did: share of runs on each rung, in the order of the ladder."""

    made: Candidate
    shares: list[float]

    @property
    def total(self) -> float:
        return sum(self.shares)


def climb(base: Trial, runs: tuple[tuple[str, int], ...], patient: bool, made: Candidate) -> Climb:
    """The whole ladder; one that falls at its foot and is not to be patient with gives up."""
    shares: list[float] = []
    for step in LADDER:
        first = walks(base, made, step, *runs[0])
        rest = [(first or patient) and walks(base, made, step, *run) for run in runs[1:]]
        shares.append((first + sum(rest)) / len(runs))
        if not (first or patient) and sum(shares) < 3.0:
            break
    return Climb(made, shares)


def climbs(pool: PoolOfWorkers, base: Trial, candidates: list[Candidate]) -> list[Climb]:
    """Let candidates climb, print each as it is done; the best last."""
    tried = []
    for found in pool.imap(partial(climb, base, SEARCH, False), candidates):
        tried.append(found)
        print(json.dumps({"total": round(found.total, 2), **found.made}), flush=True)
    return sorted(tried, key=lambda each: each.total)


def main() -> None:
    """Print every candidate as it is done, then the finalists, the best last."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("search", choices=SEARCHES)
    parser.add_argument("--candidates", type=int, default=20)
    parser.add_argument("--variations", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    drawn = [SEARCHES[options.search](rng) for _ in range(options.candidates)]
    base = next(iter(plan(load_experiment("eros_table7")).trials())).trial
    with Pool(2) as pool:
        tried = climbs(pool, base, drawn)
        near = [vary(rng, tried[-1 - k % FINALISTS].made) for k in range(options.variations)]
        best = sorted([*tried, *climbs(pool, base, near)], key=lambda each: each.total)[-FINALISTS:]
        again = pool.map(partial(climb, base, FINAL, True), [each.made for each in best])
    both = zip(best, again, strict=True)
    for first, second in sorted(both, key=lambda pair: pair[0].total + pair[1].total):
        sums = [round(each.total, 2) for each in (first, second)]
        shares = [[round(share, 2) for share in each.shares] for each in (first, second)]
        print(json.dumps({"totals": sums, "shares": shares, **first.made}), flush=True)


if __name__ == "__main__":
    main()
