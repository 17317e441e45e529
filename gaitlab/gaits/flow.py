"""A sinusoidal walk for FLoW, on any robot with legs.

[Yanto] gives the kinematics of a walking robot and no walk; this one is an assumption, made of
sines so that every target is smooth. Derived here: the trunk goes ahead at the speed v = 2 S / T
and sways as sin(2 pi phase); a stance foot stays where it is; a swing foot goes ahead as
a (2 s - 1) - S sin(2 pi s) / pi and up as H (1 - cos(2 pi s)) / 2, with s from 0 to 1 over the
swing and a = S (1 + D) / 2, which joins stance with equal speed and without a jump of
acceleration ahead. T is `gait_period`, S `step_length`, H `step_height`, D `double_support_ratio`.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

RAMP = 1.0  # cycles in which sway and lift grow in place, then the steps
_TRIED = "assumption: found by trying on a hard floor and the carpet"


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Phase 0 is the middle of double support, the left foot ahead; the right foot swings first."""

    step_length: float = parameter(
        0.06,
        unit="m",
        low=-0.5,
        high=0.5,
        doc="between the feet in double support; negative walks backwards",
        source=_TRIED,
    )
    step_height: float = parameter(
        0.04, unit="m", low=0.0, high=0.3, doc="apex of the swing foot", source=_TRIED
    )
    lateral_sway: float = parameter(
        0.025,
        unit="m",
        low=0.0,
        high=0.2,
        doc="amplitude of the trunk's lateral motion",
        source=_TRIED,
    )
    hip_height: float = parameter(
        0.487, unit="m", low=0.05, high=1.5, doc="hips over the soles", source=_TRIED
    )
    step_width: float = parameter(
        0.17, unit="m", low=0.0, high=0.8, doc="between the feet", source="assumption: as the hips"
    )
    com_offset: float = parameter(
        0.015, unit="m", low=-0.2, high=0.2, doc="hips ahead of the ankles", source=_TRIED
    )
    gait_period: float = parameter(
        0.75, unit="s", low=0.2, high=10.0, doc="a full cycle of two steps", source=_TRIED
    )
    double_support_ratio: float = parameter(
        0.38,
        unit="-",
        low=0.0,
        high=0.9,
        doc="fraction of the cycle with both feet down",
        source=_TRIED,
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )

    @property
    def startup_time(self) -> float:
        """Duration of standing, of a cycle in place and of one with growing steps, in [s]."""
        return self.stand_time + 2.0 * RAMP * self.gait_period

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0. Shape (n,)."""
        cycles = (np.asarray(t, dtype=float) - self.stand_time) / self.gait_period
        sway, step = (np.clip(cycles / RAMP - k, 0.0, 1.0) for k in (0, 1))
        phase = cycles % 1.0
        ahead, lift, swinging = zip(*(self._foot(phase + half) for half in (0.5, 0.0)), strict=True)
        forward = step * self.step_length * np.array(ahead)
        across = -sway * self.lateral_sway * np.sin(2.0 * pi * phase)
        position = np.empty((len(cycles), 2, 3))
        position[..., 0] = forward.T - self.com_offset
        position[..., 1] = across[:, None] + np.array([0.5, -0.5]) * self.step_width
        position[..., 2] = (sway * self.step_height * np.array(lift)).T - self.hip_height
        walking = cycles >= 2.0 * RAMP
        level = np.zeros((len(cycles), 2))
        return FeetPoses(
            position=position,
            heading=level,
            trunk_pitch=np.zeros(len(cycles)),
            ankle_pitch=level,
            knee_only=level,
            swing=np.array(swinging).T & (cycles > 0.0)[:, None],
            phase=np.where(walking, phase, np.nan),
            step_index=np.where(walking, np.floor(2.0 * (cycles - 2.0 * RAMP)), -1).astype(int),
        )

    def _foot(self, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place ahead of the hips as a share of the step, lift as one of H, whether it swings.

        The foot swings from phase D / 4 to (2 - D) / 4. Shape (n,) each.
        """
        both = self.double_support_ratio
        since = (phase - both / 4.0) % 1.0
        duration = (1.0 - both) / 2.0
        s = np.clip(since / duration, 0.0, 1.0)
        swinging = since < duration
        reach = (1.0 + both) / 2.0
        swing = reach * (2.0 * s - 1.0) - np.sin(2.0 * pi * s) / pi
        stance = reach - 2.0 * (since - duration)
        ahead = np.where(swinging, swing, stance)
        return ahead, (1.0 - np.cos(2.0 * pi * s)) / 2.0, swinging
