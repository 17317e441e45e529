"""From a tape to the columns of a log: everything here is vectorised over the trial."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.kinematics.fsr import sensor_loads
from gaitlab.kinematics.polygon import support_margin
from gaitlab.kinematics.transforms import quaternion_of, roll_pitch_yaw, rotation_of
from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import FEET, FSRS
from gaitlab.model import LinkPoses, Robot, couplings_of
from gaitlab.model.clearance import legs_gap
from gaitlab.model.gait import FeetPoses
from gaitlab.simulation.tape import Contacts, Tape

LOADED = 0.05  # share of the weight; a sole that carries less counts as in the air
MIDDLE = 0.01  # of the sole's length or width, within which a point is on its dividing line
QUANTITIES = ("target", "position", "velocity", "torque")

Columns = dict[str, np.ndarray]


def log_of(
    tape: Tape,
    robot: Robot,
    header: LogHeader,
    feet: FeetPoses,
    targets: np.ndarray,
) -> TrialLog:
    """The log of a trial.

    Args:
        tape: What the engine gave.
        robot: The robot that walked.
        header: Constants of the trial.
        feet: What the gait commanded, at least as long as the tape.
        targets: What the servos were sent, in [rad]. Shape (ticks, joints).
    """
    n = tape.length
    poses = _link_poses(tape, robot)
    load = _load(tape.contacts, robot, poses)
    loaded = load.force[:, 2] > LOADED * header.weight
    arrays: Columns = {
        "time": (np.arange(n) + 1) * header.dt,
        "gait_phase": feet.phase[:n],
        "step_index": feet.step_index[:n],
        "support": loaded[0] + 2 * loaded[1],
        "fall_cause": tape.fall_cause[:n],
        "body_contact": tape.body_touches[:n],
        "feet_gap": legs_gap(robot, poses),
        **_trunk_columns(tape, robot, poses),
        **_sole_columns(tape, robot, header, poses, load, loaded),
        **_joint_columns(tape, header, _wanted(tape, robot, targets)),
    }
    return TrialLog(header=header, arrays=arrays)


def _named(name: str, axes: Iterable[str], rows: Iterable[np.ndarray]) -> Columns:
    return {f"{name}{axis}": row for axis, row in zip(axes, rows, strict=True)}


def _link_poses(tape: Tape, robot: Robot) -> LinkPoses:
    n, joints = tape.length, len(robot.tree.joints)
    origin, rotation = tape.trunk[:n, 0:3], rotation_of(tape.trunk[:n, 3:7])
    return robot.tree.poses(origin, rotation, tape.joints[:n, 0, :joints])


def _trunk_columns(tape: Tape, robot: Robot, poses: LinkPoses) -> Columns:
    base = tape.trunk[: tape.length].T
    return {
        **_named("trunk_", "xyz", poses.position[:, 0].T),
        **_named("trunk_q", "xyzw", base[3:7]),
        **_named("", ("roll", "pitch", "yaw"), roll_pitch_yaw(poses.rotation[:, 0]).T),
        **_named("trunk_v", "xyz", base[7:10]),
        **_named("trunk_w", "xyz", base[10:13]),
        **_named("com_", "xyz", robot.tree.centre_of_mass(poses).T),
    }


def _sole_columns(
    tape: Tape,
    robot: Robot,
    header: LogHeader,
    poses: LinkPoses,
    load: _Load,
    loaded: np.ndarray,
) -> Columns:
    columns: Columns = {}
    corners = []
    for side, foot in enumerate(FEET):
        link, name = robot.tree.index(robot.feet[side]), f"{foot}_foot_"
        corners.append([poses.point(link, corner) for corner in robot.sole.corners(side)])
        plough, push = (part[: tape.length, side].T for part in (tape.plough, tape.push))
        columns |= {
            **_named(name, "xyz", poses.point(link, robot.sole.centre_of(side))),
            **_named(f"{name}q", "xyzw", quaternion_of(poses.rotation[:, link]).T),
            f"{name}sink": header.pile_height - np.min([z for _, _, z in corners[-1]], axis=0),
            f"{name}normal_force": load.force[side, 2],
            **_named(f"{name}force_", "xy", load.force[side, :2] + push),
            f"{name}plough_force": np.hypot(*plough),
            f"{name}contact": loaded[side],
            **_named(f"{name}fsr_", FSRS, _fsr_loads(robot, side, load)),
        }
    return columns | _zmp_columns(load, np.array(corners), loaded)


def _zmp_columns(load: _Load, corners: np.ndarray, loaded: np.ndarray) -> Columns:
    """ZMP and its margin; corners of both soles, world frame, in [m], have shape (2, 4, 3, n)."""
    zmp = load.tipping / np.where(loaded.any(axis=0), load.normal, np.nan)
    margin = support_margin(zmp.T, np.moveaxis(corners[:, :, :2], -1, 0), loaded.T)
    return {**_named("zmp_", "xy", zmp), "zmp_margin": margin}


def _fsr_loads(robot: Robot, foot: int, load: _Load) -> np.ndarray:
    """What a foot's sensors read, or the quarters of the sole of a robot without any, in [N].

    Shape (4, n).
    """
    sensors = robot.sole.sensors(foot)
    if sensors is None:
        return load.quarters[foot]
    total = load.force[foot, 2]
    centre = load.moments[foot] / np.where(total > 0.0, total, 1.0)
    return sensor_loads(total, centre.T, sensors).T


class _Load(NamedTuple):
    """What the contacts under the soles add up to at each tick; feet are ordered left, right.

    Attributes:
        force: Force on each sole, world frame, in [N]. Shape (2, 3, n).
        quarters: Vertical force on the quarters of each sole, in [N]; a point on a dividing line
            is shared. Shape (2, 4, n).
        moments: Vertical force times the place x and y in the ankle's frame, in [N m]. (2, 2, n).
        normal: Vertical force on both soles, in [N]. Shape (n,).
        tipping: Vertical force on both soles times the x and y of the ZMP, in [N m]. (2, n).
    """

    force: np.ndarray
    quarters: np.ndarray
    moments: np.ndarray
    normal: np.ndarray
    tipping: np.ndarray


def _load(contacts: Contacts, robot: Robot, poses: LinkPoses) -> _Load:
    links = [robot.tree.index(foot) for foot in robot.feet]
    at, turned = (np.ascontiguousarray(np.moveaxis(part[:, links], 0, -1)) for part in poses)
    centres = np.array([robot.sole.centre_of(foot) for foot in range(2)])
    middle = MIDDLE * np.array([robot.sole.length, robot.sole.width])
    return _Load(*_added_up(contacts, at, turned, centres, middle))


@njit
def _added_up(
    contacts: Contacts, at: np.ndarray, turned: np.ndarray, centres: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The fields of `_Load`.

    The ZMP lies on the load-weighted mean height of the contact points. The plough force is left
    out: its lever is a few millimetres.

    Args:
        contacts: Points under the soles.
        at: Of the feet, world frame, in [m]. Shape (2, 3, n).
        turned: Rotations of the feet. Shape (2, 3, 3, n).
        centres: Of the soles, in the ankle's frame, in [m]. Shape (2, 3).
        middle: Half widths of what counts as on a dividing line, in [m]. Shape (2,).
    """
    (tick, side, position, force), n = contacts, at.shape[-1]
    forces, quarters, moments = np.zeros((2, 3, n)), np.zeros((2, 4, n)), np.zeros((2, 2, n))
    normal, height, tipping = np.zeros(n), np.zeros(n), np.zeros((2, n))
    share = np.empty((2, 2))  # of a point in front and rear, in left and right
    for p in range(len(tick)):
        k, foot, vertical = tick[p], side[p], force[p, 2]
        for axis in range(3):
            forces[foot, axis, k] += force[p, axis]
        for axis in range(2):
            local = 0.0
            for i in range(3):
                local += turned[foot, i, axis, k] * (position[p, i] - at[foot, i, k])
            moments[foot, axis, k] += vertical * local
            local -= centres[foot, axis]
            share[axis, 0] = 0.5 + (0.5 * np.sign(local) if abs(local) >= middle[axis] else 0.0)
            share[axis, 1] = 1.0 - share[axis, 0]
        for quarter in range(4):
            part = vertical * share[0, quarter // 2] * share[1, quarter % 2]
            quarters[foot, quarter, k] += part
        normal[k] += vertical
        height[k] += vertical * position[p, 2]
    for k in range(n):
        height[k] /= normal[k] if normal[k] != 0.0 else 1.0
    for p in range(len(tick)):
        k, vertical = tick[p], force[p, 2]
        lever = position[p, 2] - height[k]
        for axis in range(2):
            tipping[axis, k] += vertical * position[p, axis] - lever * force[p, axis]
    return forces, quarters, moments, normal, tipping


def _wanted(tape: Tape, robot: Robot, targets: np.ndarray) -> np.ndarray:
    """Where each joint of the log should be, in [rad]; a coupled one where its leader turns it."""
    n, columns = tape.length, tape.joints.shape[2]
    wanted = np.zeros((n, columns))
    wanted[:, : targets.shape[1]] = targets[:n]
    column = {joint.name: k for k, joint in enumerate(robot.tree.joints)}
    for leader, follower, ratio in couplings_of(robot):
        wanted[:, column[follower]] = ratio * tape.joints[:n, 0, column[leader]]
    return wanted


def _joint_columns(tape: Tape, header: LogHeader, targets: np.ndarray) -> Columns:
    states = tape.joints[: tape.length]
    tables = dict(zip(QUANTITIES, (targets, *np.moveaxis(states, 1, 0)), strict=True))
    columns: Columns = {}
    for quantity, table in tables.items():
        rows = np.ascontiguousarray(table.T, dtype=np.float32)
        columns |= _named("", (f"{joint}_{quantity}" for joint in header.joints), rows)
    return columns
