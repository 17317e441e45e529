"""What a trial costs beside its engine: CPU time of each part for 4000 ticks, median of repeats.

A walk that stays up is simulated once; then each part that comes before and after the engine is
done again with what it had then. With `--against` another checkout does the same in turn, in
processes of its own, and the ratio of the medians is printed: the machine may be shared.

    python benchmarks/overhead.py [--rounds 3] [--repeats 31] [--against FOLDER]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.log import LogHeader, TrialLog
from gaitlab.metrics import measure
from gaitlab.model.clearance import require_apart
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import first_step, require_feet
from gaitlab.running.provenance import provenance
from gaitlab.simulation import simulate as simulation
from gaitlab.simulation.trial import Trial
from gaitlab.store import Store, TrialRecord

TICKS = 4000
WALKS = {  # each stays up; a serial robot, one with geared parallelograms, NAO, one on belts
    "eros": ("eros_quick", ["surfaces=[carpet_4mm]"]),
    "flow": (
        "flow_walk",
        ["surfaces=[carpet_4mm]", "robot.parallelogram=geared", "engine.solver_iterations=200"],
    ),
    "nao": ("all_robots", ["surfaces=[carpet_4mm]"]),
    "biped": ("all_robots", ["surfaces=[carpet_4mm]"]),
}
Times = dict[str, float]  # ms by part


def walk(robot: str) -> Trial:
    """A walk of `TICKS` ticks on the carpet."""
    name, settings = WALKS[robot]
    planned = plan(load_experiment(name, [*settings, "seeds=1"])).trials()
    trial = next(p.trial for p in planned if p.trial.robot.name == robot)
    time = TICKS * trial.engine.dt - trial.gait.startup_time
    return replace(trial, horizon=replace(trial.horizon, cycles=1e6, distance=1e3, time=time))


def simulated(trial: Trial) -> tuple[TrialLog, tuple[Any, ...]]:
    """The log of a trial, and what the columns are made from.

    Raises:
        SystemExit: If the robot fell; the parts of a shorter trial say nothing.
    """
    with patch.object(simulation, "log_of", wraps=simulation.log_of) as log_of:
        log = simulation.simulate(trial)
    if len(log) < TICKS or log.fall_index is not None:
        raise SystemExit(f"{trial.robot.name} fell after {len(log)} ticks; nothing to time")
    return log, log_of.call_args.args


def parts(trial: Trial, folder: Path) -> dict[str, Callable[[], object]]:
    """What a trial does beside its engine, by part."""
    log, made_from = simulated(trial)
    instants, header, data = np.arange(TICKS) * trial.engine.dt, log.header, trial.to_dict()
    feet = trial.gait.feet(instants)
    targets = joint_commands(trial.robot, feet)
    metrics, store, numbers = measure(log), Store(folder), count()

    def feet_of_a_fresh_gait() -> None:
        require_feet(replace(trial.gait).feet(instants), TICKS)
        first_step(feet)

    def headed() -> LogHeader:
        return simulation._header(trial)

    def written() -> None:
        record = TrialRecord(
            trial_id=f"{next(numbers):032x}",
            state="DONE",
            reason="",
            trial=data,
            metrics=metrics,
            provenance=provenance(0.0, "bullet"),
        )
        store.commit(record, log)

    return {
        "trial from its data": lambda: Trial.from_dict(dict(data)),
        "feet": feet_of_a_fresh_gait,
        "joint targets": lambda: joint_commands(trial.robot, feet),
        "legs apart": lambda: require_apart(trial.robot, targets, header.dt),
        "header": headed,
        "start": lambda: simulation.start_of(trial, feet),
        "columns": lambda: simulation.log_of(*made_from),
        "metrics": lambda: measure(TrialLog(header=header, arrays=log.arrays)),
        "writing": written,
    }


def timed(robot: str, repeats: int) -> Times:
    """Median CPU time of each part, in [ms]."""
    with tempfile.TemporaryDirectory() as folder:
        named = parts(walk(robot), Path(folder))
        spent: dict[str, list[float]] = {name: [] for name in named}
        for repeat in range(repeats + 1):  # the first one warms up
            for name, part in named.items():
                start = process_time()
                part()
                if repeat:
                    spent[name].append(1e3 * (process_time() - start))
    return {name: median(times) for name, times in spent.items()}


def elsewhere(checkout: Path, robot: str, repeats: int) -> Times:
    """The same by the code of a checkout, in a process of its own."""
    command = [sys.executable, __file__, "--json", "--repeats", str(repeats), "--robots", robot]
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True)
    times: Times = json.loads(done.stdout)[robot]
    return times


def compared(robot: str, here: Sequence[Times], there: Sequence[Times]) -> None:
    """Print a table of a robot's parts; medians over the rounds."""
    now = {name: median(times[name] for times in here) for name in here[0]}
    total = sum(now.values())
    print(f"\n{robot}: {total:.1f} ms of CPU time beside the engine for {TICKS} ticks")
    before = {name: median(times[name] for times in there) for name in now} if there else {}
    for name, time in {**now, "all": total}.items():
        line = f"  {name:<20} {time:7.2f} ms {100 * time / total:4.0f} %"
        if before:
            was = before.get(name, sum(before.values()))
            line += f"   before {was:7.2f} ms, {was / time:5.2f} times as much"
        print(line)


def main() -> None:
    """Time each robot here and, in turn, elsewhere."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--repeats", type=int, default=31)
    parser.add_argument("--robots", nargs="+", choices=WALKS, default=list(WALKS))
    parser.add_argument("--against", type=Path, help="another checkout")
    parser.add_argument("--json", action="store_true", help="one round here, as JSON")
    options = parser.parse_args()
    if options.json:
        print(json.dumps({robot: timed(robot, options.repeats) for robot in options.robots}))
        return
    root = Path(__file__).resolve().parents[1]
    for robot in options.robots:
        here: list[Times] = []
        there: list[Times] = []
        for _ in range(options.rounds):
            here.append(elsewhere(root, robot, options.repeats))
            if options.against:
                there.append(elsewhere(options.against.resolve(), robot, options.repeats))
        compared(robot, here, there)


if __name__ == "__main__":
    main()
