"""The search behind the gait constants of `experiments/bases/eros.yaml`.

Random candidates for rhythm, stance and servo gain walk the plain gait up a ladder of step lengths
on the carpet and the hard floor, where a team tunes its robot; no grass is looked at. A rung counts
its share of three runs that stayed up and covered half of the commanded distance.

    python benchmarks/carpet_search.py [--seed 1] [--candidates 25]
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.experiment import load_experiment
from gaitlab.plan import plan
from gaitlab.settings import Horizon
from gaitlab.simulate import simulate
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import Trial

LADDER = (0.0, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, -0.04, -0.08)  # m
RUNS = (("carpet_4mm", 0), ("hard_floor", 1), ("carpet_4mm", 2))  # surface and seed
RANGES = {
    "tick_increment": (np.radians(3.5), np.radians(8.0)),
    "lateral_sway": (0.012, 0.045),
    "step_height": (0.012, 0.04),
    "hip_height": (0.214, 0.228),
    "com_offset": (-0.008, 0.015),
}
LEANS = (0.0, 0.12)  # rad; half of the candidates stand upright
GAINS = (17.0, 30.0, 45.0, 60.0, 90.0)  # 1/s, from the factory's up

Candidate = dict[str, float]


def candidate(rng: np.random.Generator) -> tuple[Candidate, float]:
    """Gait constants and a servo gain."""
    gait = {name: float(rng.uniform(*limits)) for name, limits in RANGES.items()}
    gait["trunk_pitch"] = float(rng.choice([0.0, rng.uniform(*LEANS)]))
    return gait, float(rng.choice(GAINS))


def stays_up(base: Trial, gait: Candidate, gain: float, surface: str, seed: int) -> bool:
    """Whether one run stays up and covers half of its commanded distance."""
    trial = replace(
        base,
        gait=replace(base.gait, **gait),
        servos=tuple(replace(servo, position_gain=gain) for servo in base.servos),
        surface=load_surface(surface),
        horizon=Horizon(cycles=6),
        seed=seed,
    )
    try:
        log = simulate(trial)
    except Infeasible:
        return False
    return log.fall_index is None and not log.stalled


def climb(base: Trial, gait: Candidate, gain: float) -> list[float]:
    """Share of runs on each rung; stops early on a candidate that falls at its foot."""
    shares: list[float] = []
    for step_length in LADDER:
        here = {**gait, "step_length": step_length}
        first = stays_up(base, here, gain, *RUNS[0])
        rest = [first and stays_up(base, here, gain, *run) for run in RUNS[1:]]
        shares.append((first + sum(rest)) / len(RUNS))
        if not first and sum(shares) < 3.0:
            break
    return shares


def main() -> None:
    """Print every candidate as it is done, the best last."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--candidates", type=int, default=25)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    base = next(iter(plan(load_experiment("eros_table7")).trials())).trial
    found = []
    for _ in range(options.candidates):
        gait, gain = candidate(rng)
        shares = climb(base, gait, gain)
        found.append((sum(shares), gain, {k: round(v, 4) for k, v in gait.items()}))
        print(f"{sum(shares):.2f} of {len(LADDER)}", *found[-1][1:], flush=True)
    print("best:", *max(found, key=lambda entry: entry[0]))


if __name__ == "__main__":
    main()
