"""A robot on its servos and its ground in Bullet, advanced tick by tick.

A tick that is too long for the servos is several steps of Bullet; its torque is their mean.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.model import Robot, Start, Vector, couplings_of, gantry_of
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineSettings, Spread
from gaitlab.servos.latency import Latency
from gaitlab.simulation.bullet.couplings import add_couplings
from gaitlab.simulation.bullet.gantry import Rig
from gaitlab.simulation.bullet.grass import PileUnderFeet, add_layer
from gaitlab.simulation.bullet.motors import Motors, steps_in
from gaitlab.simulation.bullet.world import (
    VELOCITY_CONTROL,
    WORLD_FRAME,
    add_plane,
    add_robot,
    indices,
    let_legs_meet,
    mobility,
    new_world,
    place_base,
    turn_of_principal_axes,
)
from gaitlab.simulation.ending import GOES_ON, Ending
from gaitlab.simulation.engine import DOWN, replicate
from gaitlab.simulation.tape import Tape
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile
from gaitlab.surfaces.under_feet import UnderFeet

ORIGIN = (0.0, 0.0, 0.0)
SLOP = 1e-5  # m, by which Bullet lets bodies overlap; put down without it they fall for a tick
RAW_FIELDS = 17  # of a contact as it is noted: tick, side, point, three forces with directions


class BulletEngine:
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
        self._client = client = new_world(settings.solver_iterations, gravity)
        add_plane(client, 0.0)
        self._body = add_robot(client, robot, drawn.friction)
        found = indices(client, self._body)
        let_legs_meet(client, self._body, robot, found, start.joints)
        self._principal = turn_of_principal_axes(client, self._body)
        self._centre = robot.tree.links[0].centre
        left, right = (found.link[name] for name in robot.feet)
        self._sides = {left: 0, right: 1}
        self._all_joints = [found.joint[joint.name] for joint in robot.tree.joints]
        driven = np.flatnonzero(robot.tree.driven)
        self._joints = [self._all_joints[k] for k in driven]
        kind = gantry_of(robot)
        every = len(driven) == len(self._all_joints) and kind == "none"
        self._driven: slice | np.ndarray = slice(None) if every else driven
        self._rig = None if kind == "none" else Rig(client, self._body, found, kind)
        self._read = [*self._all_joints, *([] if self._rig is None else [self._rig.pitch])]
        self._place(start, lift=-SLOP)
        loose = mobility(client, self._body, self._joints)
        names = [joint.name for joint in robot.tree.joints if joint.servo is not None]
        legs = [k for k, name in enumerate(names) if name in _leg_joints(robot)]
        tied = {name for gear in couplings_of(robot) for name in (gear.leader, gear.follower)}
        geared = [k for k, name in enumerate(names) if name in tied]
        self._steps = steps_in(drawn.servos, loose, legs, geared, settings.dt)
        dt = settings.dt / self._steps
        client.setTimeStep(dt)
        add_couplings(client, self._body, couplings_of(robot), found.joint, dt=dt)
        self._latency = Latency(drawn.servos, dt, start.targets[self._driven])
        self._motors = Motors(drawn.servos, drawn.gain, dt, loose)
        self._pile: PileUnderFeet | None = None
        if isinstance(surface, SoftLayer):
            add_layer(client, surface, len(robot.sole.supports()))
        elif isinstance(surface, TuftedPile | FibreMat):
            lawn = UnderFeet(
                robot,
                surface,
                dt=dt,
                irregularity=spread.terrain,
                rng=drawn.terrain,
                down=-gravity[2],
            )
            self._pile = PileUnderFeet(client, self._body, (left, right), lawn, dt=dt)
            self._place(start, lift=self._pile.settle() - SLOP)
        self._now: np.ndarray | None = None
        self._force = ORIGIN
        # The calls of a step, looked up once: the client wraps a function each time it is asked.
        self._step, self._control = client.stepSimulation, client.setJointMotorControlArray
        self._joint_states, self._contact_points = client.getJointStates, client.getContactPoints
        self._base_pose = client.getBasePositionAndOrientation
        self._base_velocity = client.getBaseVelocity

    def __enter__(self) -> BulletEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()

    def _place(self, start: Start, lift: float) -> None:
        client, (joints, position, turn, _) = self._client, start
        x, y, z = position.tolist()
        for index, angle in zip(self._all_joints, joints, strict=True):
            client.resetJointState(self._body, index, float(angle))
        if self._rig is not None:
            self._rig.place(x, z + lift, 2.0 * float(np.arctan2(turn[1], turn[3])))
            return
        place_base(client, self._body, (x, y, z + lift), turn.tolist())

    @property
    def trunk(self) -> np.ndarray:
        """The trunk as it is now."""
        row = np.empty((1, 13))
        self._read_trunk(row[0])
        row[:, 0:3] -= self._from_origin(row)
        return row[0]

    def pull(self, force: Vector) -> None:
        """Pull at the trunk from now on."""
        self._force = force

    def advance(self, targets: np.ndarray, tape: Tape, ending: Ending) -> int:
        """Servos drive, the pile pushes back, then Bullet solves; once a step of every tick."""
        due = self._latency.arriving(np.repeat(targets[:, self._driven], self._steps, axis=0))
        first, code, noted = tape.length, GOES_ON, list[float]()
        for tick in range(len(targets)):
            steps = due[tick * self._steps : (tick + 1) * self._steps]
            tape.joints[tape.length] = self._tick(steps)
            tape.body_touches[tape.length] = touches = self._note_contacts(tape.length, noted)
            if self._pile is not None:
                tape.plough[tape.length] = self._pile.plough
                tape.push[tape.length] = self._pile.push
            row = tape.trunk[tape.length]
            self._read_trunk(row)
            tape.length += 1
            code = self._ended(ending, row, touches)
            if code != GOES_ON:
                break
        rows = tape.trunk[first : tape.length]
        rows[:, 0:3] -= self._from_origin(rows)
        _write_contacts(np.array(noted).reshape(-1, RAW_FIELDS), tape)
        return code

    def _tick(self, due: np.ndarray) -> np.ndarray:
        """Step as often as targets are due; positions, velocities and torques of the joints."""
        spent: np.ndarray | float = 0.0
        for targets in due:
            position, velocity, applied = self._read_joints()[:, self._driven]
            speed, torque = self._motors.drive(targets, position, velocity, applied)
            self._control(
                self._body, self._joints, VELOCITY_CONTROL, targetVelocities=speed, forces=torque
            )
            if self._pile is not None:
                self._pile.press()
            if self._force != ORIGIN:
                self._pull()
            self._step()
            self._now = None
            if len(due) > 1:
                spent = spent + self._read_joints()[2] / len(due)
        joints = self._read_joints()
        return joints if len(due) == 1 else np.array((joints[0], joints[1], spent))

    def _pull(self) -> None:
        link = -1 if self._rig is None else self._rig.pitch
        at, _, _, _ = self._trunk_of_bullet()
        self._client.applyExternalForce(self._body, link, self._force, at, WORLD_FRAME)

    def _read_joints(self) -> np.ndarray:
        """Positions, velocities and torques of the joints, read from Bullet once a step."""
        if self._now is None:
            states = self._joint_states(self._body, self._read)
            position, velocity, _, torque = zip(*states, strict=True)
            self._now = np.array((position, velocity, torque))
        return self._now

    def _note_contacts(self, tick: int, noted: list[float]) -> bool:
        """Note what is under the soles; says whether another link is on the ground.

        Of Bullet's contact points the robot is body A: link in field 3, point in 5, normal force up
        in 9, friction on it in 10 to 13.
        """
        touches = False
        for p in self._contact_points(self._body):
            if p[2] == self._body:
                continue  # one leg and the other
            side = self._sides.get(p[3])
            if side is None:  # Bullet also lists what is near
                touches = touches or p[9] > 0.0
            else:
                noted.extend((tick, side, *p[5], p[9], *p[7], p[10], *p[11], p[12], *p[13]))
        return touches

    def _trunk_of_bullet(self) -> tuple[Vector, tuple[float, float, float, float], Vector, Vector]:
        """Centre of mass, orientation xyzw, velocity and spin of the trunk."""
        if self._rig is not None:
            return self._rig.trunk()
        position, quaternion = self._base_pose(self._body)
        if self._principal is not None:
            _, quaternion = self._client.multiplyTransforms(
                ORIGIN, quaternion, ORIGIN, self._principal
            )
        velocity, spin = self._base_velocity(self._body)
        return position, quaternion, velocity, spin

    def _read_trunk(self, row: np.ndarray) -> None:
        """As a row of the tape, but for the position, which is still that of the centre."""
        row[0:3], row[3:7], row[7:10], row[10:13] = self._trunk_of_bullet()

    def _from_origin(self, rows: np.ndarray) -> np.ndarray:
        """From the trunk's link frame to its centre of mass, in [m]. Shape (n, 3)."""
        offset: np.ndarray = rotation_of(rows[:, 3:7]) @ np.array(self._centre)
        return offset

    def _ended(self, ending: Ending, row: np.ndarray, touches: bool) -> int:
        """What `ended` says of a row whose position is still that of the centre of mass."""
        px, py, pz, x, y, z, w = row[:7].tolist()
        cx, cy, cz = self._centre
        at = (
            px
            - (
                (1.0 - 2.0 * (y * y + z * z)) * cx
                + 2.0 * (x * y - z * w) * cy
                + 2.0 * (x * z + y * w) * cz
            ),
            py
            - (
                2.0 * (x * y + z * w) * cx
                + (1.0 - 2.0 * (x * x + z * z)) * cy
                + 2.0 * (y * z - x * w) * cz
            ),
            pz
            - (
                2.0 * (x * z - y * w) * cx
                + 2.0 * (y * z + x * w) * cy
                + (1.0 - 2.0 * (x * x + y * y)) * cz
            ),
        )
        return ending.after(np.array((*at, x, y, z, w)), touches)


def _leg_joints(robot: Robot) -> set[str]:
    """Names of the joints that carry the feet."""
    tree, chain = robot.tree, set[str]()
    for foot in robot.feet:
        link = tree.links[tree.index(foot)]
        while link.joint is not None and link.parent is not None:
            chain.add(link.joint.name)
            link = tree.links[tree.index(link.parent)]
    return chain


def _write_contacts(raw: np.ndarray, tape: Tape) -> None:
    """What was noted, with one force a point."""
    tape.reserve(len(raw))
    rows = tape.points[tape.contacts_used : tape.contacts_used + len(raw)]
    rows[:, :5] = raw[:, :5]
    rows[:, 5:] = sum(raw[:, i, None] * raw[:, i + 1 : i + 4] for i in (5, 9, 13))
    tape.contacts_used += len(raw)
