"""One trial from its numbers to its log: targets first, then the loop, then the columns."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from gaitlab.errors import GaitlabError, Infeasible
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.log import LogHeader, TrialLog
from gaitlab.model import (
    GANTRY_PITCH,
    Robot,
    Start,
    gantry_of,
    standing,
)
from gaitlab.model.clearance import require_apart
from gaitlab.model.commands import feet_of, hip_height_of, joint_commands
from gaitlab.model.gait import FeetPoses, first_step, require_feet
from gaitlab.model.randomness import randomness
from gaitlab.servos.law import stiffness, torque_limit
from gaitlab.simulation.columns import log_of
from gaitlab.simulation.ending import ARRIVED, GOES_ON, LOST, Ending
from gaitlab.simulation.engine import Engine
from gaitlab.simulation.engines import engine_named
from gaitlab.simulation.loop import Loop, loop_of
from gaitlab.simulation.pushes import Pushes
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial
from gaitlab.surfaces.tipping import settled

SMALL = 1e-4  # m, by which soles are moved to see how legs bend

__all__ = ["commanded", "engine_for", "simulate", "start_of"]


def simulate(trial: Trial) -> TrialLog:
    """Walk the robot until it falls or reaches the horizon.

    The same trial gives the same log, bit for bit, on the same wheel and processor.

    Raises:
        Infeasible: If the robot cannot take a commanded pose; nothing was simulated.
        GaitlabError: If the simulation leaves the numbers; the trial has no result.
    """
    header = _header(trial)
    feet, targets = commanded(trial)
    require_apart(trial.robot, targets, header.dt)
    loop = loop_of(trial, feet, targets)
    with engine_for(trial, feet) as engine:
        tape = _walk(engine, loop, header, trial)
    feet = loop.feet
    header = replace(header, first_step_time=first_step(feet) * header.dt)
    return log_of(tape, trial.robot, header, feet, loop.sent)


def commanded(trial: Trial) -> tuple[FeetPoses, np.ndarray]:
    """What the gait means at every tick up to the horizon, and the joint targets of that.

    Returns:
        The foot poses, and the targets in [rad], of shape (ticks, joints).

    Raises:
        Infeasible: If the robot cannot take a commanded pose.
    """
    ticks = _ticks(trial)
    feet = feet_of(trial.gait, trial.robot, np.arange(ticks) * trial.engine.dt)
    require_feet(feet, ticks)
    return feet, joint_commands(trial.robot, feet)


def engine_for(trial: Trial, feet: FeetPoses) -> Engine:
    """The engine of a trial, its robot standing on the ground as it is commanded first.

    Args:
        trial: The trial.
        feet: What its gait means, at one instant or more.
    """
    return engine_named(trial.engine.name)(
        trial.robot,
        trial.surface,
        trial.servos,
        start=start_of(trial, feet),
        settings=trial.engine,
        spread=trial.spread,
        seed=trial.seed,
        gravity=trial.slope.gravity,
    )


def start_of(trial: Trial, feet: FeetPoses) -> Start:
    """Where the robot of a trial stands before its first command.

    Its soles are level, its trunk leans as commanded, and its knees are bent as far as the servos
    give way under its weight: without an error they have no torque, and it would drop and bounce.

    The tilt of a replicate leans its legs, from the hips to the soles: the trunk is that far ahead
    and to the right of where it should be, and neither trunk nor soles are turned by it. A robot
    whose legs cannot take that stands as it is commanded.
    """
    first, robot = feet.at(0), trial.robot
    rng = randomness(trial.seed).pose
    roll, pitch = trial.spread.tilt * rng.uniform(-1.0, 1.0, 2)
    offset = trial.spread.position * rng.uniform(-1.0, 1.0, 2)
    targets = joint_commands(robot, first)[0]
    lean = axis_rotation("x", roll) @ axis_rotation("y", pitch)
    leg = first.position[0].mean(axis=0) + np.array([0.0, 0.0, robot.sole.height])
    try:
        level = robot.joint_targets(first)[0]
        leaning = first.moved(lean @ leg - leg + _sink(trial, first))
        joints = targets + robot.joint_targets(leaning)[0] - level
    except Infeasible:
        joints = targets
    begin = standing(robot, joints, gap=_settled_gap(trial))
    return begin._replace(position=begin.position + np.append(offset, 0.0), targets=targets)


def _sink(trial: Trial, feet: FeetPoses) -> np.ndarray:
    """By how much the servos let the soles come nearer to the hips of a standing robot, in [m].

    Each servo is a spring. Soles that move by s, forward and upward, bend the joints by J s, and
    sum stiffness (J s)^2 / 2 - weight s is least where (J' K J) s = weight, the force of the
    ground. Sideways they move where a slope pulls the robot to a side. Shape (3,).
    """
    robot = trial.robot
    if gantry_of(robot) != "none":
        return np.zeros(3)  # hung up
    level = robot.joint_targets(feet)[0]
    axes = np.eye(3) if trial.slope.roll else np.eye(3)[[0, 2]]
    moved = (feet.moved(SMALL * axis) for axis in axes)
    bends = np.stack([robot.joint_targets(each)[0] - level for each in moved])
    bends /= SMALL
    springs = np.zeros(len(level))
    springs[np.array(robot.tree.driven)] = [stiffness(servo) for servo in trial.servos]
    weight = axes @ (robot.tree.mass * -np.array(trial.slope.gravity))
    sink: np.ndarray = np.linalg.solve(bends * springs @ bends.T, weight) @ axes
    return sink


def _walk(engine: Engine, loop: Loop, header: LogHeader, trial: Trial) -> Tape:
    """What happens until the trial ends.

    Raises:
        GaitlabError: If the simulation leaves the numbers.
    """
    tape = Tape(len(loop.sent), len(header.joints))
    ending = Ending(
        dt=header.dt,
        standing_height=header.standing_height,
        startup=round(header.startup_time / header.dt),
        distance=trial.horizon.distance,
        course=header.course,
    )
    pushes = Pushes(trial, header.course)
    loop.begin(engine.trunk)
    code = GOES_ON
    while code == GOES_ON and tape.length < len(loop.sent):
        before = tape.length
        targets = loop.targets(before)
        for start, stop, force in pushes.pieces(before, before + len(targets)):
            engine.pull(force)
            code = engine.advance(targets[start - before : stop - before], tape, ending)
            if code != GOES_ON:
                break
        loop.feel(tape, before)
    if code == LOST:
        raise GaitlabError(f"the simulation blew up at tick {tape.length}")
    if code not in (GOES_ON, ARRIVED):
        tape.end(code)
    return tape


def _ticks(trial: Trial) -> int:
    walking = min(trial.horizon.cycles * trial.gait.gait_period, trial.horizon.time)
    return ceil((trial.gait.startup_time + walking) / trial.engine.dt - 1e-6)


def _header(trial: Trial) -> LogHeader:
    robot, gait = trial.robot, trial.gait
    gap, servos = _settled_gap(trial), iter(trial.servos)
    limits = [torque_limit(next(servos)) if driven else 0.0 for driven in robot.tree.driven]
    rig = () if gantry_of(robot) == "none" else (GANTRY_PITCH,)
    return LogHeader(
        joints=(*(joint.name for joint in robot.tree.joints), *rig),
        dt=trial.engine.dt,
        mass=robot.tree.mass,
        standing_height=robot.hip_offset() + hip_height_of(gait, robot) + gap,
        startup_time=gait.startup_time,
        gait_period=gait.gait_period,
        step_length=gait.step_length,
        side_step=getattr(gait, "side_step", 0.0),
        turn=getattr(gait, "turn", 0.0),
        horizon_time=trial.horizon.time,
        pile_height=trial.surface.height,
        sole_length=robot.sole.length,
        sole_width=robot.sole.width,
        torque_limits=(*limits, *(0.0 for _ in rig)),
        fsr_positions=_fsr_positions(robot),
    )


def _fsr_positions(robot: Robot) -> tuple[float, ...]:
    both = [robot.sole.sensors(foot) for foot in range(2)]
    return tuple(float(x) for table in both if table is not None for x in table.ravel())


def _settled_gap(trial: Trial) -> float:
    """Height of the soles over the base when the robot stands on both feet, in [m]."""
    surface, robot = trial.surface, trial.robot
    sink = settled(surface, robot.sole, 0.5 * robot.tree.mass * -trial.slope.gravity[2]).sink
    return float(surface.height - sink)
