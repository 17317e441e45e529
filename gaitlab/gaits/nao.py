"""The NAO gait after Goswami: three points, the ankles and the hips, as sines of the step's time.

In each step of duration T the hips swing out over the standing foot and back, and the other foot
travels s from behind to ahead of it, [Shaari2015] eqs. (2.1) to (2.5). There is no double support:
the feet change roles in an instant, s/2 apart and with no speed along x and z.

The paper's s is twice our `step_length`, T half our `gait_period`, H `step_height`,
F `lateral_sway`, w `step_width`; its h counts down from straight legs, so that
`hip_height` = thigh + tibia + ankle height - h, 0.24809 m - h for NAO V4.

Corrections to the printed equations:
    (2.1), (2.4) time counts from the start of the step everywhere, tau = t - nT; as printed the
        second step runs backwards or, with its negative window, under ground.
    (2.1), (2.2) the swinging foot is on its own side: y is to the left.
    (2.4) y as printed peaks at 0.614 F a third into the step; `lateral_profile` has it and three
        forms that reach F in the middle.
    (2.5) T - t only tells the sides apart; here that is a sign.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

BEFORE_ONE = float(np.nextafter(1.0, 0.0))
ROUNDING = 1e-9  # share of a step; an instant this close to an exchange belongs to the next step


class Step(NamedTuple):
    """One step seen from the standing ankle and, across, from the line midway between the feet.

    Attributes:
        forward: X of the swinging ankle; the hips are half as far ahead, in [m]. Shape (n,).
        lift: Z of the swinging ankle, in [m]. Shape (n,).
        sway: Hips towards the standing foot, in [m]. Shape (n,).
    """

    forward: np.ndarray
    lift: np.ndarray
    sway: np.ndarray


def lateral_profile(kind: str, x: np.ndarray) -> np.ndarray:
    """Share f of the frontal shift at a share x of the step, [Shaari2015] eq. (2.4).

    `printed` is the equation as it stands; the others reach 1 in the middle: `sinsin` dwells
    there, `sin` is the gentlest, `foot` stops on the mid-line between steps.
    """
    if kind == "sinsin":
        return np.sin(pi / 2.0 * np.sin(pi * x))
    if kind == "sin":
        return np.sin(pi * x)
    if kind == "foot":
        return np.sin(pi / 2.0 * (np.sin(pi * (x - 0.5)) + 1.0))
    return np.sin(pi / 2.0 * (np.sin(pi * x / 2.0) + 1.0)) * np.sin(pi * x)


@dataclass(frozen=True, kw_only=True)
class Gait:
    """The corrected gait of [Shaari2015]; its setting is Table 6, the period is not published.

    It starts from standing with a half step of the left foot, which the paper leaves out.
    """

    step_length: float = parameter(
        0.05,
        unit="m",
        low=-0.1,
        high=0.1,
        doc="s/2, distance between the feet at the exchange",
        source="published: Table 6, s = 0.10 m",
    )
    step_height: float = parameter(
        0.028, unit="m", low=0.0, high=0.1, doc="H, apex of the swing foot", source="published"
    )
    lateral_sway: float = parameter(
        0.055,
        unit="m",
        low=0.0,
        high=0.15,
        doc="F, largest shift of the hips from the mid-line",
        source="published: Table 6",
    )
    hip_height: float = parameter(
        0.23009,
        unit="m",
        low=0.05,
        high=1.0,
        doc="hips over the soles, 0.24809 m - h",
        source="published: Table 6, h = 0.018 m, with the lengths of NAO V4",
    )
    gait_period: float = parameter(
        3.0,
        unit="s",
        low=0.2,
        high=20.0,
        doc="2 T, duration of two steps",
        source="assumption: not published; 2 s walks on hard floors, 3 s on 10 mm grass too",
    )
    step_width: float = parameter(
        0.1, unit="m", low=0.0, high=0.5, doc="w, between the ankles", source="published: Table 1"
    )
    lateral_profile: Literal["sinsin", "sin", "foot", "printed"] = parameter(
        "sinsin",
        unit="-",
        doc="how the hips shift: three corrected forms of eq. (2.4), or as printed",
        source="reconstruction: which form was used is unknown",
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )

    @property
    def startup_time(self) -> float:
        """Duration of standing and of the half step that starts the walk, in [s]."""
        return self.stand_time + 0.5 * self.gait_period

    def step(self, share: np.ndarray) -> Step:
        """A step at shares tau/T of its time, [Shaari2015] eqs. (2.1), (2.2), (2.4). Shape (n,)."""
        s = 2.0 * self.step_length
        return self._step(-0.5 * s * np.cos(pi * share), 0.5 * (1.0 - np.cos(pi * share)), share)

    def first_step(self, share: np.ndarray) -> Step:
        """The half step from standing, derived here: the foot travels s/2. Shape (n,)."""
        travelled = 0.5 * (1.0 - np.cos(pi * share))
        return self._step(self.step_length * travelled, travelled, share)

    def _step(self, forward: np.ndarray, travelled: np.ndarray, share: np.ndarray) -> Step:
        sway = self.lateral_sway * lateral_profile(self.lateral_profile, share)
        return Step(forward, self.step_height * np.sin(pi * travelled), sway)

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0. Shape (n,).

        Phase 0 is the lift of the right foot; even steps stand on the left one.
        """
        count = (np.asarray(t, dtype=float) - self.startup_time) / (0.5 * self.gait_period)
        index = np.floor(count + ROUNDING).astype(int)
        share = np.clip(count - index, 0.0, 1.0)
        n, walking, standing = len(count), index >= 0, index < -1
        steps = (self.first_step(share), self.step(share))
        parts = (np.where(walking, a, b) for b, a in zip(*steps, strict=True))
        step = Step(*(np.where(standing, 0.0, part) for part in parts))
        swing = np.stack([index % 2 == 1, index % 2 == 0], axis=-1) & ~standing[:, None]
        return FeetPoses(
            position=self._in_hip_frame(step, index % 2 == 0),
            heading=np.zeros((n, 2)),
            trunk_pitch=np.zeros(n),
            ankle_pitch=np.zeros((n, 2)),
            knee_only=np.zeros((n, 2)),
            swing=swing,
            phase=np.where(walking, 0.5 * (index % 2 + np.minimum(share, BEFORE_ONE)), np.nan),
            step_index=np.where(walking, index, -1),
        )

    def _in_hip_frame(self, step: Step, on_left: np.ndarray) -> np.ndarray:
        """Soles seen from the hips. Shape (n, 2, 3)."""
        side = np.where(on_left, 1.0, -1.0)
        half = np.full_like(side, 0.5 * self.step_width)
        ground = np.full_like(side, -self.hip_height)
        across = side * step.sway
        standing = np.stack([-0.5 * step.forward, side * half - across, ground], axis=-1)
        swinging = np.stack(
            [0.5 * step.forward, -side * half - across, ground + step.lift], axis=-1
        )
        left = np.where(on_left[:, None], standing, swinging)
        right = np.where(on_left[:, None], swinging, standing)
        return np.stack([left, right], axis=1)
