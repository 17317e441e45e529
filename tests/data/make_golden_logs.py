"""Identity and a few numbers of a short log of every shipped robot on every ground.

    python tests/data/make_golden_logs.py

makes golden_logs.json again: after PHYSICS_VERSION was raised, for then they differ on purpose.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitlab.experiment import is_reproduction, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.log import TrialLog
from gaitlab.model.gait import FeetPoses, Gait, first_step
from gaitlab.model.settings import Horizon
from gaitlab.plugins import names
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import PHYSICS_VERSION, Trial

FILE = Path(__file__).with_name("golden_logs.json")
REFERENCE = "engine.name=bullet"  # whatever is installed
INSTANTS = (0.01, 0.05, 0.1, 0.15, 0.2)  # s
STANDING = 0.05  # s, of it before the first commanded step
SHORTEST = 0.1  # s, the shortest horizon of a trial
LONGEST = 5.0  # s, in which every shipped gait has begun its first step
# By how much another processor may be off beside 1e-6 of the number, the precision of a log being
# 6e-8. Far more than the last bits: a start that is 1e-10 m elsewhere moved no number by more than
# 1e-9 m, 4e-9 rad or 1e-5 N. Far less than physics: 1 % of a servo's stall torque moves torques by
# 0.01 N m and more on every robot and ground.
SLACK = {
    **{"trunk_x": 1e-7, "trunk_z": 1e-7, "roll": 1e-7, "pitch": 1e-7},  # m, rad
    **{"left_foot_normal_force": 1e-3, "right_foot_normal_force": 1e-3},  # N
    "torque": 1e-4,  # N m, over all joints
}

Numbers = dict[str, list[float]]


@dataclass(frozen=True)
class Late:
    """A gait that is joined late, and whose start-up is taken to be over early."""

    gait: Gait
    joined: float
    startup_time: float = SHORTEST

    def __getattr__(self, name: str) -> Any:
        return getattr(self.gait, name)

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Those of the gait itself, later."""
        return self.gait.feet(t + self.joined)


def trials() -> dict[str, Trial]:
    """Every shipped robot on every ground with its own gait, by the names of both."""
    planned = plan(load_experiment("all_robots", ["seeds=1", REFERENCE])).trials()
    return {f"{p.trial.robot.name} on {p.trial.names.surface}": p.trial for p in planned}


def ids() -> dict[str, str]:
    """One digest over the ids of the first seed of every shipped experiment, by its name."""
    digests = {}
    for name in (name for name in names("experiment") if not is_reproduction(name)):
        planned = plan(load_experiment(name, ["seeds=1", REFERENCE])).trials()
        told = "\n".join(item.trial.id for item in planned)
        digests[name] = hashlib.sha256(told.encode()).hexdigest()[:16]
    return digests


def numbers(trial: Trial) -> Numbers:
    """The quantities of `SLACK` at `INSTANTS`, the robot lifting a foot for the first time.

    So short a log is the same on another processor: with the instructions of the oldest one, in
    numba, numpy and the C library, all of them passed. Whole walks did not, for an encoder's count
    that falls the other way changes half a second later as much as another servo would.
    """
    dt = trial.engine.dt
    begins = first_step(trial.gait.feet(np.arange(round(LONGEST / dt)) * dt)) * dt
    late = Late(trial.gait, joined=begins - STANDING)
    return _sampled(simulate(replace(trial, gait=late, horizon=Horizon(time=SHORTEST))))


def _sampled(log: TrialLog) -> Numbers:
    rows = np.rint(np.array(INSTANTS) / log.header.dt).astype(int) - 1
    torque = np.abs(log.driven_table("torque")).sum(axis=1)
    columns = {name: torque if name == "torque" else log[name] for name in SLACK}
    return {name: [float(f"{x:.8g}") for x in column[rows]] for name, column in columns.items()}


def agreeing(stored: Numbers, found: Numbers) -> int:
    """How many of the stored instants agree before the first that does not."""
    count = len(stored["torque"])
    agree = np.ones(count, dtype=bool)
    for name, slack in SLACK.items():
        agree &= np.isclose(found[name][:count], stored[name], rtol=1e-6, atol=slack)
    return count if agree.all() else int(np.argmin(agree))


def moved(trial: Trial) -> Trial:
    """The trial from a start that is up to 1e-12 m and 1e-12 rad elsewhere."""
    spread = trial.spread
    near = replace(spread, position=spread.position * (1 + 1e-9), tilt=spread.tilt * (1 + 1e-10))
    return replace(trial, spread=near)


def main() -> None:
    """Simulate all of them and write what does not hang on the last bits of a start."""
    lines = []
    for name, trial in trials().items():
        found = numbers(trial)
        certain = agreeing(found, numbers(moved(trial)))
        kept = {quantity: values[:certain] for quantity, values in found.items()}
        lines.append(f"  {json.dumps(name)}: {json.dumps(kept)}")
        print(f"{name}: {certain} of {len(INSTANTS)} instants")
    logs = ",\n".join(lines)
    FILE.write_text(
        f'{{\n "physics_version": {PHYSICS_VERSION},\n "ids": {json.dumps(ids(), indent=2)},\n'
        f' "logs": {{\n{logs}\n }}\n}}\n',
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
