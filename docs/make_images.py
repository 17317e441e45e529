"""The pictures of the README, drawn from a simulated walk.

python docs/make_images.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gaitlab.experiment import load_experiment
from gaitlab.picture.robot import stance_at
from gaitlab.plan import plan
from gaitlab.report.figure_style import save
from gaitlab.report.picture import portrait
from gaitlab.simulate import simulate

FOLDER = Path(__file__).parent / "images"
SETTINGS = ["surfaces=[grass_30mm]", "grid={gait.step_length: [0.02]}", "seeds=[0]"]


def main() -> None:
    """EROS in mid-swing on 30 mm grass, at the instant in which its trunk is most upright."""
    trial = next(iter(plan(load_experiment("eros_table7", SETTINGS)).trials())).trial
    log = simulate(trial)
    mid_swing = np.flatnonzero(np.abs(log["gait_phase"] - 0.25) < 1e-3)
    tick = int(mid_swing[np.argmin(np.abs(log["pitch"][mid_swing]))])
    stance = stance_at(log, trial.robot.tree, trial.robot.sole, tick)
    save(portrait(stance, trial.surface), FOLDER, "eros_on_grass")


if __name__ == "__main__":
    main()
