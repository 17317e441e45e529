"""One trial from its numbers to its log: targets first, then the loop, then the columns."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, hypot, isfinite

import numpy as np

from gaitlab.body import GANTRY_PITCH, Robot, gantry_of
from gaitlab.commands import joint_commands
from gaitlab.engine import Engine, TickState
from gaitlab.errors import GaitlabError
from gaitlab.fall import FallDetector
from gaitlab.log import GRAVITY, LogHeader, TrialLog
from gaitlab.motion import first_step, require_feet
from gaitlab.servos.law import torque_limit
from gaitlab.simulate.columns import log_of
from gaitlab.simulate.loop import Loop, loop_of
from gaitlab.simulate.recording import Recording
from gaitlab.surfaces.surface import FibreMat, TuftedPile
from gaitlab.trial import Trial

__all__ = ["simulate"]


def simulate(trial: Trial) -> TrialLog:
    """Walk the robot until it falls or reaches the horizon.

    The same trial gives the same log, bit for bit, on the same wheel and processor.

    Raises:
        Infeasible: If the robot cannot take a commanded pose; nothing was simulated.
        GaitlabError: If the simulation leaves the numbers; the trial has no result.
    """
    header = _header(trial)
    ticks = _ticks(trial)
    feet = trial.gait.feet(np.arange(ticks) * header.dt)
    require_feet(feet, ticks)
    header = replace(header, first_step_time=first_step(feet) * header.dt)
    targets = joint_commands(trial.robot, feet)
    with Engine(
        trial.robot,
        trial.surface,
        trial.servos,
        pose=targets[0],
        height=header.standing_height,
        settings=trial.engine,
        spread=trial.spread,
        seed=trial.seed,
    ) as engine:
        recording = Recording(len(targets), len(header.joints), engine.feet)
        loop = loop_of(trial, feet, targets)
        _walk(engine, recording, loop, header, trial)
    return log_of(recording, trial.robot, header, feet, loop.sent)


def _walk(
    engine: Engine, recording: Recording, loop: Loop, header: LogHeader, trial: Trial
) -> None:
    falling = FallDetector(header.dt, header.standing_height)
    arrival = _Arrival(round(header.startup_time / header.dt), trial.horizon.distance)
    centre = trial.robot.tree.links[0].box.centre
    loop.feel(engine.state())
    for tick in range(len(loop.sent)):
        engine.command(loop.target(tick))
        engine.step()
        state = engine.state()
        loop.feel(state)
        touching = recording.put(state, engine.plough)
        upright, height = _trunk(state, centre)
        if not isfinite(height):
            raise GaitlabError(f"the simulation blew up at tick {recording.length}")
        cause = falling.update(upright, touching, height)
        if cause:
            recording.end(cause)
        if cause or arrival.reached(state, recording.length):
            break


def _trunk(state: TickState, centre: tuple[float, float, float]) -> tuple[float, float]:
    """Cosine of the trunk's tilt, and the height of its link frame in [m]."""
    x, y, z, w = state.quaternion
    r31, r32, r33 = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    return r33, state.position[2] - (r31 * centre[0] + r32 * centre[1] + r33 * centre[2])


class _Arrival:
    """Says when the robot is as far as the horizon asks, along its heading at the start."""

    def __init__(self, start_tick: int, distance: float) -> None:
        self._start, self._distance = start_tick, distance
        self._origin, self._heading = (0.0, 0.0), (1.0, 0.0)

    def reached(self, state: TickState, ticks: int) -> bool:
        if ticks <= self._start:
            x, y, z, w = state.quaternion
            cosine, sine = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w)
            length = hypot(cosine, sine)
            self._origin, self._heading = state.position[:2], (cosine / length, sine / length)
            return False
        dx, dy = state.position[0] - self._origin[0], state.position[1] - self._origin[1]
        return abs(dx * self._heading[0] + dy * self._heading[1]) >= self._distance


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
        standing_height=robot.hip_offset() + gait.hip_height + gap,
        startup_time=gait.startup_time,
        gait_period=gait.gait_period,
        step_length=gait.step_length,
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
    surface, sole = trial.surface, trial.robot.sole
    if isinstance(surface, TuftedPile | FibreMat):
        pressure = trial.robot.tree.mass * GRAVITY / (2.0 * sole.length * sole.width)
        return surface.law().gap_under(pressure)
    return float(surface.height)
