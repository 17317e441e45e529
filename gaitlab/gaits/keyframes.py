"""Plays a motion file: keyframes of joints and feet, checked against the robot beforehand.

The robot stands in the first keyframe for `stand_time`, then the motion repeats. One repetition is
the gait's period; it goes nowhere by intent, so its step length is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.model import Robot
from gaitlab.model.gait import FeetPoses
from gaitlab.model.servo import Servo
from gaitlab.motions import Motion, Track, load_motion, require_playable
from gaitlab.motions.fitting import feet_poses
from gaitlab.parameters import parameter

ROUNDING = 1e-9  # share of a control period


@dataclass(frozen=True, kw_only=True)
class Gait:
    """A motion, its tempo and its mirror image.

    `digest` is filled in: it ties results to the numbers of the motion file, so that an edited
    file is another gait.
    """

    motion: str = parameter(unit="file", doc="name of a motion, or a .yaml file", source="-")
    tempo: float = parameter(
        1.0, unit="-", low=0.1, high=10.0, doc="times the tempo of the file", source="assumption"
    )
    mirror: bool = parameter(
        False, unit="-", doc="exchange left and right throughout", source="assumption"
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.0, high=10.0, doc="standing before it begins", source="assumption"
    )
    control_period: float = parameter(
        0.008,
        unit="s",
        low=0.001,
        high=0.1,
        doc="between two targets",
        source="assumption: step of the RoboPlus motion player",
    )
    digest: str = parameter("", unit="-", doc="of the motion's numbers; filled in", source="-")

    def __post_init__(self) -> None:
        object.__setattr__(self, "digest", self._checked_digest(self._file))

    def _checked_digest(self, found: Motion) -> str:
        """`motion:SHA-256`; what another motion has left behind is replaced.

        Raises:
            WrongValue: If this motion was other when the trial was planned.
        """
        digest = f"{self.motion}:{found.digest}"
        if self.digest.startswith(f"{self.motion}:") and self.digest != digest:
            raise WrongValue(
                f"{found.file} has changed since the trial was planned; plan the experiment again"
            )
        return digest

    @cached_property
    def _file(self) -> Motion:
        return load_motion(self.motion)

    @cached_property
    def track(self) -> Track:
        """The motion over time, at its tempo and on its side."""
        played = self._file.mirrored() if self.mirror else self._file
        return Track(motion=played.faster(self.tempo))

    @property
    def step_length(self) -> float:
        """A motion is not told to travel, in [m]."""
        return 0.0

    @property
    def hip_height(self) -> float:
        """Height of the hip axes over the lower sole in the first keyframe, in [m]."""
        return -min(z for *_, z in self.track.motion.frames[0].feet)

    @property
    def gait_period(self) -> float:
        """One repetition, in [s]."""
        return self.track.duration

    @property
    def startup_time(self) -> float:
        """Standing in the first keyframe, in [s]."""
        return self.stand_time

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Feet and joints at the instants t, in [s], t >= 0; targets are held. Shape (n,)."""
        tick = np.floor(np.asarray(t) / self.control_period + ROUNDING)
        played = tick * self.control_period - self.stand_time
        track = self.track
        poses = feet_poses(track.motion, track.at(np.maximum(played, 0.0)))
        count, place = np.divmod(played, track.duration)
        walking = played >= 0.0
        return replace(
            poses,
            phase=np.where(walking, place / track.duration, np.nan),
            step_index=np.where(walking, 2 * count, -1).astype(int),
        )

    def require_playable(self, robot: Robot, servos: Sequence[Servo]) -> None:
        """Refuse a robot that cannot play it.

        Raises:
            FileError: Unknown joints, limits, reach, speeds and balance, at their places.
        """
        require_playable(self.track.motion, robot, servos)
