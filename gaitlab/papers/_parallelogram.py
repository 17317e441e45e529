"""FLoW's parallelograms simulated in two ways: one cycle of its walk on the carpet."""

from __future__ import annotations

from typing import Literal

import numpy as np

from gaitlab.gaits.flow import Gait
from gaitlab.log import TrialLog
from gaitlab.papers.page import Table
from gaitlab.robots.flow import Robot
from gaitlab.servos.files import load_servo
from gaitlab.settings import EngineSettings, Horizon, Spread
from gaitlab.simulate import simulate
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import Names, Trial, plugin

Model = Literal["serial", "geared"]
MODELS: tuple[Model, Model] = ("serial", "geared")
SURFACE = "carpet_4mm"
ITERATIONS = 200  # of the solver; with 50 the gears of a loaded leg do not converge
STAND = 0.3  # s, standing before the walk


def parallelogram_table() -> Table:
    """How well each model keeps the soles parallel to the pelvis, and what carries that."""
    return Table(
        title="Parallelograms by the ankle's command and by gears",
        text=(
            f"Start-up and one cycle of the walk on {SURFACE}, {ITERATIONS} iterations of the "
            "solver. Rods would let no sole pitch against the pelvis; with a commanded ankle it "
            "pitches by what the loaded hip and knee give way. The ankle's torque is what rods "
            "carry; gears carry it without a motor."
        ),
        header=("model", "largest sole pitch [degrees]", "ankle torque [N m]", "distance [m]"),
        rows=[_row(model) for model in MODELS],
    )


def _row(model: Model) -> tuple[str, ...]:
    robot = Robot(parallelogram=model)
    log = simulate(_trial(robot))
    pitch = np.degrees(sole_pitch(robot, log).max())
    torque = np.abs(log.arrays["left_ankle_pitch_torque"]).max()
    walked = log.arrays["trunk_x"][-1] - log.arrays["trunk_x"][0]
    carried = f"{torque:.1f}" if model == "serial" else "no motor"
    return model, f"{pitch:.2f}", carried, f"{walked:.2f}"


def sole_pitch(robot: Robot, log: TrialLog) -> np.ndarray:
    """Pitch of both soles against the pelvis, in [rad]. Shape (ticks, 2)."""
    columns = [log.arrays[f"{joint.name}_position"] for joint in robot.tree.joints]
    joints = np.stack(columns, axis=-1).astype(float)
    n = len(joints)
    poses = robot.tree.poses(np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), joints)
    feet = [robot.tree.index(name) for name in robot.feet]
    return np.abs(np.arcsin(poses.rotation[:, feet, 2, 0]))


def _trial(robot: Robot) -> Trial:
    servos = [load_servo(joint.servo) for joint in robot.tree.joints if joint.servo is not None]
    return Trial(
        robot=robot,
        gait=Gait(stand_time=STAND),
        surface=load_surface(SURFACE),
        servos=tuple(servos),
        engine=EngineSettings(solver_iterations=ITERATIONS),
        horizon=Horizon(cycles=1.0),
        spread=Spread(friction=0.0, servo_gain=0.0, tilt=0.0, position=0.0, terrain=0.0),
        seed=0,
        names=Names(robot="flow", gait="flow", surface=SURFACE),
        robot_code=plugin("robot", "flow"),
        gait_code=plugin("gait", "flow"),
    )
