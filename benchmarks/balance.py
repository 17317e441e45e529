"""What a closed loop adds to a tick: the IMU, the controller and its correction.

Nothing is simulated: both loops are asked for their targets and told of a trunk that sways, and the
median of their difference in CPU time a tick is printed.

    python benchmarks/balance.py [--rounds 15]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from math import cos, sin
from statistics import median

import numpy as np

from gaitlab.balance.ankle_hip import Balance
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.simulation.engine import TickState
from gaitlab.simulation.loop import Loop, loop_of
from gaitlab.simulation.trial import plugin


def swaying(tick: int) -> TickState:
    """A trunk that rolls and pitches a little."""
    half = 0.02 * sin(0.01 * tick)
    turned, nothing = (half, half, 0.0, cos(half)), (0.0, 0.0, 0.0)
    return TickState(nothing, turned, nothing, (0.1, 0.2, 0.0), np.zeros((3, 0)), ())


def seconds_a_tick(loop: Loop, states: list[TickState]) -> float:
    """CPU time of a tick, in [s]."""
    start = time.process_time()
    loop.feel(states[0])
    for tick, state in enumerate(states):
        loop.target(tick)
        loop.feel(state)
    return (time.process_time() - start) / len(states)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15, help="rounds, each a walk of 8 s")
    rounds = parser.parse_args().rounds
    walk = next(plan(load_experiment("eros_quick")).trials()).trial
    gains = replace(Balance(), hip_roll_gain=0.1, step_pitch_gain=0.1, swing_level=0.1)
    closed = replace(walk, balance=gains, balance_code=plugin("balance", "ankle_hip"))
    states = [swaying(tick) for tick in range(4000)]
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
