"""A robot on its servos and its ground in MuJoCo: the world of one trial.

A tick that is longer than a step may be is several steps; its torque is their mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import mujoco
import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model import Robot, Start, Vector
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineSettings, Spread
from gaitlab.servos.latency import ROUNDING, Latency
from gaitlab.servos.law import servo_row
from gaitlab.simulation.ending import Ending
from gaitlab.simulation.engine import DOWN, Replicate, replicate
from gaitlab.simulation.mujoco.loop import advance
from gaitlab.simulation.mujoco.model import SPHERES, Built, built
from gaitlab.simulation.mujoco.rows import CREEP, HARDNESS
from gaitlab.simulation.mujoco.structs import address, layout
from gaitlab.simulation.mujoco.world import (
    LAYER,
    PILE,
    RIGID,
    Acting,
    Carried,
    Places,
    TapeArrays,
    locate,
    read_trunk,
)
from gaitlab.simulation.tape import Tape
from gaitlab.surfaces.ground import Pile, new_footprint
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile
from gaitlab.surfaces.under_feet import Pose, UnderFeet

LONGEST = 0.002  # s, of a step
MOST_POINTS = 2 * 2 * SPHERES  # contact points of the soles: two feet on two grounds
_NONE, _TABLE = np.zeros(0), np.zeros((0, 3))
NO_PILE = Pile(_NONE, _NONE, _NONE, 0.0, _TABLE, _TABLE, 0.0, _NONE, _TABLE, _TABLE)


class MujocoEngine:
    """A robot standing on a surface; arguments and methods as of the protocol."""

    def __init__(
        self,
        robot: Robot,
        surface: Surface,
        servos: Sequence[Servo],
        *,
        start: Start,
        settings: EngineSettings,
        spread: Spread,
        seed: int,
        gravity: Vector = DOWN,
    ) -> None:
        """Build the world."""
        drawn = replicate(surface, servos, spread, seed)
        steps = max(1, ceil(settings.dt / LONGEST - ROUNDING))
        dt = settings.dt / steps
        self._built = built(robot, start.joints, dt, gravity)
        self._data = mujoco.MjData(self._built.model)
        self._places = _places(self._built.model, self._data)
        self._robot = _carried(self._built, robot, surface, drawn, dt, steps)
        self._acting = _room(self._robot)
        self._driven = np.flatnonzero(robot.tree.driven)
        self._latency = Latency(drawn.servos, dt, start.targets[self._driven])
        self._force: Vector = (0.0, 0.0, 0.0)
        self._piles, self._footprints = (NO_PILE, NO_PILE), (new_footprint(0), new_footprint(0))
        self._put(start, 0.0)
        if isinstance(surface, TuftedPile | FibreMat):
            lawn = UnderFeet(
                robot,
                surface,
                dt=dt,
                irregularity=spread.terrain,
                rng=drawn.terrain,
                down=-gravity[2],
            )
            self._piles, self._footprints = lawn.piles, lawn.footprints
            self._put(start, lawn.settle([self._pose(foot) for foot in self._built.feet]))

    def __enter__(self) -> MujocoEngine:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held that is not freed by itself."""

    def _put(self, start: Start, lift: float) -> None:
        """Put the robot where it starts, lifted by so many [m]."""
        at, pitch = self._data.qpos, self._built.pitch
        x, y, z = start.position.tolist()
        at[self._built.position[: len(start.joints)]] = start.joints
        if pitch is None:
            at[:3] = x, y, z + lift
            at[[4, 5, 6, 3]] = start.quaternion
        else:
            turned = 2.0 * float(np.arctan2(start.quaternion[1], start.quaternion[3]))
            at[:3] = x, z + lift, turned if pitch == "free" else 0.0
        locate(self._places)

    def _pose(self, body: int) -> Pose:
        w, x, y, z = self._data.xquat[body].tolist()
        at = self._data.xpos[body].tolist()
        return (at[0], at[1], at[2]), (x, y, z, w)

    @property
    def trunk(self) -> np.ndarray:
        """The trunk as it is now."""
        row = np.empty(13)
        read_trunk(self._places, self._robot.trunk, row)
        return row

    def pull(self, force: Vector) -> None:
        """Pull at the trunk from now on."""
        x, y, z = force
        self._force = (float(x), float(y), float(z))

    def advance(self, targets: np.ndarray, tape: Tape, ending: Ending) -> int:
        """All ticks in one compiled call."""
        sent = targets[:, self._driven]
        if self._robot.steps > 1:
            sent = np.repeat(sent, self._robot.steps, axis=0)
        tape.reserve(MOST_POINTS * len(targets))
        tape.length, tape.contacts_used, code = advance(
            self._places,
            self._robot,
            self._piles,
            self._footprints,
            self._acting,
            np.ascontiguousarray(self._latency.arriving(sent)),
            self._force,
            ending.rule,
            ending.memory,
            TapeArrays(
                tape.trunk, tape.joints, tape.plough, tape.push, tape.body_touches, tape.points
            ),
            tape.length,
            tape.contacts_used,
        )
        return int(code)


def _places(model: mujoco.MjModel, data: mujoco.MjData) -> Places:
    known = layout()
    return Places(
        calls=known.calls,
        offsets=known.offsets,
        model=address(model),
        data=address(data),
        bias=data.qfrc_bias.ctypes.data,
        qpos=data.qpos,
        qvel=data.qvel,
        xpos=data.xpos,
        xquat=data.xquat,
        xipos=data.xipos,
        cvel=data.cvel,
        middle=data.subtree_com,
        applied=data.xfrc_applied,
        geom_xpos=data.geom_xpos,
        geom_xmat=data.geom_xmat,
    )


def _carried(
    made: Built, robot: Robot, surface: Surface, drawn: Replicate, dt: float, steps: int
) -> Carried:
    supports = np.array([robot.sole.supports(side) for side in range(2)])
    ground, top, spring = RIGID, 0.0, np.ones(2)
    if isinstance(surface, SoftLayer):
        ground, top = LAYER, surface.height
        spring = np.array([surface.stiffness, surface.damping]) / supports.shape[1]
    elif isinstance(surface, TuftedPile | FibreMat):
        ground = PILE
    driven = np.flatnonzero(robot.tree.driven)
    servo_of = np.full(made.model.nv, -1)
    servo_of[made.velocity[driven]] = np.arange(len(driven))
    column_of = np.full(made.model.nv, -1)
    column_of[made.velocity] = np.arange(len(made.velocity))
    return Carried(
        position=made.position,
        velocity=made.velocity,
        driven=driven,
        servo_of=servo_of,
        column_of=column_of,
        trunk=made.trunk,
        feet=made.feet,
        kind=made.kind,
        planes=made.planes,
        spheres=made.spheres,
        supports=supports,
        servos=servo_row(drawn.servos, drawn.gain),
        ground=ground,
        top=top,
        spring=spring,
        friction=drawn.friction,
        hard=HARDNESS / robot.tree.mass,
        slip=4.0 * CREEP / (dt * drawn.friction * robot.tree.mass * GRAVITY),
        dt=dt,
        steps=steps,
    )


def _room(robot: Carried) -> Acting:
    return Acting(
        speed=np.zeros(len(robot.driven)),
        spring=np.zeros((2, 3)),
        plough=np.zeros((2, 2)),
        push=np.zeros((2, 2)),
        torque=np.zeros(len(robot.position)),
        points=np.zeros((robot.supports.shape[1], 2)),
        normal=np.zeros(4),
    )
