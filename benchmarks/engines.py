"""A tick in MuJoCo against a tick in Bullet, side by side in one process.

The same walk of EROS is simulated in both engines in turn, without a balance controller and with
one, and the medians of CPU time a tick and their ratio are printed. A tick is all that a trial
does in it: targets, servos, ground, engine, fall rule and tape.

    python benchmarks/engines.py [--rounds 9] [--surfaces hard_floor grass_30mm ...]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from math import inf
from statistics import median

import numpy as np

from gaitlab.balance.ankle_hip import Balance
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.log.course import Course
from gaitlab.model.commands import joint_commands
from gaitlab.simulation.ending import GOES_ON, Ending
from gaitlab.simulation.loop import loop_of
from gaitlab.simulation.simulate import engine_for
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial, plugin

SECONDS = 6.0  # of a walk


def walking(surface: str, engine: str, closed: bool, seed: int) -> Trial:
    """A plain walk of EROS."""
    settings = [f"surfaces=[{surface}]", f"engine.name={engine}"]
    trial = next(iter(plan(load_experiment("eros_quick", settings)).trials())).trial
    if closed:
        gains = replace(Balance(), hip_roll_gain=0.1, step_pitch_gain=0.1, swing_level=0.1)
        trial = replace(trial, balance=gains, balance_code=plugin("balance", "ankle_hip"))
    return replace(trial, seed=seed)


def seconds_a_tick(trial: Trial) -> float:
    """CPU time of a tick, in [s]; the robot has to stay up, for lying down costs another time."""
    dt, robot = trial.engine.dt, trial.robot
    feet = trial.gait.feet(np.arange(round(SECONDS / dt)) * dt)
    loop = loop_of(trial, feet, joint_commands(robot, feet))
    ticks = len(loop.sent)
    ending = Ending(dt=dt, standing_height=0.3, startup=0, distance=inf, course=Course(ahead=0.0))
    with engine_for(trial, feet) as engine:
        tape, code = Tape(ticks, len(robot.tree.joints)), GOES_ON
        start = time.process_time()
        loop.begin(engine.trunk)
        while code == GOES_ON and tape.length < ticks:
            before = tape.length
            code = engine.advance(loop.targets(before), tape, ending)
            loop.feel(tape, before)
        spent = time.process_time() - start
    if code != GOES_ON:
        raise SystemExit(f"the robot fell in {trial.engine.name}; its time says nothing")
    return spent / ticks


def main() -> None:
    """Print the ratio for each surface and loop."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9, help="rounds, each a walk in each engine")
    parser.add_argument("--surfaces", nargs="+", default=["hard_floor", "grass_30mm"])
    options = parser.parse_args()
    for surface in options.surfaces:
        for closed in (False, True):
            spent: dict[str, list[float]] = {"bullet": [], "mujoco": []}
            for seed in range(options.rounds + 1):
                for engine, times in spent.items():
                    times.append(seconds_a_tick(walking(surface, engine, closed, seed)))
            slow, fast = (1e6 * median(times[1:]) for times in spent.values())  # but the warm-up
            kind = "closed" if closed else "open"
            print(
                f"{surface}, {kind} loop: bullet {slow:.0f} us a tick, mujoco {fast:.1f} us, "
                f"{slow / fast:.1f} times, n = {options.rounds}"
            )


if __name__ == "__main__":
    main()
