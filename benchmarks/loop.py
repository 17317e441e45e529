"""What a trial costs beside Bullet itself, side by side in one process.

The bare loop drives the same robot, sole and solver on a hard plane with nothing but
`setJointMotorControlArray` and `stepSimulation`, through the same walk; the full one is
`run_trial` as a worker does it:
targets, servos, ground, recording, measuring, writing. Rounds alternate and the ratio of medians
of CPU time a tick is printed, because the machine may be shared.

    python benchmarks/loop.py [--rounds 7] [--surfaces hard_floor carpet_4mm ...]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from contextlib import nullcontext
from dataclasses import replace
from math import inf
from pathlib import Path
from statistics import median
from unittest.mock import patch

import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.log.course import Course
from gaitlab.model import Robot
from gaitlab.running.run_trial import run_trial
from gaitlab.simulation.bullet.engine import BulletEngine
from gaitlab.simulation.bullet.world import (
    GROUND,
    LEFT_SHELL,
    OTHERS,
    SHELL,
    Indices,
    let_legs_meet,
    links,
)
from gaitlab.simulation.ending import Ending
from gaitlab.simulation.simulate import engine_for
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial
from gaitlab.store import Store
from gaitlab.surfaces.files import load_surface


def walking_trial(surface: str, seed: int) -> Trial:
    """A plain walk on the spot that lasts to its horizon."""
    settings = [f"surfaces=[{surface}]", "horizon.cycles=9"]
    planned = plan(load_experiment("eros_quick", settings)).trials()
    trial = next(iter(planned)).trial
    return Trial.from_dict({**trial.to_dict(), "seed": seed})


def on_hard_floor(trial: Trial) -> tuple[BulletEngine, np.ndarray]:
    """A fresh engine on the hard floor and the trial's targets."""
    feet = trial.gait.feet(np.arange(int(30.0 / trial.engine.dt)) * trial.engine.dt)
    floor = replace(trial, surface=load_surface("hard_floor"))
    engine = engine_for(floor, feet)
    assert isinstance(engine, BulletEngine)
    return engine, trial.robot.joint_targets(feet)


def motor_commands(trial: Trial, ticks: int) -> list[tuple[list[float], list[float]]]:
    """What the servos ask of Bullet at each tick of a walk on the hard floor."""
    commands: list[tuple[list[float], list[float]]] = []
    engine, targets = on_hard_floor(trial)
    with engine:
        asked = engine._motors.drive

        def noted(*state: np.ndarray) -> tuple[list[float], list[float]]:
            commands.append(asked(*state))
            return commands[-1]

        engine._motors.drive = noted
        far = Ending(dt=0.002, standing_height=0.3, startup=0, distance=inf, course=Course(ahead=0))
        engine.advance(targets[:ticks], Tape(ticks, targets.shape[1]), far)
    return commands


def meet_ground(
    client: BulletClient, body: int, robot: Robot, found: Indices, joints: np.ndarray
) -> None:
    """As the engine's `let_legs_meet`, but nothing of the robot meets another part of it."""
    let_legs_meet(client, body, robot, found, joints)
    for link in links(client, body):
        client.setCollisionFilterGroupMask(body, link, OTHERS, GROUND)
    for foot in robot.feet:
        client.setCollisionFilterGroupMask(body, found.link[f"{foot}{SHELL}"], LEFT_SHELL, 0)


def bare(trial: Trial, ticks: int, meeting: bool = True) -> float:
    """CPU seconds a tick of the bare loop; it replays the commands of a walk, so that it walks.

    Driven by anything else the robot falls, and lying down is cheaper to simulate than walking.

    Args:
        trial: The walk.
        ticks: How long.
        meeting: Whether the legs can touch each other.
    """
    place = "gaitlab.simulation.bullet.engine.let_legs_meet"
    with nullcontext() if meeting else patch(place, meet_ground):
        commands = motor_commands(trial, ticks)
        engine, _ = on_hard_floor(trial)
    with engine:
        client, body, joints = engine._client, engine._body, engine._joints
        start = time.process_time()
        for speed, torque in commands:
            client.setJointMotorControlArray(
                body, joints, pybullet.VELOCITY_CONTROL, targetVelocities=speed, forces=torque
            )
            client.stepSimulation()
        spent = (time.process_time() - start) / ticks
        if client.getBasePositionAndOrientation(body)[0][2] < 0.2:
            raise SystemExit("the robot of the bare loop fell; its time says nothing")
        return spent


def full(trial: Trial, folder: Path) -> tuple[float, int]:
    """CPU seconds a tick of a whole trial, and its ticks."""
    start = time.process_time()
    record = run_trial(trial.id, trial.to_dict(), folder)
    spent = time.process_time() - start
    ticks = len(Store(folder).log(record.trial_id))
    return spent / ticks, ticks


def main() -> None:
    """Print the ratio for each surface."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--surfaces", nargs="+", default=["hard_floor", "grass_30mm"])
    options = parser.parse_args()
    for surface in options.surfaces:
        compare(surface, options.rounds)


def compare(surface: str, rounds: int) -> None:
    """One surface: a warm-up round, then the counted ones."""
    ratios, bares, fulls, legs = [], [], [], []
    for seed in range(rounds + 1):
        trial = walking_trial(surface, seed)
        with tempfile.TemporaryDirectory() as folder:
            spent, ticks = full(trial, Path(folder))
        plain = bare(trial, ticks)
        legs.append(plain / bare(trial, ticks, meeting=False))
        if seed:
            bares.append(plain), fulls.append(spent), ratios.append(spent / plain)
    print(
        f"{surface}: full {1e6 * median(fulls):.0f} us a tick, bare {1e6 * median(bares):.0f} us, "
        f"ratio {median(ratios):.2f} (from {min(ratios):.2f} to {max(ratios):.2f}, n = {rounds}); "
        f"bare with legs that can touch over bare without {median(legs[1:]):.2f}"
    )


if __name__ == "__main__":
    main()
