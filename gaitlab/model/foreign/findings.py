"""What there is to know of a foreign robot before it walks: lengths, stance, reach, use of servos.

Standing is static: a joint carries the weight of all links beyond it and, in a leg, half of the
robot's weight upwards at the middle of that leg's sole. That is the transpose of the Jacobian times
the force [LynchPark2017, eq. 5.26], without what the feet push against each other.

References:
    LynchPark2017: Lynch and Park, Modern Robotics, Cambridge University Press, 2017.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gaitlab.errors import FileError, Infeasible, Problem
from gaitlab.log import GRAVITY
from gaitlab.model.foreign.anatomy import roles
from gaitlab.model.foreign.reduced import SoleSize
from gaitlab.model.foreign.robot import ForeignRobot
from gaitlab.model.foreign.robot_file import FROM_FILE, Loaded, Statement
from gaitlab.model.gait import FeetPoses, Gait
from gaitlab.model.servo import Servo
from gaitlab.model.stance import EXTENSIONS, Stance, stance_of, standing_feet
from gaitlab.model.tree import LinkPoses, Tree, unit_axis
from gaitlab.parameters import parameter_table

FINEST = 1e-3  # m, to which a reach is known
FARTHEST = 1.5  # leg lengths, beyond which no foot gets
STEPS = 24  # into which a way is parted where it is looked for its end
TICK = 0.002  # s, between instants at which a walk's speeds are taken
CYCLES = 2.0  # of the walk at full amplitude
DIRECTIONS = {  # forward, left and up in which the left foot is moved
    **{"forward": (1.0, 0.0, 0.0), "back": (-1.0, 0.0, 0.0)},
    **{"out": (0.0, 1.0, 0.0), "up": (0.0, 0.0, 1.0)},
}
STRAIGHT, FOLDED = "straight leg", "folded leg"  # what ends a reach if no joint does


class LegFindings(NamedTuple):
    """The legs, lengths in [m].

    Attributes:
        feet: Names of the left and the right foot link in the file.
        pelvis: Name of the link that both legs hang on.
        hips_apart: Between the hips.
        thigh: Hip to knee, between their pitch axes.
        shank: Knee to ankle.
        ankle: Ankle over the sole.
        length: Hip to sole of a straight leg.
        roles: What each joint does from the hip down: yaw, roll or pitch by its first letter, small
            for a slanted axis.
        mirror_misfit: Largest distance of the axes of one leg from the other's mirror image.
        names_agree: Joints and feet whose names say the side that was found.
        names_with_side: Joints and feet whose names say a side.
    """

    feet: tuple[str, str]
    pelvis: str
    hips_apart: float
    thigh: float
    shank: float
    ankle: float
    length: float
    roles: str
    mirror_misfit: float
    names_agree: int
    names_with_side: int


class SoleFindings(NamedTuple):
    """The left sole, lengths in [m], angles in [rad].

    Attributes:
        length: Along the foot.
        width: Across it.
        heel: Heel edge behind the ankle axis.
        heel_behind_joint: Heel edge behind where the file draws the foot's joint.
        height: Ankle axis over the sole.
        outward: Middle of the sole outside the ankle.
        tilt: Between sole and ground at zero angles.
        shapes: How many shapes of each kind the foot has; empty if it has none.
        stated: Which of the lengths the robot file states.
    """

    length: float
    width: float
    heel: float
    heel_behind_joint: float
    height: float
    outward: float
    tilt: float
    shapes: Mapping[str, int]
    stated: tuple[str, ...]


class StanceFindings(NamedTuple):
    """How the robot stands, lengths in [m].

    Attributes:
        hip_height: Hips over the soles.
        com_height: Centre of mass over the soles.
        com_ahead: Centre of mass ahead of the middle of the soles.
        natural_period: Of a pendulum as long as the centre of mass is high, in [s].
        knees: Which way they bend, `forward` or `backward`.
        joints: Angle of each joint, in [rad].
    """

    hip_height: float
    com_height: float
    com_ahead: float
    natural_period: float
    knees: str
    joints: Mapping[str, float]


class FootReach(NamedTuple):
    """How far the left foot, kept level, gets from standing in a direction, and why no farther.

    Attributes:
        distance: In [m].
        ends: The joint that is then at its limit; `straight leg` or `folded leg` if there is none.
    """

    distance: float
    ends: str


class ServoFindings(NamedTuple):
    """Servos of one type and how much of them is used.

    Attributes:
        servo: What they are called.
        stated_by: Who states torque and speed.
        torque: Largest torque, in [N m].
        speed: Without load, in [rad/s].
        joints: Joints that have one.
        standing_torque: Largest torque of standing, in [N m].
        standing_joint: Which joint has it.
        walk_speed: Largest speed of the default walk, in [rad/s]; None if there is no such walk.
        walk_joint: Which joint has it.
    """

    servo: str
    stated_by: Statement
    torque: float
    speed: float
    joints: tuple[str, ...]
    standing_torque: float
    standing_joint: str
    walk_speed: float | None
    walk_joint: str | None

    @property
    def standing_share(self) -> float:
        """Of the largest torque, used by standing."""
        return self.standing_torque / self.torque


@dataclass(frozen=True, kw_only=True)
class RobotFindings:
    """A foreign robot in numbers.

    Attributes:
        name: What its file calls it.
        links: Links of the URDF.
        joints: Joints that turn.
        mass: Of the robot, in [kg].
        legs: The legs.
        sole: The soles.
        stance: How it stands.
        reach: How far a foot gets, by direction.
        servos: Servos by type.
        no_walk: Why the default walk cannot be commanded; empty if it can.
        warnings: What a user should know, a sentence each.
    """

    name: str
    links: int
    joints: int
    mass: float
    legs: LegFindings
    sole: SoleFindings
    stance: StanceFindings
    reach: Mapping[str, FootReach]
    servos: tuple[ServoFindings, ...]
    no_walk: str
    warnings: tuple[str, ...]

    @property
    def too_weak(self) -> tuple[ServoFindings, ...]:
        """Servos that cannot hold the robot as it stands."""
        return tuple(found for found in self.servos if found.standing_share > 1.0)


def findings_of(
    loaded: Loaded, servos: Sequence[Servo], walk: Callable[[ForeignRobot], Gait]
) -> RobotFindings:
    """What was found of a robot.

    Args:
        loaded: The robot of a file.
        servos: Of its joints, in the order of the tree.
        walk: The default walk of a robot.

    Raises:
        FileError: If it cannot stand.
    """
    robot: ForeignRobot = loaded.cls()
    stance = _standing(loaded)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    joints = robot.joint_targets(feet)
    speeds, no_walk = _walk_speeds(robot, walk)
    return RobotFindings(
        name=loaded.bodies.name,
        links=loaded.bodies.link_count,
        joints=len(loaded.bodies.bodies) - 1,
        mass=robot.tree.mass,
        legs=_legs(loaded, stance),
        sole=_sole(loaded, robot),
        stance=_stance(loaded, robot, stance, joints),
        reach={name: _reach(robot, feet, np.array(way)) for name, way in DIRECTIONS.items()},
        servos=_servos(loaded, robot, servos, standing_torques(robot, joints), speeds),
        no_walk=no_walk,
        warnings=loaded.notes,
    )


def _standing(loaded: Loaded) -> Stance:
    """How the robot of a file stands, its knees bent as its limits let them.

    Raises:
        FileError: If it cannot.
    """
    robot: ForeignRobot = loaded.cls()
    problems = []
    for extension in EXTENSIONS:
        try:
            return stance_of(robot, extension)
        except Infeasible as problem:
            problems.append(problem)
    fact, _, _ = problems[0].reason.partition(";")  # what follows is advice for a gait
    message = (
        f"it cannot stand, however its knees are bent: {problems[0].limb}: {fact}. Mend lower and "
        "upper of that joint's <limit>, or its axis"
    )
    raise FileError(
        [Problem(file=loaded.urdf, line=None, column=None, message=message)]
    ) from problems[0]


def _legs(loaded: Loaded, stance: Stance) -> LegFindings:
    bodies, legs, (left, right) = loaded.bodies.bodies, loaded.legs, loaded.found.legs
    thigh, shank = left.segments
    hip = left.pitch[0]
    return LegFindings(
        feet=(bodies[legs.left[-1]].name, bodies[legs.right[-1]].name),
        pelvis=bodies[legs.pelvis].name,
        hips_apart=float(left.points[hip, 1] - right.points[hip, 1]),
        thigh=thigh,
        shank=shank,
        ankle=stance.leg_length - thigh - shank,
        length=stance.leg_length,
        roles=roles(left.axes),
        mirror_misfit=legs.apart,
        names_agree=legs.named[0],
        names_with_side=legs.named[1],
    )


def _sole(loaded: Loaded, robot: ForeignRobot) -> SoleFindings:
    sole, foot = robot.sole, loaded.found.legs[0]
    ahead = float(foot.rotation[:, 0] @ (foot.drawn - foot.ankle))
    shapes = loaded.bodies.bodies[loaded.legs.left[-1]].shapes
    table = parameter_table(type(sole))
    touched = [shape for shape in shapes if shape.collision] or shapes
    return SoleFindings(
        length=sole.length,
        width=sole.width,
        heel=sole.heel,
        heel_behind_joint=sole.heel + ahead,
        height=sole.height,
        outward=sole.outward,
        tilt=loaded.found.tilt,
        shapes=dict(Counter(shape.kind for shape in touched)),
        stated=tuple(name for name in SoleSize._fields if table[name].source == FROM_FILE),
    )


def _poses(tree: Tree, joints: np.ndarray) -> LinkPoses:
    """Poses of the links with the trunk level at the origin."""
    n = len(joints)
    return tree.poses(np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), joints)


def _stance(
    loaded: Loaded, robot: ForeignRobot, stance: Stance, joints: np.ndarray
) -> StanceFindings:
    tree, leg = robot.tree, loaded.found.legs[0]
    poses = _poses(tree, joints)
    middle = sum(_sole_centres(robot, poses)) / 2.0
    carrying = {link.joint.name: k for k, link in enumerate(tree.links) if link.joint is not None}
    hip, knee, ankle = (poses.position[0, carrying[leg.joints[k]]] for k in leg.pitch)
    straight = hip + (ankle - hip) * (hip[2] - knee[2]) / (hip[2] - ankle[2])
    return StanceFindings(
        hip_height=stance.hip_height,
        com_height=stance.com_height,
        com_ahead=float((tree.centre_of_mass(poses)[0] - middle)[0]),
        natural_period=stance.natural_period,
        knees="forward" if knee[0] > straight[0] else "backward",
        joints={
            joint.name: float(angle) for joint, angle in zip(tree.joints, joints[0], strict=True)
        },
    )


def _sole_centres(robot: ForeignRobot, poses: LinkPoses) -> list[np.ndarray]:
    """Middle of the left and the right sole at the first instant, in [m]. Shape (3,) each."""
    return [
        poses.position[0, k] + poses.rotation[0, k] @ np.array(robot.sole.centre_of(side))
        for side, k in enumerate(map(robot.tree.index, robot.feet))
    ]


def standing_torques(robot: ForeignRobot, joints: np.ndarray) -> np.ndarray:
    """Torque that holds each joint against gravity, both feet carrying, in [N m]. Shape (joints,).

    Args:
        robot: The robot.
        joints: Its pose over one instant, in [rad]. Shape (1, joints).
    """
    tree = robot.tree
    poses = _poses(tree, joints)
    loads = [  # of a link: force in [N] upwards and where it attacks
        (-link.mass * GRAVITY, poses.position[0, k] + poses.rotation[0, k] @ np.array(link.centre))
        for k, link in enumerate(tree.links)
    ]
    half = tree.mass * GRAVITY / 2.0
    carried: list[list[tuple[float, np.ndarray]]] = [[load] for load in loads]
    for foot, centre in zip(robot.feet, _sole_centres(robot, poses), strict=True):
        carried[tree.index(foot)].append((half, centre))
    for k in range(len(tree.links) - 1, 0, -1):  # a link carries what hangs on it
        carried[tree.index(str(tree.links[k].parent))] += carried[k]
    torques = []
    for k, link in enumerate(tree.links):
        if link.joint is None:
            continue
        axis = poses.rotation[0, k] @ unit_axis(link.joint.axis)
        at = poses.position[0, k]
        turning = sum(np.cross(place - at, (0.0, 0.0, force)) for force, place in carried[k])
        torques.append(-float(axis @ turning))
    return np.array(torques)


def _walk_speeds(
    robot: ForeignRobot, walk: Callable[[ForeignRobot], Gait]
) -> tuple[np.ndarray | None, str]:
    """Largest speed of each joint in a robot's walk, in [rad/s]; or why it cannot be walked."""
    try:
        made = walk(robot)
        until = made.startup_time + CYCLES * made.gait_period
        targets = robot.joint_targets(made.feet(np.arange(0.0, until, TICK)))
    except Infeasible as error:
        return None, f"{error.limb}: {error.reason}"
    return np.abs(np.diff(targets, axis=0)).max(axis=0) / TICK, ""


def _reach(robot: ForeignRobot, standing: FeetPoses, way: np.ndarray) -> FootReach:
    """How far the left foot gets along a direction, [-]. Shape (3,)."""
    good, step = 0.0, FARTHEST * _leg_length(robot) / STEPS
    while True:
        tried = good + step * np.arange(STEPS + 1)
        ended = _first_out_of_reach(robot, standing, tried[:, None] * way)
        good = float(tried[max(ended - 1, 0)])
        if step <= FINEST or ended > STEPS:
            break
        step = max(step / STEPS, FINEST)
    return FootReach(good, _ends(robot, standing.position[0, 0] + (good + step) * way))


def _first_out_of_reach(robot: ForeignRobot, standing: FeetPoses, moved: np.ndarray) -> int:
    """Which of the left foot's displacements from standing, in [m], is the first it cannot do.

    Shape (n, 3); n if it can do all of them.
    """
    feet = _repeated(standing, len(moved))
    feet.position[:, 0] += moved
    try:
        robot.joint_targets(feet)
    except Infeasible as error:
        return error.tick
    return len(moved)


def _repeated(feet: FeetPoses, n: int) -> FeetPoses:
    """Poses of one instant over n."""
    return FeetPoses(
        position=np.repeat(feet.position, n, axis=0),
        heading=np.repeat(feet.heading, n, axis=0),
        trunk_pitch=np.repeat(feet.trunk_pitch, n),
        ankle_pitch=np.repeat(feet.ankle_pitch, n, axis=0),
        knee_only=np.repeat(feet.knee_only, n, axis=0),
        swing=np.repeat(feet.swing, n, axis=0),
        phase=np.repeat(feet.phase, n),
        step_index=np.repeat(feet.step_index, n),
    )


def _leg_length(robot: ForeignRobot) -> float:
    return sum(robot.found.legs[0].segments) + robot.sole.height


def _ends(robot: ForeignRobot, target: np.ndarray) -> str:
    """The joint of the left leg that is farthest beyond its limit at a place of the foot in [m]."""
    limb, leg = robot.limbs()["left_leg"], robot.found.legs[0]
    try:
        angles = limb.inverse(target, 0.0)[0]
    except Infeasible:
        stretched = np.linalg.norm(target - leg.points[leg.pitch[0]]) > sum(leg.segments) / 2.0
        return STRAIGHT if stretched else FOLDED
    beyond = [
        max(joint.lower - angle, angle - joint.upper)
        for joint, angle in zip(limb.joints, angles, strict=True)
    ]
    return limb.joints[int(np.argmax(beyond))].name


def _servos(
    loaded: Loaded,
    robot: ForeignRobot,
    servos: Sequence[Servo],
    torques: np.ndarray,
    speeds: np.ndarray | None,
) -> tuple[ServoFindings, ...]:
    """Servos by type, the strongest first."""
    joints = robot.tree.joints
    found = []
    for name in dict.fromkeys(str(joint.servo) for joint in joints):
        places = [k for k, joint in enumerate(joints) if joint.servo == name]
        servo = servos[places[0]]
        stands = max(places, key=lambda k: abs(torques[k]))
        walks = None if speeds is None else max(places, key=lambda k: speeds[k])
        found.append(
            ServoFindings(
                servo=name,
                stated_by=loaded.stated_by[name],
                torque=servo.largest_torque,
                speed=servo.largest_speed,
                joints=tuple(joints[k].name for k in places),
                standing_torque=float(abs(torques[stands])),
                standing_joint=joints[stands].name,
                walk_speed=None if speeds is None else float(speeds[walks]),
                walk_joint=None if walks is None else joints[walks].name,
            )
        )
    return tuple(sorted(found, key=lambda each: -each.torque))
