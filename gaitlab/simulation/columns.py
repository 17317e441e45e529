"""From a tape to the columns of a log: everything here is vectorised over the trial."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

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
    contacts = tape.contacts
    soles = _sole_columns(tape, robot, header, poses, contacts)
    loaded = np.stack([soles[f"{side}_foot_contact"] for side in FEET], axis=-1)
    arrays: Columns = {
        "time": (np.arange(n) + 1) * header.dt,
        "gait_phase": feet.phase[:n],
        "step_index": feet.step_index[:n],
        "support": loaded @ np.array([1, 2]),
        "fall_cause": tape.fall_cause[:n],
        "body_contact": tape.body_touches[:n],
        "feet_gap": legs_gap(robot, poses),
        **_trunk_columns(tape, robot, poses),
        **_zmp_columns(contacts, robot, poses, loaded),
        **soles,
        **_joint_columns(tape, header, _wanted(tape, robot, targets)),
    }
    return TrialLog(header=header, arrays=arrays)


def _named(name: str, axes: Iterable[str], table: np.ndarray) -> Columns:
    return {f"{name}{axis}": table[:, i] for i, axis in enumerate(axes)}


def _link_poses(tape: Tape, robot: Robot) -> LinkPoses:
    n, joints = tape.length, len(robot.tree.joints)
    origin, rotation = tape.trunk[:n, 0:3], rotation_of(tape.trunk[:n, 3:7])
    return robot.tree.poses(origin, rotation, tape.joints[:n, 0, :joints])


def _trunk_columns(tape: Tape, robot: Robot, poses: LinkPoses) -> Columns:
    base = tape.trunk[: tape.length]
    attitude = roll_pitch_yaw(poses.rotation[:, 0])
    return {
        **_named("trunk_", "xyz", poses.position[:, 0]),
        **_named("trunk_q", "xyzw", base[:, 3:7]),
        **_named("", ("roll", "pitch", "yaw"), attitude),
        **_named("trunk_v", "xyz", base[:, 7:10]),
        **_named("trunk_w", "xyz", base[:, 10:13]),
        **_named("com_", "xyz", robot.tree.centre_of_mass(poses)),
    }


def _sole_columns(
    tape: Tape, robot: Robot, header: LogHeader, poses: LinkPoses, contacts: Contacts
) -> Columns:
    columns: Columns = {}
    for side, foot in enumerate(FEET):
        link = robot.tree.index(robot.feet[side])
        position, rotation = poses.position[:, link], poses.rotation[:, link]
        name, own = f"{foot}_foot_", contacts.of(side)
        beside = (part[: tape.length, side] for part in (tape.plough, tape.push))
        columns |= _pose_columns(name, robot, header, position, rotation)
        columns |= _force_columns(name, header, own, *beside)
        columns |= _fsr_columns(f"{name}fsr_", robot, side, position, rotation, own)
    return columns


def _pose_columns(
    name: str, robot: Robot, header: LogHeader, position: np.ndarray, rotation: np.ndarray
) -> Columns:
    foot = FEET.index(name.split("_")[0])
    corners = position[:, None] + robot.sole.corners(foot) @ np.swapaxes(rotation, 1, 2)
    return {
        **_named(name, "xyz", position + rotation @ np.array(robot.sole.centre_of(foot))),
        **_named(f"{name}q", "xyzw", quaternion_of(rotation)),
        f"{name}sink": header.pile_height - corners[..., 2].min(axis=1),
    }


def _force_columns(
    name: str, header: LogHeader, contacts: Contacts, plough: np.ndarray, push: np.ndarray
) -> Columns:
    n = len(plough)
    force = np.stack([contacts.total(contacts.force[:, a], n) for a in range(3)], axis=-1)
    return {
        f"{name}normal_force": force[:, 2],
        **_named(f"{name}force_", "xy", force[:, :2] + push),
        f"{name}plough_force": np.hypot(*plough.T),
        f"{name}contact": force[:, 2] > LOADED * header.weight,
    }


def _fsr_columns(
    name: str,
    robot: Robot,
    foot: int,
    position: np.ndarray,
    rotation: np.ndarray,
    contacts: Contacts,
) -> Columns:
    """Loads of a foot's sensors, or of the quarters of the sole of a robot without any."""
    from_ankle = contacts.position - position[contacts.tick]
    turned = np.einsum("pji,pj->pi", rotation[contacts.tick], from_ankle)
    sensors = robot.sole.sensors(foot)
    if sensors is not None:
        return _named(name, FSRS, _sensor_loads(turned, contacts, len(position), sensors))
    return _quarter_columns(name, robot, foot, turned, contacts, len(position))


def _sensor_loads(
    local: np.ndarray, contacts: Contacts, ticks: int, sensors: np.ndarray
) -> np.ndarray:
    """What the sensors read of contacts at points in the ankle frame, in [N]. Shape (n, 4)."""
    vertical = contacts.force[:, 2]
    total = contacts.total(vertical, ticks)
    moments = (contacts.total(vertical * local[:, axis], ticks) for axis in range(2))
    centre = np.stack(tuple(moments), axis=-1) / np.where(total > 0.0, total, 1.0)[:, None]
    return sensor_loads(total, centre, sensors)


def _quarter_columns(
    name: str, robot: Robot, foot: int, turned: np.ndarray, contacts: Contacts, ticks: int
) -> Columns:
    """Vertical load on the quarters of the sole; a point on a dividing line is shared."""
    local = turned - np.array(robot.sole.centre_of(foot))
    front, left = _share(local[:, 0], robot.sole.length), _share(local[:, 1], robot.sole.width)
    along = {"front": front, "rear": 1.0 - front}
    across = {"left": left, "right": 1.0 - left}
    parts = ((fsr, *fsr.split("_")) for fsr in FSRS)
    return {
        name + fsr: contacts.total(contacts.force[:, 2] * along[a] * across[b], ticks)
        for fsr, a, b in parts
    }


def _share(coordinate: np.ndarray, extent: float) -> np.ndarray:
    """1 on the positive side, 0 on the negative, one half within a hundredth of the middle."""
    return np.where(np.abs(coordinate) < 0.01 * extent, 0.5, coordinate > 0.0)


def _zmp_columns(contacts: Contacts, robot: Robot, poses: LinkPoses, loaded: np.ndarray) -> Columns:
    """ZMP from the contact forces, on the load-weighted mean height of the contact points.

    The plough force is left out: its lever is a few millimetres.
    """
    n, normal = len(loaded), contacts.force[:, 2]
    total = np.where(loaded.any(axis=1), contacts.total(normal, n), np.nan)
    height = contacts.total(normal * contacts.position[:, 2], n) / total
    lever = contacts.position[:, 2] - height[contacts.tick]
    moments = normal[:, None] * contacts.position[:, :2] - lever[:, None] * contacts.force[:, :2]
    zmp = np.stack([contacts.total(moments[:, a], n) / total for a in range(2)], axis=-1)
    margin = support_margin(zmp, _sole_corners(robot, poses), loaded)
    return {**_named("zmp_", "xy", zmp), "zmp_margin": margin}


def _sole_corners(robot: Robot, poses: LinkPoses) -> np.ndarray:
    """Corners of both soles on the ground plane, in [m]. Shape (n, 2, 4, 2)."""
    links = [robot.tree.index(foot) for foot in robot.feet]
    corners = np.stack([robot.sole.corners(foot) for foot in range(len(links))])
    turned = corners @ np.swapaxes(poses.rotation[:, links], 2, 3)
    return (poses.position[:, links, None] + turned)[..., :2]


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
    quantities = (
        ("target", targets),
        ("position", states[:, 0]),
        ("velocity", states[:, 1]),
        ("torque", states[:, 2]),
    )
    return {
        f"{joint}_{quantity}": table[:, j]
        for j, joint in enumerate(header.joints)
        for quantity, table in quantities
    }
