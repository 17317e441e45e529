"""One trial as a film needs it: everything that a frame shows, at the instants of the frames."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.log.columns import FEET
from gaitlab.log.fall import CAUSES
from gaitlab.model import LinkPoses, Tree
from gaitlab.render.lawn import PressingSole
from gaitlab.render.robot import robot_faces
from gaitlab.simulation.trial import Trial
from gaitlab.surfaces.surface import Surface

FIRST = np.array([0])  # the tick at which the robot stands
CALM = 0.35  # s, over which the camera follows; about half a gait cycle hides the sway


@dataclass(frozen=True, kw_only=True, eq=False)
class Take:
    """A trial at the instants of n frames.

    Attributes:
        title: Robot and ground.
        caption: Gait, seed and trial.
        tree: Links of the robot.
        feet: Names of the left and the right foot link.
        surface: The ground.
        size: Height of the standing robot, in [m].
        weight: Of the robot, in [N].
        sole: Length and width of a sole, in [m].
        span: First and last instant of the log, on the clock of the walk, in [s].
        fall: When the fall was established, on that clock, in [s]; None without one.
        fall_cause: What established it; empty without one.
        lane: Extent of the ground that the film may show, edges along x and y, in [m].
        time: Clock of the walk at each frame; stands still past the ends of the log. Shape (n,).
        poses: Of the links. Shapes (n, links, ...).
        soles: Corners of both soles, in [m]. Shape (n, 2, 4, 3).
        centres: Of both soles, in [m]. Shape (n, 2, 3).
        forces: On both soles, in [N]. Shape (n, 2, 3).
        contact: Whether each sole carries load. Shape (n, 2).
        zmp: On the height of the loaded soles, in [m]; NaN in flight. Shape (n, 3).
        phase: Of the gait; NaN in the start-up. Shape (n,).
        focus: What the camera looks at: the CoM, calmed, in [m]. Shape (n, 2).
    """

    title: str
    caption: str
    tree: Tree
    feet: tuple[str, str]
    surface: Surface
    size: float
    weight: float
    sole: tuple[float, float]
    span: tuple[float, float]
    fall: float | None
    fall_cause: str
    lane: tuple[tuple[float, float], tuple[float, float]]
    time: np.ndarray
    poses: LinkPoses
    soles: np.ndarray
    centres: np.ndarray
    forces: np.ndarray
    contact: np.ndarray
    zmp: np.ndarray
    phase: np.ndarray
    focus: np.ndarray

    def footprints(self, frame: int) -> list[PressingSole]:
        """The soles at a frame."""
        links = [self.tree.index(foot) for foot in self.feet]
        return [
            PressingSole(
                centre=self.centres[frame, foot],
                rotation=self.poses.rotation[frame, link],
                size=self.sole,
            )
            for foot, link in enumerate(links)
        ]

    def fallen(self, frame: int) -> bool:
        """Whether the fall is established at a frame."""
        return self.fall is not None and bool(self.time[frame] >= self.fall - 1e-6)


class Recorded(NamedTuple):
    """A trial and what was recorded of it.

    Attributes:
        trial_id: What the store calls it.
        trial: The trial.
        log: Its log.
    """

    trial_id: str
    trial: Trial
    log: TrialLog


def span_of(log: TrialLog) -> tuple[float, float]:
    """First and last instant of a log, in [s] since walking at full amplitude began."""
    start = log.header.startup_time
    return float(log["time"][0]) - start, float(log["time"][-1]) - start


def take_of(shown: Recorded, instants: Sequence[float]) -> Take:
    """A trial at instants, in [s] since walking at full amplitude began.

    Before the log its first row shows, after it the last one.
    """
    trial, log = shown.trial, shown.log
    clock = log["time"] - log.header.startup_time
    ticks = np.minimum(np.searchsorted(clock, np.asarray(instants) - 1e-6), len(log) - 1)
    poses = _poses(trial.robot.tree, log, ticks)
    soles = _soles(trial, poses)
    com = log.vector("com_", "xy")
    fall = None if log.fall_index is None else float(clock[log.fall_index])
    contact = log.per_foot("contact")[ticks].astype(bool)
    return Take(
        title=f"{trial.names.robot.upper()} on {_spoken(trial.names.surface)}",
        caption=_caption(shown),
        tree=trial.robot.tree,
        feet=trial.robot.feet,
        surface=trial.surface,
        size=_size(trial.robot.tree, trial.robot.feet, _poses(trial.robot.tree, log, FIRST)),
        weight=log.header.weight,
        sole=(trial.robot.sole.length, trial.robot.sole.width),
        span=span_of(log),
        fall=fall,
        fall_cause=_cause(log),
        lane=_lane(log),
        time=clock[ticks],
        poses=poses,
        soles=soles,
        centres=np.stack([log.vector(f"{side}_foot_")[ticks] for side in FEET], axis=1),
        forces=_forces(log, ticks),
        contact=contact,
        zmp=_zmp(log, ticks, soles, contact),
        phase=log["gait_phase"][ticks],
        focus=gaussian_filter1d(com, CALM / log.header.dt, axis=0, mode="nearest")[ticks],
    )


def _poses(tree: Tree, log: TrialLog, ticks: np.ndarray) -> LinkPoses:
    rotation = rotation_of(log.vector("trunk_q", "xyzw")[ticks])
    return tree.poses(log.vector("trunk_")[ticks], rotation, _joints(tree, log)[ticks])


def _joints(tree: Tree, log: TrialLog) -> np.ndarray:
    """Positions of the tree's own joints; a log may have the pitch of a gantry besides."""
    return log.joint_table("position")[:, : len(tree.joints)]


def _soles(trial: Trial, poses: LinkPoses) -> np.ndarray:
    corners = []
    for side, name in enumerate(trial.robot.feet):
        link = trial.robot.tree.index(name)
        local = trial.robot.sole.corners(side)[[0, 1, 3, 2]]  # around the sole
        turned = local @ np.swapaxes(poses.rotation[:, link], 1, 2)
        corners.append(poses.position[:, link, None] + turned)
    return np.stack(corners, axis=1)


def _forces(log: TrialLog, ticks: np.ndarray) -> np.ndarray:
    names = ("force_x", "force_y", "normal_force")
    return np.stack([log.per_foot(name)[ticks] for name in names], axis=-1)


def _zmp(log: TrialLog, ticks: np.ndarray, soles: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """The ZMP with the mean height of the soles that carry load."""
    height = soles[..., 2].mean(axis=2)
    loaded = np.where(contact, height, 0.0).sum(axis=1) / np.maximum(contact.sum(axis=1), 1)
    return np.column_stack([log.vector("zmp_", "xy")[ticks], loaded])


def _size(tree: Tree, feet: tuple[str, str], poses: LinkPoses) -> float:
    """Height of the robot's highest corner above its lowest, in [m]."""
    corners = np.concatenate([f.corners.reshape(-1, 3) for f in robot_faces(tree, feet, poses)])
    return float(np.ptp(corners[:, 2]))


def _lane(log: TrialLog) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where the CoM and the feet have been, in [m]."""
    places = [log.vector(name, "xy") for name in ("com_", "left_foot_", "right_foot_")]
    low = np.min([place.min(axis=0) for place in places], axis=0)
    high = np.max([place.max(axis=0) for place in places], axis=0)
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def _spoken(surface: str) -> str:
    """A surface as a reader calls it: `grass_50mm` becomes `grass 50 mm`."""
    return re.sub(r"(\d)mm\b", r"\1 mm", Path(surface).stem.replace("_", " "))


def _cause(log: TrialLog) -> str:
    if log.fall_index is None:
        return ""
    return CAUSES[int(log["fall_cause"][log.fall_index])].replace("_", " ")


def _caption(shown: Recorded) -> str:
    header = shown.log.header
    return (
        f"step length {header.step_length:.3g} m, period {header.gait_period:.3g} s, "
        f"seed {shown.trial.seed}, trial {shown.trial_id[:8]}"
    )
