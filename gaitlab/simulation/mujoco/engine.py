"""A robot on its servos and its ground in MuJoCo: the world of one trial.

A tick that is longer than a step may be is several steps; its torque is their mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import mujoco
import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model import Robot, Start, gantry_of
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineSettings, Spread
from gaitlab.servos.latency import ROUNDING, Latency
from gaitlab.servos.law import servo_row
from gaitlab.simulation.ending import Ending
from gaitlab.simulation.engine import Vector, replicate
from gaitlab.simulation.mujoco.loop import (
    CREEP,
    HARDNESS,
    LAYER,
    PILE,
    RIGID,
    Acting,
    Carried,
    Places,
    Written,
    advance,
    locate,
    read_trunk,
)
from gaitlab.simulation.mujoco.model import Built, built
from gaitlab.simulation.mujoco.structs import address, layout
from gaitlab.simulation.tape import Tape
from gaitlab.surfaces.ground import Footprint, Pile, new_footprint
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile
from gaitlab.surfaces.under_feet import UnderFeet

LONGEST = 0.002  # s, of a step
MOST_POINTS = 16  # contact points of the soles in a tick: two feet, two grounds, four spheres


class Engine:
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
    ) -> None:
        """Build the world."""
        known = layout()
        drawn = replicate(surface, servos, spread, seed)
        steps = max(1, ceil(settings.dt / LONGEST - ROUNDING))
        dt = settings.dt / steps
        self._built = made = built(robot, start.joints, dt)
        self._data = data = mujoco.MjData(made.model)
        self._places = Places(
            calls=known.calls,
            offsets=known.offsets,
            model=address(made.model),
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
        layer = isinstance(surface, SoftLayer)
        pile = isinstance(surface, TuftedPile | FibreMat)
        supports = np.array([robot.sole.supports(side) for side in range(2)])
        count = supports.shape[1]
        weight = robot.tree.mass * GRAVITY
        driven = np.flatnonzero(robot.tree.driven)
        self._driven = driven
        spring = np.array([surface.stiffness, surface.damping]) / count if layer else np.ones(2)
        servo_of = np.full(made.model.nv, -1)
        servo_of[made.velocity[driven]] = np.arange(len(driven))
        column_of = np.full(made.model.nv, -1)
        column_of[made.velocity] = np.arange(len(made.velocity))
        self._robot = Carried(
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
            ground=LAYER if layer else PILE if pile else RIGID,
            top=surface.height if layer else 0.0,
            spring=spring,
            friction=drawn.friction,
            hard=HARDNESS / robot.tree.mass,
            slip=4.0 * CREEP / (dt * drawn.friction * weight),
            dt=dt,
            steps=steps,
        )
        self._acting = Acting(
            speed=np.zeros(len(driven)),
            spring=np.zeros((2, 4)),
            plough=np.zeros((2, 2)),
            push=np.zeros((2, 2)),
            torque=np.zeros(len(made.position)),
            points=np.zeros((count, 2)),
            normal=np.zeros((2, 4)),
        )
        self._latency = Latency(drawn.servos, dt, start.targets[driven])
        self._force: Vector = (0.0, 0.0, 0.0)
        self._piles, self._footprints = (NOTHING, NOTHING), (UNTOUCHED, UNTOUCHED)
        _put(made, data, robot, start, 0.0)
        locate(self._places)
        if isinstance(surface, TuftedPile | FibreMat):
            lawn = UnderFeet(robot, surface, dt=dt, irregularity=spread.terrain, rng=drawn.terrain)
            self._piles, self._footprints = lawn.piles, lawn.footprints
            lift = lawn.settle([(tuple(data.xpos[k]), _xyzw(data.xquat[k])) for k in made.feet])
            _put(made, data, robot, start, lift)
            locate(self._places)

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held that Python does not free."""

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
        due = self._latency.arriving(np.repeat(targets[:, self._driven], self._robot.steps, axis=0))
        tape.reserve(MOST_POINTS * len(targets))
        written = Written(
            tape.trunk, tape.joints, tape.plough, tape.push, tape.body_touches, tape.points
        )
        tape.length, tape.contacts_used, code = advance(
            self._places,
            self._robot,
            self._piles,
            self._footprints,
            self._acting,
            due,
            self._force,
            ending.rule,
            ending.memory,
            written,
            tape.length,
            tape.contacts_used,
        )
        return int(code)


def _put(made: Built, data: mujoco.MjData, robot: Robot, start: Start, lift: float) -> None:
    """Put a robot where it starts, lifted by so many [m], and at rest."""
    x, y, z = start.position.tolist()
    count = len(start.joints)
    data.qpos[made.position[:count]] = start.joints
    if gantry_of(robot) == "none":
        data.qpos[:3] = x, y, z + lift
        data.qpos[[4, 5, 6, 3]] = start.quaternion
        return
    _, qy, _, qw = start.quaternion
    data.qpos[:2] = x, z + lift
    # A level gantry keeps the trunk level.
    data.qpos[2] = 0.0 if made.pitch >= 0 else 2.0 * float(np.arctan2(qy, qw))


def _xyzw(quaternion: np.ndarray) -> tuple[float, float, float, float]:
    w, x, y, z = quaternion.tolist()
    return x, y, z, w


# What a robot has under it where there is no pile.
_NONE, _TABLE = np.zeros(0), np.zeros((0, 3))
NOTHING = Pile(_NONE, _NONE, _NONE, 0.0, _TABLE, _TABLE, 0.0, _NONE, _TABLE, _TABLE)
UNTOUCHED: Footprint = new_footprint(0)
