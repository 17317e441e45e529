"""What a closed loop adds to a tick: the IMU, the controller and its correction.

Nothing is simulated: both loops are asked for their targets and told of a trunk that sways, and the
median of their difference in CPU time a tick is printed.

    python benchmarks/balance.py [--rounds 15]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from statistics import median

import numpy as np

from gaitlab.balance.ankle_hip import Balance
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.simulation.loop import Loop, loop_of
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import plugin


def swaying(ticks: int) -> np.ndarray:
    """A trunk that rolls and pitches a little, as rows of a tape."""
    half = 0.02 * np.sin(0.01 * np.arange(ticks))
    rows = np.zeros((ticks, 13))
    rows[:, 3], rows[:, 4], rows[:, 6] = half, half, np.cos(half)
    rows[:, 10:12] = 0.1, 0.2
    return rows


def seconds_a_tick(loop: Loop, trunk: np.ndarray) -> float:
    """CPU time of a tick, in [s]."""
    start = time.process_time()
    tape = Tape(len(trunk), 0)
    tape.trunk[:] = trunk
    loop.begin(trunk[0])
    tick = 0
    while tick < len(trunk):
        tape.length = tick + len(loop.targets(tick))
        loop.feel(tape, tick)
        tick = tape.length
    return (time.process_time() - start) / len(trunk)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15, help="rounds, each a walk of 8 s")
    rounds = parser.parse_args().rounds
    walk = next(plan(load_experiment("eros_quick")).trials()).trial
    gains = replace(Balance(), hip_roll_gain=0.1, step_pitch_gain=0.1, swing_level=0.1)
    closed = replace(walk, balance=gains, balance_code=plugin("balance", "ankle_hip"))
    states = swaying(4000)
    feet = walk.gait.feet(np.arange(len(states)) * walk.engine.dt)
    targets = walk.robot.joint_targets(feet)
    added = [
        seconds_a_tick(loop_of(closed, feet, targets), states)
        - seconds_a_tick(loop_of(walk, feet, targets), states)
        for _ in range(rounds)
    ]
    print(f"a closed loop adds {1e6 * median(added):.1f} us a tick (median of {rounds} rounds)")


if __name__ == "__main__":
    main()
