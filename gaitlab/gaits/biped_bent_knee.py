"""Walking on bent knees at a constant hip height: what straight legs are compared with.

The hips travel at a constant speed, from half a step behind the supporting foot to half a step
ahead of it; the swing foot covers two steps on a cycloid. Inverse kinematics needs the knees bent
because a straight leg is singular. The same words as the straight-legged gait: t_f is a quarter of
`gait_period`, and equal parameters give equal speed and footholds. Derived here as the usual
alternative; [Siswoyo2008] names it without giving one.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

ROUNDING = 1e-9  # of a stride


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Bent-knee walking; the left leg supports in the first stride, and steps grow over a cycle."""

    step_length: float = parameter(
        0.20,
        unit="m",
        low=-1.0,
        high=1.0,
        doc="S, advance of the hips in a stride",
        source="assumption: as the straight-legged gait",
    )
    step_height: float = parameter(
        0.05, unit="m", low=0.0, high=0.5, doc="h, apex of the swing foot", source="assumption"
    )
    hip_height: float = parameter(
        0.59,
        unit="m",
        low=0.05,
        high=2.0,
        doc="hips over the soles",
        source="assumption: legs of 0.6 m at 0.90 of their length, ankles 0.05 m high",
    )
    gait_period: float = parameter(
        4.0, unit="s", low=0.2, high=60.0, doc="4 t_f, two strides", source="assumption"
    )
    step_width: float = parameter(
        0.12, unit="m", low=0.0, high=0.5, doc="between the robot's feet", source="assumption"
    )
    stand_time: float = parameter(
        0.5, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )

    @property
    def startup_time(self) -> float:
        """Standing and a cycle of growing steps, in [s]."""
        return self.stand_time + self.gait_period

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0. Shape (n,)."""
        cycles = (np.asarray(t, dtype=float) - self.stand_time) / self.gait_period
        strides = 2.0 * np.maximum(cycles, 0.0) + ROUNDING
        number = np.floor(strides).astype(int)
        right_swings = number % 2 == 0
        growth = 0.5 * (1.0 - np.cos(pi * np.clip(cycles, 0.0, 1.0)))[:, None]
        support, swing = self._foot_paths(strides - number)
        pair = np.stack([support, swing], axis=1)
        pair = np.where(right_swings[:, None, None], pair, pair[:, ::-1])
        n, walking = len(cycles), cycles >= 1.0 - ROUNDING
        position = np.empty((n, 2, 3))
        position[..., 0] = growth * pair[..., 0]
        position[..., 1] = np.array([0.5, -0.5]) * self.step_width
        position[..., 2] = growth * pair[..., 1] - self.hip_height
        return FeetPoses(
            position=position,
            heading=np.zeros((n, 2)),
            trunk_pitch=np.zeros(n),
            ankle_pitch=np.zeros((n, 2)),
            knee_only=np.zeros((n, 2)),
            swing=(cycles >= 0.0)[:, None] & np.stack([~right_swings, right_swings], axis=1),
            phase=np.where(walking, np.mod(cycles, 1.0), np.nan),
            step_index=np.where(walking, number - 2, -1),
        )

    def _foot_paths(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forward and upward place of the supporting and of the swinging foot seen from the hips.

        Args:
            share: Share of the stride, in [0, 1). Shape (n,).

        Returns:
            Two arrays, heights over the ground, in [m]. Shape (n, 2).
        """
        hips, turn = self.step_length * (share - 0.5), 2.0 * pi * share
        ahead = self.step_length * (2.0 * (share - np.sin(turn) / (2.0 * pi)) - 1.0)
        lift = 0.5 * self.step_height * (1.0 - np.cos(turn))
        support = np.stack([-hips, np.zeros_like(hips)], axis=-1)
        return support, np.stack([ahead - hips, lift], axis=-1)
