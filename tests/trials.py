"""Trials of the shipped robot and gait, short enough for a test."""

from __future__ import annotations

from dataclasses import replace

from gaitlab.gaits.eros import Gait
from gaitlab.model.settings import EngineSettings, Horizon, Spread
from gaitlab.robots.eros import Robot
from gaitlab.servos.files import load_servo
from gaitlab.simulation.trial import Names, Trial, plugin
from gaitlab.surfaces.files import load_surface

STILL = Spread(friction=0.0, servo_gain=0.0, tilt=0.0, position=0.0, terrain=0.0)


def trial(
    surface: str = "carpet_4mm",
    *,
    cycles: float = 1.0,
    seed: int = 0,
    spread: Spread | None = None,
    servo: dict[str, float] | None = None,
    engine: dict[str, float] | None = None,
    sole: str = "flat",
    **gait: object,
) -> Trial:
    """A trial with the gait's parameters given as keywords, everything else as shipped."""
    robot = Robot()
    robot = replace(robot, sole=replace(robot.sole, kind=sole))
    return Trial(
        robot=robot,
        gait=Gait(**gait),
        surface=load_surface(surface),
        servos=tuple(replace(load_servo(j.servo), **(servo or {})) for j in robot.tree.joints),
        engine=EngineSettings(**(engine or {})),
        horizon=Horizon(cycles=cycles),
        spread=spread or Spread(),
        seed=seed,
        names=Names(robot="eros", gait="eros", surface=surface),
        robot_code=plugin("robot", "eros"),
        gait_code=plugin("gait", "eros"),
    )


def standing(surface: str, seconds: float, **settings: object) -> Trial:
    """A trial that only stands."""
    still = {"step_length": 0.0, "step_height": 0.0, "lateral_sway": 0.0, "stand_time": seconds}
    return trial(surface, cycles=0.5, **still, **settings)
