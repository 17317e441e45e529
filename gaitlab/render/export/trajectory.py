"""What a gait sent the joints, as a file that `gait: {type: trajectory}` walks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gaitlab.motions.trajectory import trajectory_text
from gaitlab.render.export.recorded import ExportedTrial
from gaitlab.simulation.simulate import commanded

EXPORTED = "exported by gaitlab"


def write_trajectory(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Targets of every joint with a servo, up to the horizon, even if the robot fell before.

    They are made anew from the trial, to every digit; what a balance controller added is not among
    them, as it adds it again to whoever walks them. The head says what to write into an experiment.
    """
    trial = shown.trial
    gait, joints = trial.gait, trial.robot.tree.joints
    _, targets = commanded(trial)
    driven = [k for k, joint in enumerate(joints) if joint.servo is not None]
    meant = {
        "period": gait.gait_period,
        "repeat": "false",
        "step_length": gait.step_length,
        "side_step": getattr(gait, "side_step", 0.0),
        "turn": getattr(gait, "turn", 0.0),
        "stand_time": 0.0,
        "walk_start": gait.startup_time,
    }
    told = ", ".join(f"{key}: {value}" for key, value in meant.items())
    head = (
        f"{EXPORTED}: trial {shown.record.trial_id}, gait {trial.names.gait}",
        f"walked, by its name, as gait: {{type: trajectory, file: ./walk.csv, {told}}}",
    )
    time = np.arange(len(targets)) * trial.engine.dt
    names = [joints[k].name for k in driven]
    files[0].write_text(trajectory_text(time, names, targets[:, driven], head), encoding="utf-8")
