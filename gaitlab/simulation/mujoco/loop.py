"""A robot on its servos and its ground in MuJoCo, tick by tick, in one compiled call.

A step has three parts. What acts is found from the state: servos, pile, pull. MuJoCo makes the
rows of all constraints, and each is given the physics of what it stands for. MuJoCo solves them and
moves the robot. With h the step, v the velocity along a row and r its length, a row

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
"""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from gaitlab.model.compiled import njit
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.servos.law import ServoRow, headed_speed
from gaitlab.simulation.ending import GOES_ON, ended
from gaitlab.simulation.mujoco.model import HARD, LEFT, LINK, MARGIN, SOFT, SPHERES
from gaitlab.simulation.mujoco.structs import (
    ACCELERATION,
    AREF,
    BIAS,
    C_DIST,
    C_FRAME,
    C_FRICTION,
    C_GEOM,
    C_MU,
    C_POS,
    C_ROW,
    C_SIZE,
    COLLISION,
    COM_POS,
    COM_VEL,
    CONSTRAINT,
    CONTACT,
    DIAG_A,
    EULER,
    FACTOR_M,
    FORCE,
    FRICTIONLOSS,
    ID,
    KINEMATICS,
    MAKE_CONSTRAINT,
    MAKE_M,
    NCON,
    NEFC,
    PASSIVE,
    POS,
    REFERENCE,
    TYPE,
    VEL,
    D,
    R,
    bias,
    floats,
    ints,
    stage,
    word,
)
from gaitlab.surfaces.ground import Footprint, Pile
from gaitlab.surfaces.press import press

RIGID, LAYER, PILE = range(3)  # what is under the soles

EQUALITY, DRY_FRICTION, JOINT_LIMIT = 0, 1, 3  # of MuJoCo's kinds of rows
HARDNESS = 0.04  # R of a contact with what is hard over the inverse of the robot's mass
FIRMNESS = 1e-3  # R of a joint's limit over the inverse of the inertia at it
SHARE = 0.2  # of an overlap of what is hard that is made good in a step
CREEP = 1e-3  # m/s, of a sole that a quarter of the robot's weight pushes with all its friction
TIGHTNESS = 1e-4  # likewise of a belt, a gear and what a gantry holds
STRENGTH = 1e4  # N m, of a gantry, more than any of these robots can ask for
PARKED = 1e3  # m over the ground, where nothing meets anything


class Places(NamedTuple):
    """Where MuJoCo has things: addresses, and views of arrays that do not move.

    Attributes:
        calls: As of `Layout`. Shape (functions,).
        offsets: Likewise. Shape (fields,).
        model: Address of the model.
        data: Address of its data.
        bias: Address of what gravity and velocity ask of the joints.
        qpos: Positions, the quaternion of a free trunk wxyz. Shape (nq,).
        qvel: Velocities, the spin of a free trunk in its own frame. Shape (nv,).
        xpos: Link frames, in [m]. Shape (bodies, 3).
        xquat: Their orientation, wxyz. Shape (bodies, 4).
        xipos: Centres of mass, in [m]. Shape (bodies, 3).
        cvel: Spin, and velocity at `middle`. Shape (bodies, 6).
        middle: Centre of mass of all that hangs on a body, in [m]. Shape (bodies, 3).
        applied: Force and torque at each centre of mass, in [N] and [N m]. Shape (bodies, 6).
        geom_xpos: Shapes, in [m]. Shape (geoms, 3).
        geom_xmat: Their orientation. Shape (geoms, 9).
    """

    calls: np.ndarray
    offsets: np.ndarray
    model: int
    data: int
    bias: int
    qpos: np.ndarray
    qvel: np.ndarray
    xpos: np.ndarray
    xquat: np.ndarray
    xipos: np.ndarray
    cvel: np.ndarray
    middle: np.ndarray
    applied: np.ndarray
    geom_xpos: np.ndarray
    geom_xmat: np.ndarray


class Carried(NamedTuple):
    """A robot in MuJoCo: indices as of `Built`, its servos and what is under it.

    Attributes:
        position: Index into `qpos` of each joint of the log. Shape (joints,).
        velocity: Index into `qvel`. Shape (joints,).
        driven: Joint of the log of each servo. Shape (servos,).
        servo_of: Servo of each velocity, -1 for none, -2 for what a gantry holds. Shape (nv,).
        column_of: Joint of the log of each velocity, -1 for none. Shape (nv,).
        trunk: Body of the trunk.
        feet: Bodies of the feet. Shape (2,).
        kind: What each geom is. Shape (geoms,).
        planes: Geoms of the soft planes. Shape (3,).
        spheres: Geoms that the feet stand on. Shape (2, 2, 4).
        supports: Support points of both soles in the foot link frames, in [m]. Shape (2, m, 3).
        servos: The servos.
        ground: RIGID, LAYER or PILE.
        top: Height of a layer, in [m].
        spring: Its stiffness and damping per support point, in [N/m] and [N s/m]. Shape (2,).
        friction: Between the soles and the ground.
        hard: R of a contact with what is hard, in [1/kg].
        slip: R of friction at most, in [1/kg].
        dt: Duration of a step, in [s].
        steps: Steps in a tick.
    """

    position: np.ndarray
    velocity: np.ndarray
    driven: np.ndarray
    servo_of: np.ndarray
    column_of: np.ndarray
    trunk: int
    feet: np.ndarray
    kind: np.ndarray
    planes: np.ndarray
    spheres: np.ndarray
    supports: np.ndarray
    servos: ServoRow
    ground: int
    top: float
    spring: np.ndarray
    friction: float
    hard: float
    slip: float
    dt: float
    steps: int


class Acting(NamedTuple):
    """What acts in a step; written anew in every one.

    Attributes:
        speed: Speed that each servo heads for, in [rad/s]. Shape (servos,).
        spring: Stiffness [N/m] and damping [N s/m] of a sphere on soft ground, and how many
            supports carry each foot there and on hard ground. Shape (2, 4).
        plough: Plough force on each foot, in [N]. Shape (2, 2).
        push: All that pushes it sideways beside contacts, in [N]. Shape (2, 2).
        torque: Mean torque of each joint of the log in this tick, in [N m]. Shape (joints,).
        points: Supports of a foot that carry. Shape (m, 2).
        normal: Normal of the plane under each foot, and its height along that. Shape (2, 4).
    """

    speed: np.ndarray
    spring: np.ndarray
    plough: np.ndarray
    push: np.ndarray
    torque: np.ndarray
    points: np.ndarray
    normal: np.ndarray


class Written(NamedTuple):
    """The arrays of a tape, with its names and shapes."""

    trunk: np.ndarray
    joints: np.ndarray
    plough: np.ndarray
    push: np.ndarray
    body_touches: np.ndarray
    points: np.ndarray


@njit
def locate(at: Places) -> None:
    """Find where everything is and how fast, from positions and velocities."""
    stage(at.calls[KINEMATICS], at.model, at.data)
    stage(at.calls[COM_POS], at.model, at.data)
    stage(at.calls[COM_VEL], at.model, at.data)


@njit
def read_trunk(at: Places, trunk: int, row: np.ndarray) -> None:
    """The trunk as a row of the tape. Shape (13,)."""
    for i in range(3):
        row[i] = at.xpos[trunk, i]
        row[3 + i] = at.xquat[trunk, 1 + i]
        row[10 + i] = at.cvel[trunk, i]
    row[6] = at.xquat[trunk, 0]
    row[7], row[8], row[9] = _velocity(at, trunk, trunk)


@njit
def _velocity(at: Places, trunk: int, body: int) -> tuple[float, float, float]:
    """Velocity of a body's centre of mass, in [m/s]."""
    x = at.xipos[body, 0] - at.middle[trunk, 0]
    y = at.xipos[body, 1] - at.middle[trunk, 1]
    z = at.xipos[body, 2] - at.middle[trunk, 2]
    wx, wy, wz, vx, vy, vz = at.cvel[body]
    return vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x


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
    tape: Written,
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
        touches = False
        for k in range(robot.steps):
            for i in range(3):
                at.applied[robot.trunk, i] = force[i]
            step = (row - first) * robot.steps + k
            for j in range(len(robot.driven)):
                place = at.qpos[robot.position[robot.driven[j]]]
                acting.speed[j] = headed_speed(robot.servos, j, due[step, j], place)
            for side in range(2):
                _stand(at, robot, piles[side], footprints[side], acting, side)
            _solve(at, robot, acting)
            if k == robot.steps - 1:
                touches, used = _contacts(at, robot, tape.points, row, used)
            stage(at.calls[EULER], at.model, at.data)
            locate(at)
        whole = 0.0
        for j in range(len(robot.position)):
            tape.joints[row, 0, j] = at.qpos[robot.position[j]]
            tape.joints[row, 1, j] = at.qvel[robot.velocity[j]]
            tape.joints[row, 2, j] = acting.torque[j]
            whole += tape.joints[row, 0, j] + tape.joints[row, 1, j]
        tape.plough[row], tape.push[row] = acting.plough, acting.push
        tape.body_touches[row] = touches
        read_trunk(at, robot.trunk, tape.trunk[row])
        if not isfinite(whole):
            tape.trunk[row] = np.nan
        code = ended(rule, memory, tape.trunk[row], touches)
        row += 1
    return row, used, code


@njit
def _stand(
    at: Places, robot: Carried, pile: Pile, footprint: Footprint, acting: Acting, side: int
) -> None:
    """Put the plane under one foot and the spheres that it stands on; let the pile push it."""
    body = robot.feet[side]
    normal = acting.normal[side]
    normal[:] = 0.0
    normal[2] = 1.0
    soft = robot.ground != RIGID
    plane = robot.planes[side]
    if robot.ground == PILE:
        w, x, y, z = at.xquat[body]
        origin = (at.xpos[body, 0], at.xpos[body, 1], at.xpos[body, 2])
        centre = (at.xipos[body, 0], at.xipos[body, 1], at.xipos[body, 2])
        velocity = _velocity(at, robot.trunk, body)
        spin = (at.cvel[body, 0], at.cvel[body, 1], at.cvel[body, 2])
        support = press(pile, footprint, origin, (x, y, z, w), centre, velocity, spin, robot.dt)
        acting.spring[side, 0], acting.spring[side, 1] = support.stiffness, support.damping
        for i in range(2):
            acting.plough[side, i], acting.push[side, i] = support.plough[i], support.push[i]
            at.applied[body, i] = support.push[i]
        for i in range(3):
            at.applied[body, 3 + i] = support.torque[i]
        soft = support.active and support.point[2] > 0.0
        _place(at, plane, support.point, support.turn, normal)
    elif robot.ground == LAYER:
        acting.spring[side, 0], acting.spring[side, 1] = robot.spring[0], robot.spring[1]
        _place(at, plane, (0.0, 0.0, robot.top), (0.0, 0.0, 0.0, 1.0), normal)
    else:
        at.geom_xpos[plane, 2] = -PARKED
    if side == 0:
        at.geom_xpos[robot.planes[2], 2] = robot.top if robot.ground == LAYER else -PARKED
    acting.spring[side, 2] = (
        _carry(at, robot, acting, side, 0, normal) if soft else _park(at, robot.spheres[side, 0], 0)
    )
    normal[0], normal[1], normal[2], normal[3] = 0.0, 0.0, 1.0, 0.0
    acting.spring[side, 3] = _carry(at, robot, acting, side, 1, normal)


@njit
def _place(
    at: Places,
    plane: int,
    point: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    normal: np.ndarray,
) -> None:
    """Put a plane there, xyzw; says its normal and its height along that."""
    x, y, z, w = turn
    matrix = at.geom_xmat[plane]
    matrix[0], matrix[1] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w)
    matrix[3], matrix[4] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z)
    matrix[6], matrix[7] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w)
    matrix[2], matrix[5] = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w)
    matrix[8] = 1.0 - 2.0 * (x * x + y * y)
    normal[3] = 0.0
    for i in range(3):
        at.geom_xpos[plane, i] = point[i]
        normal[i] = matrix[3 * i + 2]
        normal[3] += normal[i] * point[i]


@njit
def _park(at: Places, spheres: np.ndarray, first: int) -> float:
    """Put spheres out of the way, from one of them on."""
    for k in range(first, SPHERES):
        at.geom_xpos[spheres[k], 2] = PARKED
    return 0.0


@njit
def _carry(
    at: Places, robot: Carried, acting: Acting, side: int, ground: int, normal: np.ndarray
) -> float:
    """Put the spheres of a foot where they carry what its supports do on a plane.

    Those carry that overlap; if none does, those that are near.

    Returns:
        How many supports stand in each sphere.
    """
    body, spheres = robot.feet[side], robot.spheres[side, ground]
    w, x, y, z = at.xquat[body]
    # The foot's axes along the normal, so that a support's height is linear in its coordinates.
    up_x = normal[0] * (1.0 - 2.0 * (y * y + z * z))
    up_x += normal[1] * 2.0 * (x * y + z * w) + normal[2] * 2.0 * (x * z - y * w)
    up_y = normal[0] * 2.0 * (x * y - z * w)
    up_y += normal[1] * (1.0 - 2.0 * (x * x + z * z)) + normal[2] * 2.0 * (y * z + x * w)
    up_z = normal[0] * 2.0 * (x * z + y * w)
    up_z += normal[1] * 2.0 * (y * z - x * w) + normal[2] * (1.0 - 2.0 * (x * x + y * y))
    supports = robot.supports[side]
    base = -normal[3] - SUPPORT_RADIUS + up_z * (supports[0, 2] + SUPPORT_RADIUS)
    for i in range(3):
        base += normal[i] * at.xpos[body, i]
    count, lowest = 0, MARGIN
    for i in range(len(supports)):
        gap = base + up_x * supports[i, 0] + up_y * supports[i, 1]
        if gap < 0.0 and lowest > 0.0:
            count, lowest = 0, 0.0
        if gap < lowest:
            acting.points[count, 0], acting.points[count, 1] = supports[i, 0], supports[i, 1]
            count += 1
    if count == 0:
        return _park(at, spheres, 0)
    mx, my = 0.0, 0.0
    for i in range(count):
        mx += acting.points[i, 0] / count
        my += acting.points[i, 1] / count
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(count):
        dx, dy = acting.points[i, 0] - mx, acting.points[i, 1] - my
        xx += dx * dx / count
        xy += dx * dy / count
        yy += dy * dy / count
    half, apart = 0.5 * (xx + yy), sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    longer, shorter = sqrt(half + apart), sqrt(max(half - apart, 0.0))
    ax, ay = 1.0, 0.0
    if apart > 0.0:
        # The longer axis, from the row of the matrix that says it best.
        ax, ay = (0.5 * (xx - yy) + apart, xy) if xx > yy else (xy, 0.5 * (yy - xx) + apart)
        length = sqrt(ax * ax + ay * ay)
        ax, ay = ax / length, ay / length
    made = 0
    tiny = 1e-6 * longer
    for a in range(2 if longer > 0.0 else 1):
        for b in range(2 if shorter > tiny else 1):
            along = longer * (1.0 - 2.0 * a)
            across = shorter * (1.0 - 2.0 * b) if shorter > tiny else 0.0
            px, py = mx + ax * along - ay * across, my + ay * along + ax * across
            pz = supports[0, 2] + SUPPORT_RADIUS
            geom = at.geom_xpos[spheres[made]]
            # The vector (px, py, pz) turned by the quaternion.
            tx, ty, tz = 2.0 * (y * pz - z * py), 2.0 * (z * px - x * pz), 2.0 * (x * py - y * px)
            geom[0] = at.xpos[body, 0] + px + w * tx + y * tz - z * ty
            geom[1] = at.xpos[body, 1] + py + w * ty + z * tx - x * tz
            geom[2] = at.xpos[body, 2] + pz + w * tz + x * ty - y * tx
            made += 1
    _park(at, spheres, made)
    return count / made


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
    servo_rows = _joint_rows(at, robot, acting)
    _contact_rows(at, robot, acting)
    stage(calls[ACCELERATION], model, data)
    stage(calls[CONSTRAINT], model, data)
    rows = ints(data + at.offsets[NEFC], 1)[0]
    identity = ints(word(data + at.offsets[ID]), rows)
    found = floats(word(data + at.offsets[FORCE]), rows)
    for i in range(servo_rows[0], servo_rows[1]):
        acting.torque[robot.column_of[identity[i]]] += found[i] / robot.steps


@njit
def _joint_rows(at: Places, robot: Carried, acting: Acting) -> tuple[int, int]:
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
            wanted[i] = -v / h - SHARE * error[i] / (h * h)
        else:
            break
        hardness[i] = 1.0 / softness[i]
    return first, last


@njit
def _contact_rows(at: Places, robot: Carried, acting: Acting) -> None:
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
                    k, c, many, _ = acting.spring[other - LEFT]
                k, c = k * many, c * many
                normal = 1.0 / (k * h * h + c * h)
                wanted[i] = -normal * ((k * h + c) * velocity[i] + k * r)
            else:
                normal = robot.hard
                wanted[i] = -velocity[i] / h - SHARE * r / (h * h)
            if r > 0.0:
                wanted[i] = -(velocity[i] + r / h) / h
            sideways = min(robot.slip, normal)
            softness[i], hardness[i] = normal, 1.0 / normal
            for k in range(1, 3):
                softness[i + k], hardness[i + k] = sideways, 1.0 / sideways
                wanted[i + k] = -velocity[i + k] / h
            friction = floats(contact + at.offsets[C_FRICTION], 2)
            friction[0], friction[1] = robot.friction, robot.friction
            floats(contact + at.offsets[C_MU], 1)[0] = robot.friction * sqrt(sideways / normal)
        contact += at.offsets[C_SIZE]


@njit
def _contacts(
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
