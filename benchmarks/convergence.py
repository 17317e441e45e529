"""How many solver iterations and how small a time step a walk needs.

Walks the same gait with the same seeds under several settings and compares what a report would
state with the finest one: share of falls, distance, pitch amplitude. The spread between seeds is
printed beside it, because a difference well below it does not matter.

    python benchmarks/convergence.py [--seeds 6] [--jobs 2]
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.metrics import measure
from gaitlab.simulation.simulate import simulate

SURFACES = ("carpet_4mm", "grass_30mm")
FINEST = (1e-3, 200)
SETTINGS = [FINEST, *((2e-3, n) for n in (200, 100, 50, 30, 20, 10))]


class Walk(NamedTuple):
    """What one walk gave, and its CPU time a simulated second in [s]."""

    fell: float
    distance: float
    pitch_amplitude: float
    cost: float


def walk(surface: str, dt: float, iterations: int, seed: int) -> Walk:
    """One plain walk with 6 cm steps."""
    settings = [
        f"surfaces=[{surface}]", "grid={gait.step_length: [0.06]}", f"seeds=[{seed}]",
        f"engine.dt={dt}", f"engine.solver_iterations={iterations}", "horizon.cycles=6",
    ]  # fmt: skip
    trial = next(iter(plan(load_experiment("eros_table7", settings)).trials())).trial
    start = time.process_time()
    log = simulate(trial)
    cost = (time.process_time() - start) / (len(log) * dt)
    found = measure(log)
    amplitude = np.degrees(float(found["pitch_amplitude"]))
    return Walk(float(found["fell"]), float(found["distance"]), amplitude, cost)


def main() -> None:
    """Print a row for each surface and setting."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    cases = list(product(SURFACES, SETTINGS, range(options.seeds)))
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        futures = {c: pool.submit(walk, c[0], *c[1], c[2]) for c in cases}
        found = {case: future.result() for case, future in futures.items()}
    print("| surface | dt [s] | iterations | fell | distance [m] | pitch +- [deg] | CPU s / s |")
    print("|---|---|---|---|---|---|---|")
    for surface, setting in product(SURFACES, SETTINGS):
        walks = [found[surface, setting, seed] for seed in range(options.seeds)]
        fell, distance, pitch, cost = np.array(walks).T
        print(
            f"| {surface} | {setting[0]} | {setting[1]} | {int(fell.sum())}/{options.seeds} "
            f"| {np.mean(distance):.3f} (sd {np.std(distance, ddof=1):.3f}) "
            f"| {np.nanmean(pitch):.2f} (sd {np.nanstd(pitch, ddof=1):.2f}) | {np.mean(cost):.3f} |"
        )


if __name__ == "__main__":
    main()
