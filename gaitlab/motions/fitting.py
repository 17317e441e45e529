"""Whether a robot can play a motion: its joints, their limits and speeds, reach and balance.

Everything is found before anything moves, each mistake at its line and column.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gaitlab.errors import FileError, Infeasible, Problem
from gaitlab.kinematics.polygon import support_margin
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Joint, Robot
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import FeetPoses
from gaitlab.model.servo import Servo
from gaitlab.motions.motion import Keyframe, Motion
from gaitlab.motions.track import Pose, Track
from gaitlab.plugins import suggestion

SPEED_SHARE = 0.8  # -, of the no-load speed; beyond it a loaded servo lags visibly
SAFE_MARGIN = 0.005  # m, CoM inside the soles' edge; less and the sway of a servo tips it over
SAMPLE_TIME = 0.02  # s, between two poses that are checked for reach and balance
STEPS = 40  # samples of a move for its speed; a cubic's peak is then found to 0.1 %
LIFTED = 0.002  # m, a sole higher than the lower one by more carries nothing


def require_playable(motion: Motion, robot: Robot, servos: Sequence[Servo]) -> None:
    """Refuse a motion that the robot cannot play.

    Raises:
        FileError: Everything that stands in the way, see `motion_problems`.
    """
    problems = motion_problems(motion, robot, servos)
    if problems:
        raise FileError(problems)


def motion_problems(motion: Motion, robot: Robot, servos: Sequence[Servo]) -> list[Problem]:
    """What keeps a robot from playing a motion, in the order of the file.

    Joints that it has not and limits come first; only a motion without such mistakes is followed
    over time for reach, speed and static balance.

    Args:
        motion: The motion.
        robot: The robot.
        servos: One per driven joint, in the order of the robot's tree.
    """
    joints = {joint.name: joint for joint in robot.tree.joints}
    problems = [p for frame in motion.frames for p in _joint_problems(frame, joints)]
    if not problems:
        problems = [*_pose_problems(motion, robot)]
    if not problems:
        problems = [*_speed_problems(motion, robot, servos), *_balance_problems(motion, robot)]
    return list(dict.fromkeys(problems))


def feet_poses(motion: Motion, pose: Pose) -> FeetPoses:
    """What a gait says that holds these poses of a motion."""
    n, height = len(pose.feet), pose.feet[..., 2]
    return FeetPoses(
        position=pose.feet,
        heading=np.zeros((n, 2)),
        trunk_pitch=pose.trunk_pitch,
        ankle_pitch=np.zeros((n, 2)),
        knee_only=np.zeros((n, 2)),
        swing=height > height.min(axis=1, keepdims=True) + LIFTED,
        phase=np.full(n, np.nan),
        step_index=np.full(n, -1),
        joints=dict(zip(motion.joints, pose.joints.T, strict=True)),
    )


def _joint_problems(frame: Keyframe, joints: dict[str, Joint]) -> Iterator[Problem]:
    for name, angle in frame.joints.items():
        place = frame.place(name)
        if name not in joints:
            yield place.problem(
                f"{frame.name}: the robot has no joint {name!r}{suggestion(name, joints)}"
            )
        elif not joints[name].lower <= angle <= joints[name].upper:
            low, high = joints[name].lower, joints[name].upper
            yield place.problem(
                f"{frame.name}: {name} is {angle:g} rad, its limits are {low:.3f} and "
                f"{high:.3f} rad"
            )


def _pose_problems(motion: Motion, robot: Robot) -> Iterator[Problem]:
    """The first instant at which a foot is out of reach or a leg joint beyond its limit."""
    track = Track(motion=motion)
    t = _instants(track)
    try:
        joint_commands(robot, feet_poses(motion, track.at(t)))
    except Infeasible as problem:
        frame = track.next_frame(t[problem.tick])
        yield frame.node.problem(f"{frame.name}: {problem.limb}: {problem.reason}")


def _instants(track: Track) -> np.ndarray:
    return np.arange(0.0, track.duration, SAMPLE_TIME)


def _speed_problems(motion: Motion, robot: Robot, servos: Sequence[Servo]) -> Iterator[Problem]:
    """Moves that ask a joint for more than its share of the no-load speed."""
    track = Track(motion=motion)
    allowed = np.full(len(robot.tree.joints), np.inf)  # of a joint that only follows
    fastest = [servo.no_load_speed * servo.supply / servo.voltage for servo in servos]
    allowed[np.array(robot.tree.driven)] = SPEED_SHARE * np.array(fastest)
    for start, end, duration in track.moves:
        pose = _way(track, start, end, duration)
        speed = np.abs(np.diff(joint_commands(robot, feet_poses(motion, pose)), axis=0)).max(axis=0)
        speed *= (len(pose.trunk_pitch) - 1) / duration
        for j in np.flatnonzero(speed > allowed):
            name = robot.tree.joints[j].name
            yield end.place(name).problem(
                f"{end.name}: {name} would reach {speed[j]:.2f} rad/s, allowed is "
                f"{allowed[j]:.2f} rad/s, {SPEED_SHARE:.0%} of its servo's no-load speed; set "
                f"move_time to at least {end.move_time * speed[j] / allowed[j]:.3f} s"
            )


def _way(track: Track, start: Keyframe, end: Keyframe, duration: float) -> Pose:
    """Poses on the way between two frames, close enough for a speed."""
    frames = (replace(start, pause_time=0.0), replace(end, pause_time=0.0))
    alone = Track(motion=replace(track.motion, frames=frames))
    return alone.at(np.linspace(0.0, duration * (1.0 - 1e-9), STEPS + 1))


def _balance_problems(motion: Motion, robot: Robot) -> Iterator[Problem]:
    """Each frame on the way to which the centre of mass comes too near the soles' edge."""
    track = Track(motion=motion)
    t = _instants(track)
    margin = static_margin(robot, feet_poses(motion, track.at(t)))
    lowest: dict[int, tuple[float, Keyframe]] = {}
    for time, found in zip(t, margin, strict=True):
        frame = track.next_frame(time)
        if found < lowest.get(id(frame), (SAFE_MARGIN, frame))[0]:
            lowest[id(frame)] = (float(found), frame)
    for found, frame in lowest.values():
        yield frame.node.problem(
            f"{frame.name}: on the way the centre of mass comes to {1e3 * found:.1f} mm inside the "
            f"standing soles' edge, at least {1e3 * SAFE_MARGIN:.0f} mm are needed; move the hips "
            "over the standing foot, or lift less"
        )


def static_margin(robot: Robot, feet: FeetPoses) -> np.ndarray:
    """Distance of the centre of mass from the edge of the standing soles, in [m]. Shape (n,).

    Positive inside; of a robot that stands still on a level floor, on the sole that is lower and
    the other if it is as low.
    """
    n = len(feet.position)
    level = axis_rotation("y", feet.trunk_pitch)
    poses = robot.tree.poses(np.zeros((n, 3)), level, joint_commands(robot, feet))
    links = [robot.tree.index(name) for name in robot.feet]
    turned = robot.sole.corners() @ np.swapaxes(poses.rotation[:, links], 2, 3)
    corners = poses.position[:, links, None] + turned
    height = corners[..., 2].min(axis=2)
    standing = height < height.min(axis=1, keepdims=True) + LIFTED
    centre = robot.tree.centre_of_mass(poses)
    return support_margin(centre[:, :2], corners[..., :2], standing)
