"""The EROS gait: four quarter-steps a cycle, heel strike, landing deceleration.

An angle T runs from 0 to pi/2 in each quarter-step and draws both feet from one point of a table to
the next, [Pristovani2018] eqs. (36) to (43). Step 1 lands the left foot, 2 lifts the right,
3 lands the right, 4 lifts the left (the paper's right leg, at its +y, is the left leg here).
The paper's X is `step_length`, Y `lateral_sway`, Z `step_height`, T_mn `tick_increment`,
C_H `heel_gain`, n `deceleration_areas`, C_DC `deceleration_gain`.

Corrections to the printed equations: in (39) and (43) the 90 degrees belong inside the sine, so a
landing's y and z follow 1 - sin(T + pi/2) = 1 - cos(T); (47) takes the primed height difference.
Reconstructions: the table of points, the start-up, and the equation of T_mn,DC(n), which is lost.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, radians
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

QUARTER = pi / 2.0
ROUNDING = 1e-9  # rad, and share of a control period; absorbs sums of increments
BLEND = pi / 6.0  # rad of swing over which a heel angle comes or goes, a reconstruction

# Shares of step_length, lateral_sway and step_height between quarter-steps; left, right foot.
_POINTS = np.array(
    [
        [(0.0, 1.0, 1.0), (0.0, 1.0, 0.0)],
        [(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)],
        [(0.0, -1.0, 0.0), (0.0, -1.0, 1.0)],
        [(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)],
        [(0.0, 1.0, 1.0), (0.0, 1.0, 0.0)],
    ]
)
_MOVING = (0, 1, 1, 0)  # foot that moves in each quarter-step: left, right, right, left
_WALKING_ORDER = (1, 2, 3, 0)  # quarter-steps as walked: from double support, right foot first


class Cycle(NamedTuple):
    """One cycle of n control ticks, from the lift of the right foot on.

    Attributes:
        shares: Of step_length, lateral_sway and step_height; left, right. Shape (n, 2, 3).
        moving: Which foot lifts or lands. Shape (n, 2).
        swing_angle: 0 at lift-off, pi/2 at the apex, pi at touchdown, in [rad]. Shape (n,).
    """

    shares: np.ndarray
    moving: np.ndarray
    swing_angle: np.ndarray


def deceleration_increments(kind: str, increment: float, areas: int, gain: float) -> np.ndarray:
    """Increment of T in each area of a landing, in [rad]. Shape (areas,).

    Reconstruction of the lost equation of T_mn,DC(n), from the symbols that [Pristovani2018]
    lists beside eq. (48): full speed in the first area, (1 - gain) of it in the last.
    `log_tail` T_mn (1 - C (1 - ln(n - k + 1) / ln n)) drops late and keeps more speed than
    `linear`; `log_front` T_mn (1 - C ln k / ln n) drops early.
    """
    k = np.arange(1, areas + 1)
    drop = {
        "none": np.zeros(areas),
        "log_tail": 1.0 - np.log(areas - k + 1) / np.log(areas),
        "log_front": np.log(k) / np.log(areas),
        "linear": (k - 1) / (areas - 1),
    }[kind]
    return increment * (1.0 - gain * drop)


def heel_pitch(difference: np.ndarray, heel_gain: float, limit: float) -> np.ndarray:
    """Ankle pitch of heel strike, in [rad], [Pristovani2018] eqs. (44) to (47); toe up is negative.

    `difference` is the moving sole's height over the other, in [m], `heel_gain` C_H, in [m/rad],
    `limit` the largest toe-up angle, in [rad].
    """
    return -np.minimum(difference / heel_gain, limit)


@dataclass(frozen=True, kw_only=True)
class Gait:
    """The gait of [Pristovani2018] Figs. 18 and 19, with each of its optimisations on a switch.

    `hip_height` is the spread R of the leg, hip to ankle, plus the ankle's height over the sole.
    The printed Z of 90 to 100 mm, if it is the apex H, asks for more speed than the servos have.
    `match_period_of_deceleration` is the control that tells slower from decelerated: it walks
    without deceleration, T evenly slowed so that the period is the decelerated one.
    """

    step_length: float = parameter(
        0.04,
        unit="m",
        low=-0.3,
        high=0.3,
        doc="X, advance of the trunk in a step and distance between the feet in double support",
        source="published: 8, 16 and 24 mm, and 0 to 24 of unclear unit in the tables",
    )
    step_height: float = parameter(
        0.03, unit="m", low=0.0, high=0.2, doc="H, apex of the swing foot", source="assumption"
    )
    lateral_sway: float = parameter(
        0.015,
        unit="m",
        low=0.0,
        high=0.1,
        doc="Y, amplitude of the trunk's lateral motion",
        source="assumption: the published 25, 35 and 45 mm belong to an unknown rhythm",
    )
    hip_height: float = parameter(
        0.225,
        unit="m",
        low=0.05,
        high=1.0,
        doc="hips over the soles",
        source="assumption: bent knees",
    )
    step_width: float = parameter(
        0.084, unit="m", low=0.0, high=0.5, doc="between the feet", source="assumption: as the hips"
    )
    com_offset: float = parameter(
        0.0, unit="m", low=-0.1, high=0.1, doc="hips ahead of the ankles", source="assumption"
    )
    trunk_pitch: float = parameter(
        0.0, unit="rad", low=-0.5, high=0.5, doc="lean about the hips", source="assumption"
    )
    tick_increment: float = parameter(
        radians(6.0),
        unit="rad",
        low=0.002,
        high=0.5,
        doc="T_mn, increment of T in a control period; larger walks faster",
        source="assumption: not published, 5 to 7 degrees walk on a hard floor",
    )
    control_period: float = parameter(
        0.01, unit="s", low=0.001, high=0.1, doc="between two targets", source="assumption"
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )
    x_law: Literal["printed", "quarter"] = parameter(
        "printed",
        unit="-",
        doc="forward share of a landing: 1 - cos(T) as printed, or sin(T), a quarter ellipse",
        source="published: eqs. (37) and (41); quarter is what the text describes",
    )
    heel_strike: Literal["none", "add", "literal"] = parameter(
        "none",
        unit="-",
        doc="toe-up ankle: none, added to the level ankle, or on the knee's angle as published",
        source="published: eqs. (46) and (47); add is a reconstruction",
    )
    heel_gain: float = parameter(
        0.2865, unit="m/rad", low=0.02, high=5.0, doc="C_H, lift per toe-up", source="assumption"
    )
    push_off_sign: Literal[-1, 0, 1] = parameter(
        1,
        unit="-",
        doc="heel strike while lifting: 1 toe up as printed, -1 toe down as people do, 0 level",
        source="published: eqs. (46) and (47) carry one sign; -1 and 0 are reconstructions",
    )
    toe_up_limit: float = parameter(
        radians(20.0), unit="rad", low=0.0, high=0.7, doc="largest toe-up", source="assumption"
    )
    landing_deceleration: Literal["none", "log_tail", "log_front", "linear"] = parameter(
        "none", unit="-", doc="how T slows in a landing", source="reconstruction: equation lost"
    )
    deceleration_areas: int = parameter(
        5, unit="-", low=2, high=100, doc="n, areas of a landing", source="assumption: try 3 to 10"
    )
    deceleration_gain: float = parameter(
        0.7, unit="-", low=0.0, high=0.95, doc="C_DC, share lost at last", source="assumption"
    )
    match_period_of_deceleration: bool = parameter(
        False, unit="-", doc="slow T evenly to the same period", source="reconstruction"
    )

    @property
    def gait_period(self) -> float:
        """Duration of a full cycle of two steps, deceleration included, in [s]."""
        return len(self.cycle.moving) * self.control_period

    @property
    def startup_time(self) -> float:
        """Duration of standing, of a cycle in place and of one with growing steps, in [s]."""
        return (self._stand_ticks + 2 * len(self.cycle.moving)) * self.control_period

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses at the instants t, in [s], t >= 0; targets are held. Shape (n,).

        In the start-up sway and height grow over one cycle in place, then the steps over another;
        phase 0 is the lift of the right foot.
        """
        tick = np.floor(np.asarray(t) / self.control_period + ROUNDING).astype(int)
        tick = tick - self._stand_ticks
        count, place = np.divmod(tick, len(self.cycle.moving))
        cycle = Cycle(*(part[place] for part in self.cycle))
        sway, step = (np.clip((tick + 1) / len(self.cycle.moving) - k, 0.0, 1.0) for k in (0, 1))
        full = [self.step_length, self.lateral_sway, self.step_height]
        offset = cycle.shares * (np.stack([step, sway, sway], axis=-1) * full)[:, None]
        swing = cycle.moving & ((tick >= 0) & (cycle.swing_angle < pi - ROUNDING))[:, None]
        ankle_pitch, knee_only = self._heel(offset[..., 2], swing, cycle.swing_angle, sway)
        half, walking = len(self._angles[0]) + len(self._angles[1]), count >= 2
        return FeetPoses(
            position=self._in_hip_frame(offset),
            heading=np.zeros((len(tick), 2)),
            trunk_pitch=np.full(len(tick), self.trunk_pitch),
            ankle_pitch=ankle_pitch,
            knee_only=knee_only,
            swing=swing,
            phase=np.where(walking, place / len(self.cycle.moving), np.nan),
            step_index=np.where(walking, 2 * (count - 2) + (place >= half), -1),
        )

    def _in_hip_frame(self, offset: np.ndarray) -> np.ndarray:
        """Sole positions of a level trunk, turned about the hips against its lean."""
        across = np.array([[0.5], [-0.5]]) * [0.0, self.step_width, 0.0]
        stand = across - [self.com_offset, 0.0, self.hip_height]
        lean = axis_rotation("y", np.array(-self.trunk_pitch))
        return np.einsum("ij,nfj->nfi", lean, stand + offset)

    def _heel(
        self, height: np.ndarray, swing: np.ndarray, swing_angle: np.ndarray, sway: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Ankle pitch and knee share of heel strike; blends at lift, apex and touch are ours."""
        if self.heel_strike == "none":
            return np.zeros(swing.shape), np.zeros(swing.shape)
        landing = np.clip((swing_angle - QUARTER) / BLEND, 0.0, 1.0)
        sign = self.push_off_sign + (1 - self.push_off_sign) * landing
        difference = height - height[:, ::-1]
        pitch = sign[:, None] * heel_pitch(difference, self.heel_gain, self.toe_up_limit)
        airborne = np.clip(np.minimum(swing_angle, pi - swing_angle) / BLEND, 0.0, 1.0)
        literal = self.heel_strike == "literal"
        share = literal * sway * airborne * np.maximum(landing, self.push_off_sign)
        return np.where(swing, pitch, 0.0), np.where(swing, share[:, None], 0.0)

    @property
    def _stand_ticks(self) -> int:
        return round(self.stand_time / self.control_period)

    @cached_property
    def cycle(self) -> Cycle:
        """The cycle at full amplitude; tick k is sent k control periods after the lift."""
        quarters = [self._quarter(step) for step in _WALKING_ORDER]
        return Cycle(*(np.concatenate(parts) for parts in zip(*quarters, strict=True)))

    def _quarter(self, step: int) -> Cycle:
        """Quarter-step from the table's point `step` to the next, eqs. (36) to (43)."""
        landing = step % 2 == 0
        angle = self._angles[landing]
        covered, rising = 1.0 - np.cos(angle), np.sin(angle)
        forward = rising if landing and self.x_law == "quarter" else covered
        other = covered if landing else rising
        share = np.stack([forward, other, other], axis=-1)[:, None]
        return Cycle(
            _POINTS[step] + share * (_POINTS[step + 1] - _POINTS[step]),
            np.tile(np.arange(2) == _MOVING[step], (len(angle), 1)),
            angle + QUARTER if landing else angle,
        )

    @cached_property
    def _angles(self) -> tuple[np.ndarray, np.ndarray]:
        """T at each tick of a lift and of a landing, in [rad]; both end at pi/2."""
        areas, gain = self.deceleration_areas, self.deceleration_gain
        law, increment = self.landing_deceleration, self.tick_increment
        increments = deceleration_increments(law, increment, areas, gain)
        lift = quarter_angles(increments[:1], self.x_law)
        landing = quarter_angles(increments, self.x_law)
        ticks = len(lift) + len(landing)
        if self.match_period_of_deceleration and len(landing) > len(lift):
            return _even(ticks // 2), _even(ticks - ticks // 2)
        return lift, landing


def quarter_angles(increments: np.ndarray, x_law: str) -> np.ndarray:
    """Angle T at each tick of a quarter-step, in [rad]. Shape (ticks,).

    Areas are counted by the share of the step covered before the tick, which a step of no length
    has too; the last increment is cut so that T ends at pi/2.
    """
    angles = [0.0]
    while angles[-1] < QUARTER:
        covered = np.sin(angles[-1]) if x_law == "quarter" else 1.0 - np.cos(angles[-1])
        area = min(int(len(increments) * covered + ROUNDING), len(increments) - 1)
        angle = angles[-1] + float(increments[area])
        angles.append(QUARTER if angle > QUARTER - ROUNDING else angle)
    return np.array(angles[1:])


def _even(ticks: int) -> np.ndarray:
    return QUARTER * np.arange(1, ticks + 1) / ticks
