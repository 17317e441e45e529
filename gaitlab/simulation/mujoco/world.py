"""What compiled code is told of a robot in MuJoCo, and how it reads where that is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.servos.law import ServoRow
from gaitlab.simulation.mujoco.structs import COM_POS, COM_VEL, KINEMATICS, stage

RIGID, LAYER, PILE = range(3)  # what is under the soles


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
        planes: Geoms of the soft planes: left, right, and under all other links. Shape (3,).
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
        spring: Stiffness [N/m] and damping [N s/m] of a support of each foot on soft ground, and
            how many of them stand in a sphere. Shape (2, 3).
        plough: Plough force on each foot, in [N]. Shape (2, 2).
        push: All that pushes it sideways beside contacts, in [N]. Shape (2, 2).
        torque: Mean torque of each joint of the log in this tick, in [N m]. Shape (joints,).
        points: Supports of a foot that carry. Shape (m, 2).
        normal: Normal of the plane under a foot, and its height along that. Shape (4,).
    """

    speed: np.ndarray
    spring: np.ndarray
    plough: np.ndarray
    push: np.ndarray
    torque: np.ndarray
    points: np.ndarray
    normal: np.ndarray


class TapeArrays(NamedTuple):
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
    row[7], row[8], row[9] = velocity(at, trunk, trunk)


@njit
def velocity(at: Places, trunk: int, body: int) -> tuple[float, float, float]:
    """Velocity of a body's centre of mass, in [m/s]."""
    x = at.xipos[body, 0] - at.middle[trunk, 0]
    y = at.xipos[body, 1] - at.middle[trunk, 1]
    z = at.xipos[body, 2] - at.middle[trunk, 2]
    wx, wy, wz, vx, vy, vz = at.cvel[body]
    return vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
