"""What each row of MuJoCo's constraints is, in N m and N/m, and what it gave.

MuJoCo makes the rows; each is given the physics of what it stands for. With h the step, v the
velocity along a row and r its length, a row

    a = aref - R f

solved for its acceleration a and force f is, at the velocity v' = v + h a of the step's end,

    a servo    f = damping (speed - v')               R = 1 / (damping h), aref = (speed - v) / h
    a spring   f = -K (r + h v') - C v'               R = 1 / (K h^2 + C h)
                                                      aref = -R ((K h + C) v + K r)
    hard       a share of r made good a step          aref = -v / h - share r / h^2
    near       r > 0: may close the gap, not more     aref = -(v + r / h) / h
    friction   v' = 0 but for a creep h R f           aref = -v / h

so that each law holds at the end of the step, as it stands, in N m and N/m. MuJoCo's own
parameters would not say so: its stiffness is divided by an inertia in another pose.

MuJoCo's friction is convex: a contact that slides with a speed s is pushed apart as if it closed
with friction x s, on which a sole would ride up by a millimetre. That much is taken off the aref of
its normal, with the speed at the start of the step.
"""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.simulation.mujoco.model import LEFT, LINK, SOFT
from gaitlab.simulation.mujoco.structs import (
    AREF,
    C_DIST,
    C_FRAME,
    C_FRICTION,
    C_GEOM,
    C_MU,
    C_POS,
    C_ROW,
    C_SIZE,
    CONTACT,
    DIAG_A,
    FORCE,
    FRICTIONLOSS,
    ID,
    NCON,
    NEFC,
    POS,
    TYPE,
    VEL,
    D,
    R,
    floats,
    ints,
    word,
)
from gaitlab.simulation.mujoco.world import Acting, Carried, Places

EQUALITY, DRY_FRICTION, JOINT_LIMIT = 0, 1, 3  # of MuJoCo's kinds of rows
HARDNESS = 0.04  # R of a contact with what is hard over the inverse of the robot's mass
FIRMNESS = 1e-3  # R of a joint's limit over the inverse of the inertia at it
SHARE = 0.2  # of an overlap of what is hard that is made good in a step
CREEP = 1e-3  # m/s, of a sole that a quarter of the robot's weight pushes with all its friction
TIGHTNESS = 1e-4  # likewise of a belt, a gear and what a gantry holds
STRENGTH = 1e4  # N m, of a gantry, more than any of these robots can ask for


@njit
def joint_rows(at: Places, robot: Carried, acting: Acting) -> tuple[int, int]:
    """Servos, belts, limits and what a gantry holds; says which rows have motors."""
    rows = ints(at.data + at.offsets[NEFC], 1)[0]
    kind = ints(word(at.data + at.offsets[TYPE]), rows)
    identity = ints(word(at.data + at.offsets[ID]), rows)
    error = floats(word(at.data + at.offsets[POS]), rows)
    velocity = floats(word(at.data + at.offsets[VEL]), rows)
    diagonal = floats(word(at.data + at.offsets[DIAG_A]), rows)
    bound = floats(word(at.data + at.offsets[FRICTIONLOSS]), rows)
    softness = floats(word(at.data + at.offsets[R]), rows)
    hardness = floats(word(at.data + at.offsets[D]), rows)
    wanted = floats(word(at.data + at.offsets[AREF]), rows)
    h, first, last = robot.dt, rows, rows
    for i in range(rows):
        v = velocity[i]
        if kind[i] == DRY_FRICTION:
            first, last = min(first, i), i + 1
            j = robot.servo_of[identity[i]]
            if j >= 0:
                softness[i] = 1.0 / (robot.servos.damping[j] * h)
                wanted[i] = (acting.speed[j] - v) / h
                bound[i] = robot.servos.limit[j]
            else:
                angle = at.qpos[robot.position[robot.column_of[identity[i]]]]
                softness[i] = TIGHTNESS * diagonal[i]
                wanted[i] = -v / h - SHARE * angle / (h * h)
                bound[i] = STRENGTH
        elif kind[i] == EQUALITY:
            softness[i] = TIGHTNESS * diagonal[i]
            wanted[i] = -v / h - SHARE * error[i] / (h * h)
        elif kind[i] == JOINT_LIMIT:
            softness[i] = FIRMNESS * diagonal[i]
            share = SHARE if error[i] < 0.0 else 1.0
            wanted[i] = -v / h - share * error[i] / (h * h)
        else:
            break
        hardness[i] = 1.0 / softness[i]
    return first, last


@njit
def contact_rows(at: Places, robot: Carried, acting: Acting) -> None:
    """Three rows a contact: along the normal, and two of friction."""
    rows = ints(at.data + at.offsets[NEFC], 1)[0]
    velocity = floats(word(at.data + at.offsets[VEL]), rows)
    softness = floats(word(at.data + at.offsets[R]), rows)
    hardness = floats(word(at.data + at.offsets[D]), rows)
    wanted = floats(word(at.data + at.offsets[AREF]), rows)
    contact = word(at.data + at.offsets[CONTACT])
    h = robot.dt
    for _ in range(ints(at.data + at.offsets[NCON], 1)[0]):
        i = ints(contact + at.offsets[C_ROW], 1)[0]
        if i >= 0:
            r = floats(contact + at.offsets[C_DIST], 1)[0]
            geoms = ints(contact + at.offsets[C_GEOM], 2)
            ground, other = robot.kind[geoms[0]], robot.kind[geoms[1]]
            if ground == SOFT:
                if other == LINK:
                    k, c, many = robot.spring[0], robot.spring[1], 1.0
                else:
                    k, c, many = acting.spring[other - LEFT]
                k, c = k * many, c * many
                normal = 1.0 / (k * h * h + c * h)
                wanted[i] = -normal * ((k * h + c) * velocity[i] + k * r)
            else:
                normal = robot.hard
                wanted[i] = -velocity[i] / h - SHARE * r / (h * h)
            if r > 0.0:
                wanted[i] = -(velocity[i] + r / h) / h
            wanted[i] -= robot.friction * hypot(velocity[i + 1], velocity[i + 2]) / h
            sideways = min(robot.slip, normal)
            softness[i], hardness[i] = normal, 1.0 / normal
            for j in (i + 1, i + 2):
                softness[j], hardness[j] = sideways, 1.0 / sideways
                wanted[j] = -velocity[j] / h
            friction = floats(contact + at.offsets[C_FRICTION], 2)
            friction[0], friction[1] = robot.friction, robot.friction
            floats(contact + at.offsets[C_MU], 1)[0] = robot.friction * sqrt(sideways / normal)
        contact += at.offsets[C_SIZE]


@njit
def write_contacts(
    at: Places, robot: Carried, points: np.ndarray, row: int, used: int
) -> tuple[bool, int]:
    """Write the forces on the soles; says whether another link is on the ground."""
    rows = ints(at.data + at.offsets[NEFC], 1)[0]
    found = floats(word(at.data + at.offsets[FORCE]), rows)
    contact = word(at.data + at.offsets[CONTACT])
    touches = False
    for _ in range(ints(at.data + at.offsets[NCON], 1)[0]):
        i = ints(contact + at.offsets[C_ROW], 1)[0]
        geoms = ints(contact + at.offsets[C_GEOM], 2)
        ground, other = robot.kind[geoms[0]], robot.kind[geoms[1]]
        if i >= 0 and ground <= SOFT:
            r = floats(contact + at.offsets[C_DIST], 1)[0]
            if other == LINK:
                touches = touches or r < 0.0 or found[i] > 0.0
            elif found[i] > 0.0:
                frame = floats(contact + at.offsets[C_FRAME], 9)
                place = floats(contact + at.offsets[C_POS], 3)
                out = points[used]
                out[0], out[1] = row, other - LEFT
                for a in range(3):
                    out[2 + a] = place[a] + 0.5 * r * frame[a]
                    out[5 + a] = (
                        found[i] * frame[a]
                        + found[i + 1] * frame[3 + a]
                        + found[i + 2] * frame[6 + a]
                    )
                used += 1
        contact += at.offsets[C_SIZE]
    return touches, used
