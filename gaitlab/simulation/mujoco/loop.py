"""A robot on its servos and its ground in MuJoCo, tick by tick, in one compiled call.

A step has three parts. What acts is found from the state: servos, pile, pull. MuJoCo makes the
rows of all constraints, and each is given the physics of what it stands for. MuJoCo solves them and
moves the robot.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.servos.law import headed_speed
from gaitlab.simulation.ending import GOES_ON, ended
from gaitlab.simulation.mujoco.feet import stand
from gaitlab.simulation.mujoco.rows import contact_rows, joint_rows, write_contacts
from gaitlab.simulation.mujoco.structs import (
    ACCELERATION,
    BIAS,
    COLLISION,
    CONSTRAINT,
    EULER,
    FACTOR_M,
    FORCE,
    ID,
    MAKE_CONSTRAINT,
    MAKE_M,
    NEFC,
    PASSIVE,
    REFERENCE,
    bias,
    floats,
    ints,
    stage,
    word,
)
from gaitlab.simulation.mujoco.world import Acting, Carried, Places, TapeArrays, locate, read_trunk
from gaitlab.surfaces.ground import Footprint, Pile

RUNAWAY = 1e6  # sum of all positions and velocities, in SI units, of what is no robot any more


@njit
def advance(
    at: Places,
    robot: Carried,
    piles: tuple[Pile, Pile],
    footprints: tuple[Footprint, Footprint],
    acting: Acting,
    due: np.ndarray,
    force: tuple[float, float, float],
    rule: np.ndarray,
    memory: np.ndarray,
    tape: TapeArrays,
    first: int,
    used: int,
) -> tuple[int, int, int]:
    """Walk on until the targets are used up or the trial ends.

    Args:
        at: Where MuJoCo has things.
        robot: The robot.
        piles: What is under its feet; looked at on a pile alone.
        footprints: What that remembers.
        acting: Room for what acts.
        due: Target of each servo in each step, in [rad]. Shape (ticks x steps, servos).
        force: Pull at the trunk, world frame, in [N].
        rule: As of `Ending`.
        memory: Likewise, changed in place.
        tape: Receives what happens.
        first: Its first row to be written.
        used: Contact points in it so far.

    Returns:
        Rows and contact points that are now in the tape, and what `ended` said last.
    """
    code, row = GOES_ON, first
    while row < first + len(due) // robot.steps and code == GOES_ON:
        acting.torque[:] = 0.0
        touches, most = False, 0.0
        for k in range(robot.steps):
            for i in range(3):
                at.applied[robot.trunk, i] = force[i]
            step = (row - first) * robot.steps + k
            for j in range(len(robot.driven)):
                place = at.qpos[robot.position[robot.driven[j]]]
                acting.speed[j] = headed_speed(robot.servos, j, due[step, j], place)
            for side in range(2):
                stand(at, robot, piles[side], footprints[side], acting, side)
            _solve(at, robot, acting)
            if k == robot.steps - 1:
                touches, used = write_contacts(at, robot, tape.points, row, used)
            stage(at.calls[EULER], at.model, at.data)
            most = np.sum(np.abs(at.qpos)) + np.sum(np.abs(at.qvel))
            if not most < RUNAWAY:
                break
            locate(at)
        for j in range(len(robot.position)):
            tape.joints[row, 0, j] = at.qpos[robot.position[j]]
            tape.joints[row, 1, j] = at.qvel[robot.velocity[j]]
            tape.joints[row, 2, j] = acting.torque[j]
        tape.plough[row], tape.push[row] = acting.plough, acting.push
        tape.body_touches[row] = touches
        read_trunk(at, robot.trunk, tape.trunk[row])
        if not most < RUNAWAY:
            tape.trunk[row] = np.nan
        code = ended(rule, memory, tape.trunk[row], touches)
        row += 1
    return row, used, code


@njit
def _solve(at: Places, robot: Carried, acting: Acting) -> None:
    """Make the rows, say what they are, find accelerations and forces."""
    model, data, calls = at.model, at.data, at.calls
    stage(calls[MAKE_M], model, data)
    stage(calls[FACTOR_M], model, data)
    stage(calls[COLLISION], model, data)
    stage(calls[MAKE_CONSTRAINT], model, data)
    stage(calls[PASSIVE], model, data)
    stage(calls[REFERENCE], model, data)
    bias(calls[BIAS], model, data, at.bias)
    servo_rows = joint_rows(at, robot, acting)
    contact_rows(at, robot, acting)
    stage(calls[ACCELERATION], model, data)
    stage(calls[CONSTRAINT], model, data)
    rows = ints(data + at.offsets[NEFC], 1)[0]
    identity = ints(word(data + at.offsets[ID]), rows)
    found = floats(word(data + at.offsets[FORCE]), rows)
    for i in range(servo_rows[0], servo_rows[1]):
        acting.torque[robot.column_of[identity[i]]] += found[i] / robot.steps
