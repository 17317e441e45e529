"""What a trial costs beside Bullet itself, side by side in one process.

The bare loop drives the same robot, sole and solver on a hard plane with nothing but
`setJointMotorControlArray` and `stepSimulation`; the full one is `run_trial` as a worker does it:
targets, servos, ground, recording, measuring, writing. Rounds alternate and the ratio of medians
of CPU time a tick is printed, because the machine may be shared.

    python benchmarks/loop.py [--rounds 7] [--surfaces hard_floor carpet_4mm ...]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
import pybullet

from gaitlab.engine import Engine
from gaitlab.experiment import load_experiment
from gaitlab.plan import plan
from gaitlab.run import run_trial
from gaitlab.store import Store
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import Trial


def walking_trial(surface: str, seed: int) -> Trial:
    """A plain walk on the spot that lasts to its horizon."""
    settings = [f"surfaces=[{surface}]", "horizon.cycles=9"]
    planned = plan(load_experiment("eros_quick", settings)).trials()
    trial = next(iter(planned)).trial
    return Trial.from_dict({**trial.to_dict(), "seed": seed})


def bare(trial: Trial, ticks: int) -> float:
    """CPU seconds a tick of the bare loop."""
    feet = trial.gait.feet(np.arange(ticks) * trial.engine.dt)
    targets = trial.robot.joint_targets(feet).tolist()
    height = trial.robot.hip_offset() + trial.gait.hip_height
    with Engine(
        trial.robot, load_surface("hard_floor"), trial.servos, pose=np.array(targets[0]),
        height=height, settings=trial.engine, spread=trial.spread, seed=trial.seed,
    ) as engine:  # fmt: skip
        client, body, joints = engine._client, engine._body, engine._joints
        forces = [servo.stall_torque for servo in trial.servos]
        start = time.process_time()
        for target in targets:
            client.setJointMotorControlArray(
                body, joints, pybullet.POSITION_CONTROL, targetPositions=target, forces=forces
            )
            client.stepSimulation()
        return (time.process_time() - start) / ticks


def full(trial: Trial, folder: Path) -> tuple[float, int]:
    """CPU seconds a tick of a whole trial, and its ticks."""
    start = time.process_time()
    record = run_trial(trial.id, trial.to_dict(), folder)
    spent = time.process_time() - start
    ticks = len(Store(folder).log(record.trial_id))
    return spent / ticks, ticks


def main() -> None:
    """Print the ratio for each surface."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--surfaces", nargs="+", default=["hard_floor", "grass_30mm"])
    options = parser.parse_args()
    for surface in options.surfaces:
        compare(surface, options.rounds)


def compare(surface: str, rounds: int) -> None:
    """One surface: a warm-up round, then the counted ones."""
    ratios, bares, fulls = [], [], []
    for seed in range(rounds + 1):
        trial = walking_trial(surface, seed)
        with tempfile.TemporaryDirectory() as folder:
            spent, ticks = full(trial, Path(folder))
        plain = bare(trial, ticks)
        if seed:
            bares.append(plain), fulls.append(spent), ratios.append(spent / plain)
    print(
        f"{surface}: full {1e6 * median(fulls):.0f} us a tick, bare {1e6 * median(bares):.0f} us, "
        f"ratio {median(ratios):.2f} (from {min(ratios):.2f} to {max(ratios):.2f}, n = {rounds})"
    )


if __name__ == "__main__":
    main()
