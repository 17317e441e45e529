"""A walk in any direction for any robot with two legs: ahead, sideways and round.

Derived here. The trunk goes ahead at 2 S / T, sideways at 2 Q / T and turns at 2 W / T, with T the
`gait_period`, S `step_length`, Q `side_step` and W `turn`. A stance foot stays where it is in the
world, so in the trunk's frame it moves by the inverse of the trunk's planar motion, the exponential
of a twist [LynchPark2017, section 3.2.3]. A swing foot follows the quintic through the place, speed
and acceleration with which stance ends and begins, so that targets are smooth up to the second
derivative. Its lift rises to the apex and falls from it by the quintic smoothstep. The trunk sways
to the stance side as a sine. Sway, lift and steps grow together by the same smoothstep.

What is not said of it is scaled to the robot: lengths with its legs, durations with the period of
a pendulum as long as its centre of mass is high, the sway with that of a linear inverted pendulum.

References:
    LynchPark2017: Lynch and Park, Modern Robotics, Cambridge University Press, 2017.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from math import pi
from typing import Any, NamedTuple

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.model import Robot
from gaitlab.model.gait import FeetPoses
from gaitlab.model.stance import EXTENSIONS, Stance, stance_of
from gaitlab.parameters import parameter

PERIOD = 0.45  # of the natural period
STEP_LENGTH, STEP_HEIGHT = 0.08, 0.05  # of the leg's length
SWAY = 1.0  # of a linear inverted pendulum's
LOOKED_AT = 64  # instants of a walk that has to be possible
_SCALED = "assumption: scaled to the robot; here for a leg of 0.4 m. A search finds its own"
_USUAL = "assumption: usual among kid-size robots; a search finds a robot's own"
_STRAIGHT = 1e-9  # rad/s; slower a trunk goes straight


class Planar(NamedTuple):
    """A foot in the trunk's frame: x and y in [m] and heading in [rad] along the last axis, with
    first and second derivative in time. Shape (n, 3) each.
    """

    place: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Phase 0 is the middle of double support, the right foot ahead; the left foot swings first."""

    step_length: float = parameter(
        0.04,
        unit="m",
        low=-1.0,
        high=1.0,
        doc="between the feet in double support; negative walks backwards",
        source=_SCALED,
    )
    side_step: float = parameter(
        0.0, unit="m", low=-0.5, high=0.5, doc="to the left in a step", source=_USUAL
    )
    turn: float = parameter(
        0.0, unit="rad", low=-1.0, high=1.0, doc="to the left in a step", source=_USUAL
    )
    gait_period: float = parameter(
        0.75, unit="s", low=0.1, high=10.0, doc="a full cycle of two steps", source=_SCALED
    )
    double_support_ratio: float = parameter(
        0.3, unit="-", low=0.0, high=0.9, doc="share of the period on both feet", source=_USUAL
    )
    step_height: float = parameter(
        0.03, unit="m", low=0.0, high=0.5, doc="apex of the swing foot", source=_SCALED
    )
    apex_phase: float = parameter(
        0.5, unit="-", low=0.2, high=0.8, doc="share of the swing before the apex", source=_USUAL
    )
    step_width: float = parameter(
        0.1, unit="m", low=0.0, high=1.0, doc="between the feet", source=_SCALED
    )
    hip_height: float = parameter(
        0.3, unit="m", low=0.05, high=2.0, doc="hips over the soles", source=_SCALED
    )
    com_offset: float = parameter(
        0.0, unit="m", low=-0.3, high=0.3, doc="hips ahead of the ankles", source=_SCALED
    )
    trunk_pitch: float = parameter(
        0.0, unit="rad", low=-0.5, high=0.6, doc="lean about the hips", source=_USUAL
    )
    lateral_sway: float = parameter(
        0.02, unit="m", low=0.0, high=0.3, doc="of the trunk to either side", source=_SCALED
    )
    sway_phase: float = parameter(
        0.0, unit="-", low=-0.25, high=0.25, doc="cycles by which the sway is late", source=_USUAL
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )
    startup_cycles: int = parameter(
        2, unit="-", low=1, high=10, doc="in which the walk grows", source="assumption"
    )

    @classmethod
    def suited_to(cls, robot: Robot) -> dict[str, Any]:
        """The parameters that a robot's size decides, as far as nobody sets them.

        Raises:
            Infeasible: If such a walk is beyond the robot's joints however it bends its knees.
        """
        problems = []
        for sway, extension in product((SWAY, 0.0), EXTENSIONS):  # some legs do not go sideways
            try:
                suited = cls._scaled(stance_of(robot, extension), sway)
                made = replace(cls(), **suited)
                end = made.startup_time + made.gait_period
                robot.joint_targets(made.feet(np.linspace(0.0, end, LOOKED_AT)))
            except Infeasible as problem:
                problems.append(problem)
            else:
                return suited
        raise problems[0]

    @staticmethod
    def _scaled(stance: Stance, sway: float) -> dict[str, Any]:
        period = PERIOD * stance.natural_period
        return {
            "step_length": STEP_LENGTH * stance.leg_length,
            "gait_period": period,
            "step_height": STEP_HEIGHT * stance.leg_length,
            "step_width": stance.step_width,
            "hip_height": stance.hip_height,
            "com_offset": stance.com_offset,
            "lateral_sway": sway * stance.sway(period),
        }

    @property
    def startup_time(self) -> float:
        """Duration of standing and of growing steps, in [s]."""
        return self.stand_time + self.startup_cycles * self.gait_period

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0. Shape (n,)."""
        cycles = (np.asarray(t, dtype=float) - self.stand_time) / self.gait_period
        grown = _smoothstep(np.clip(cycles / self.startup_cycles, 0.0, 1.0))
        phase = cycles % 1.0
        sway = -self.lateral_sway * np.sin(2.0 * pi * (phase - self.sway_phase))
        position, heading = np.empty((len(phase), 2, 3)), np.empty((len(phase), 2))
        swing = np.empty((len(phase), 2), dtype=bool)
        for foot, (half, side) in enumerate([(0.0, 0.5), (0.5, -0.5)]):
            stand = np.array([0.0, side * self.step_width, 0.0])
            place, lift, swing[:, foot] = self._foot((phase + half) % 1.0, stand)
            moved = stand + grown[:, None] * (place - stand)
            position[:, foot, 0] = moved[:, 0] - self.com_offset
            position[:, foot, 1] = moved[:, 1] - grown * sway
            position[:, foot, 2] = grown * lift - self.hip_height
            heading[:, foot] = moved[:, 2]
        walking = cycles >= self.startup_cycles
        level = np.zeros((len(phase), 2))
        return FeetPoses(
            position=position,
            heading=heading,
            trunk_pitch=np.full(len(phase), self.trunk_pitch),
            ankle_pitch=level,
            knee_only=level,
            swing=swing & (cycles > 0.0)[:, None],
            phase=np.where(walking, phase, np.nan),
            step_index=np.where(walking, np.floor(2.0 * (cycles - self.startup_cycles)), -1).astype(
                int
            ),
        )

    def _foot(
        self, phase: np.ndarray, stand: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place of a foot that swings about phase 1/4, its lift, and whether it swings."""
        both, period = self.double_support_ratio, self.gait_period
        begin, duration = both / 4.0, (1.0 - both) / 2.0
        since = (phase - begin) % 1.0
        swinging = since < duration
        middle = begin + duration + (1.0 - duration) / 2.0  # of stance
        late = np.where(swinging, 0.0, (phase - middle + 0.5) % 1.0 - 0.5) * period
        reach = np.array([0.5, -0.5]) * (1.0 - duration) * period  # end and begin of stance
        ends = self._stance(reach, stand)
        share = np.clip(since / duration, 0.0, 1.0)
        swung = _quintic(ends, share, duration * period)
        place = np.where(swinging[:, None], swung, self._stance(late, stand).place)
        up = np.minimum(share / self.apex_phase, (1.0 - share) / (1.0 - self.apex_phase))
        return place, np.where(swinging, self.step_height * _smoothstep(up), 0.0), swinging

    def _stance(self, late: np.ndarray, stand: np.ndarray) -> Planar:
        """A foot that stays in the world, times in [s] after it passed its place of standing."""
        ahead, aside, round_ = (
            2.0 * part / self.gait_period for part in (self.step_length, self.side_step, self.turn)
        )
        angle = round_ * late
        if abs(round_) > _STRAIGHT:
            sine, versine = np.sin(angle) / round_, (1.0 - np.cos(angle)) / round_
        else:
            sine, versine = late, 0.5 * round_ * late**2
        gone = np.stack([sine * ahead - versine * aside, versine * ahead + sine * aside], axis=-1)
        c, s = np.cos(angle), np.sin(angle)
        x, y = np.moveaxis(stand[:2] - gone, -1, 0)
        at = np.stack([c * x + s * y, c * y - s * x], axis=-1)
        speed = np.stack([-ahead + round_ * at[..., 1], -aside - round_ * at[..., 0]], axis=-1)
        bend = np.stack([round_ * speed[..., 1], -round_ * speed[..., 0]], axis=-1)
        flat = np.zeros_like(angle)
        return Planar(
            np.concatenate([at, -angle[..., None]], axis=-1),
            np.concatenate([speed, (flat - round_)[..., None]], axis=-1),
            np.concatenate([bend, flat[..., None]], axis=-1),
        )


def _smoothstep(share: np.ndarray) -> np.ndarray:
    """From 0 to 1 with neither speed nor acceleration at the ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _quintic(ends: Planar, share: np.ndarray, duration: float) -> np.ndarray:
    """Place between two ends at shares of a duration in [s], smooth at both. Shape (n, 3)."""
    (p0, p1), (v0, v1), (a0, a1) = ends
    v0, v1, a0, a1 = duration * v0, duration * v1, duration**2 * a0, duration**2 * a1
    gap = p1 - p0
    s = share[:, None]
    third = 10.0 * gap - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    fourth = -15.0 * gap + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    fifth = 6.0 * gap - 3.0 * (v0 + v1) - 0.5 * (a0 - a1)
    return p0 + s * (v0 + s * (0.5 * a0 + s * (third + s * (fourth + s * fifth))))
