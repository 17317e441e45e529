"""A motion over time: cubic between keyframes, at rest in their pauses, from the last to the first.

Each joint and foot coordinate goes p = p0 + (3 s^2 - 2 s^3)(p1 - p0) with s from 0 to 1, so it
leaves and arrives at rest and is fastest half-way, at 1.5 times its mean speed (derived here).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gaitlab.motions.motion import Keyframe, Motion

ROUNDING = 1e-9  # s


class Pose(NamedTuple):
    """Where a motion is at n instants.

    Attributes:
        joints: Angles in the order of the motion's joints, in [rad]. Shape (n, joints).
        feet: Points of level soles in the hip frame, left and right, in [m]. Shape (n, 2, 3).
        trunk_pitch: Forward lean, in [rad]. Shape (n,).
    """

    joints: np.ndarray
    feet: np.ndarray
    trunk_pitch: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Track:
    """A motion as a function of time, repeated for ever."""

    motion: Motion

    @property
    def duration(self) -> float:
        """Time from the first frame back to it, in [s]."""
        return float(self._arrivals[-1])

    @cached_property
    def moves(self) -> tuple[tuple[Keyframe, Keyframe, float], ...]:
        """Every move: the frame that is left, the frame that is reached, and the time in [s]."""
        frames = self.motion.frames
        to = (*frames[1:], frames[0])
        tempo = self.motion.tempo
        return tuple((a, b, b.move_time / tempo) for a, b in zip(frames, to, strict=True))

    def at(self, t: np.ndarray) -> Pose:
        """Where the motion is at the instants t >= 0, in [s]; it starts resting in the first frame.

        Args:
            t: Instants. Shape (n,).
        """
        time, index = self._moves_at(t)
        move = np.array([duration for *_, duration in self.moves])[index]
        share = np.clip(1.0 - (self._arrivals[index] - time) / move, 0.0, 1.0)
        share = (share**2 * (3.0 - 2.0 * share))[:, None]
        rows = self._rows
        row = (1.0 - share) * rows[index] + share * rows[(index + 1) % len(rows)]
        joints = len(self.motion.joints)
        return Pose(row[:, :joints], row[:, joints:-1].reshape(-1, 2, 3), row[:, -1])

    def next_frame(self, t: float) -> Keyframe:
        """The keyframe that is moved to, or will be after a pause, at an instant in [s]."""
        _, index = self._moves_at(np.array([t]))
        return self.moves[int(index[0])][1]

    def _moves_at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Time within the motion in [s], and the move that is under way or comes next."""
        time = np.mod(np.asarray(t, dtype=float) + ROUNDING, self.duration)
        return time, np.searchsorted(self._arrivals[:-1], time, side="right")

    @cached_property
    def _arrivals(self) -> np.ndarray:
        """Time at which each move ends; the first starts after the first frame's pause."""
        pauses = np.array([frame.pause_time for frame in self.motion.frames]) / self.motion.tempo
        return np.cumsum(pauses + [duration for *_, duration in self.moves])

    @cached_property
    def _rows(self) -> np.ndarray:
        """Joints, both feet and the lean of every frame. Shape (frames, joints + 7)."""
        names = self.motion.joints
        return np.array(
            [
                [*(f.joints[name] for name in names), *f.feet[0], *f.feet[1], f.trunk_pitch]
                for f in self.motion.frames
            ]
        )
