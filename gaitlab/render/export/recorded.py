"""What an export starts from: a trial, its log, and the pose of every link over time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gaitlab.kinematics.transforms import quaternion_of
from gaitlab.log import TrialLog
from gaitlab.model import LinkPoses
from gaitlab.render.scene import link_poses
from gaitlab.simulation.trial import Trial
from gaitlab.store.record import TrialRecord

NANOSECONDS = 1e9  # in a second


@dataclass(frozen=True, kw_only=True, eq=False)
class ExportedTrial:
    """A trial that ran.

    Attributes:
        record: What the store keeps of it.
        trial: The trial.
        log: Its log.
    """

    record: TrialRecord
    trial: Trial
    log: TrialLog

    @cached_property
    def nanoseconds(self) -> np.ndarray:
        """Time of each row without the rounding of the time column, in [ns]. Shape (n,)."""
        ticks = np.arange(1, len(self.log) + 1)
        return np.rint(ticks * self.log.header.dt * NANOSECONDS).astype(np.int64)

    @cached_property
    def poses(self) -> LinkPoses:
        """Pose of every link at every row."""
        return link_poses(self.trial.robot.tree, self.log)

    @cached_property
    def quaternions(self) -> np.ndarray:
        """Orientation of every link at every row, xyzw. Shape (n, links, 4)."""
        return quaternion_of(self.poses.rotation)

    @property
    def ground(self) -> tuple[list[float], list[float]]:
        """Centre and size of a box below all of the walk, as high as the surface, in [m]."""
        x, height = self.log["trunk_x"], max(self.trial.surface.height, 0.002)
        return [float(x.mean()), 0.0, 0.5 * height], [float(np.ptp(x)) + 2.0, 1.0, height]
