"""What a policy adds to a trial: a network of 256-128-64 units at 50 Hz beside the same targets.

The policy walks a trial, and a gait of joint angles walks what it sent, so that both simulate the
same. Rounds alternate; the median of the ratios of CPU times is printed.

    python benchmarks/policy.py [--rounds 15] [--engine bullet]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from statistics import median

import numpy as np

from gaitlab.gaits.policy import Gait
from gaitlab.gaits.trajectory import Gait as Recorded
from gaitlab.log import TrialLog
from gaitlab.motions.trajectory import trajectory_text
from gaitlab.simulation.engines import default_engine
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial, plugin
from tests.policies import save_network
from tests.trials import trial

UNITS = (256, 128, 64)


def written(folder: Path, inputs: int, outputs: int) -> Path:
    """A network that moves the joints by a little, and a declaration of all that one may be fed."""
    rng, sizes = np.random.default_rng(0), (inputs, *UNITS, outputs)
    layers = [(rng.normal(0.0, (0.5 / a) ** 0.5, (a, b)), np.zeros(b)) for a, b in pairwise(sizes)]
    file = save_network(folder / "walk.onnx", layers, activation="Elu")
    file.with_suffix(".yaml").write_text("layout: unitree_rl_gym\naction_scale: 0.002\n")
    return file


def seconds(of: Trial) -> tuple[float, TrialLog]:
    """CPU time of a trial, in [s], and its log."""
    start = time.process_time()
    log = simulate(of)
    return time.process_time() - start, log


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15, help="rounds, each a walk of 8 s twice")
    parser.add_argument("--engine", default=default_engine(), help="bullet or mujoco")
    given = parser.parse_args()
    walk = trial("carpet_4mm", cycles=10.0, engine={"name": given.engine})
    joints = [joint.name for joint in walk.robot.tree.joints]
    with tempfile.TemporaryDirectory() as name:
        file = written(Path(name), 11 + 3 * len(joints), len(joints))
        by_policy = replace(walk, gait=Gait(file=str(file)), gait_code=plugin("gait", "policy"))
        _, log = seconds(by_policy)
        rows = np.stack([log[f"{joint}_target"] for joint in joints], axis=-1).astype(float)
        table = Path(name) / "walk.csv"
        table.write_text(trajectory_text(np.arange(len(rows)) * walk.engine.dt, joints, rows, []))
        gait = Recorded(file=str(table), stand_time=0.0, period=0.8, repeat=False)
        recorded = replace(walk, gait=gait, gait_code=plugin("gait", "trajectory"))
        whole = replace(walk.horizon, cycles=1000.0, time=log.header.dt * len(log))
        recorded = replace(recorded, horizon=whole)
        if len(seconds(recorded)[1]) != len(log):
            raise SystemExit("the two trials are not as long")
        ratios = [seconds(by_policy)[0] / seconds(recorded)[0] for _ in range(given.rounds)]
    low, high = np.percentile(ratios, [25, 75])
    print(
        f"{given.engine}: a policy of {'-'.join(map(str, UNITS))} units at 50 Hz takes "
        f"{100.0 * (median(ratios) - 1.0):.1f} % more than what it sends (median of "
        f"{given.rounds} rounds of {len(log)} ticks, quartiles {100 * (low - 1):.1f} and "
        f"{100 * (high - 1):.1f} %)"
    )


if __name__ == "__main__":
    main()
