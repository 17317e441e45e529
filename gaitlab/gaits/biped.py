"""Straight-legged walking set in joint space: a starting, full and an ending stride.

The leg that just landed supports. In a full stride it first raises the hips on the spot, then
carries them forward by S on a straight leg, while the other foot swings by 2 S. Thigh and shank
follow linear segments with quartic blends and rest at every via point, [Siswoyo2008].
The paper's S is `step_length`, h `step_height`, l `segment`; its t_f is a quarter of `gait_period`.
Leg 1, which supports in the starting stride, is the left one.

Corrections to the printed boundary conditions: the lift of a swing counts from the true height of
the hips (`lift: printed` keeps the approximation); a full stride's lift is at 3 t_f/2 and its two
angles differ in sign; an ending stride ends with both angles at 0. As printed its trailing leg also
straightens before the hips have risen and digs into the floor: here it cruises at another ratio.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import asin, cos
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.kinematics.belt_leg import StrideAngles, ankle_position, stride_angles
from gaitlab.kinematics.blend import JointMotion, blended_path
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

LEFT, RIGHT = 0, 1
THIGH, SHANK = 0, 1
CORRECTED_RATIOS = (1.2, 2.0)  # support, swing of an ending stride; the sole just clears the floor
LATE_LIFT = 0.8  # of an ending stride; the sole just clears the floor
JOINTS = (("left_hip", "left_knee"), ("right_hip", "right_knee"))  # of thigh and shank motors
_ARBITRARY = "assumption: the paper calls it arbitrary and gives none"


class Via(NamedTuple):
    """Where a leg rests for an instant.

    Attributes:
        time: Instant, in units of t_f since the start of the walk.
        thigh: In [rad].
        shank: In [rad].
        ratio: Cruise over mean speed on the way there.
    """

    time: float
    thigh: float
    shank: float
    ratio: float


@dataclass(frozen=True, kw_only=True)
class Gait:
    """The walk of [Siswoyo2008] with its strides as often as wanted."""

    step_length: float = parameter(
        0.20,
        unit="m",
        low=0.0,
        high=1.0,
        doc="S, advance of the hips in a full stride",
        source=_ARBITRARY,
    )
    step_height: float = parameter(
        0.05, unit="m", low=0.0, high=0.5, doc="h, lift of the swing foot", source=_ARBITRARY
    )
    segment: float = parameter(
        0.30, unit="m", low=0.05, high=1.0, doc="l, thigh and shank of the robot", source=_ARBITRARY
    )
    ankle_height: float = parameter(
        0.05, unit="m", low=0.0, high=0.5, doc="ankle over the robot's sole", source="assumption"
    )
    gait_period: float = parameter(
        4.0, unit="s", low=0.2, high=60.0, doc="4 t_f, two full strides", source=_ARBITRARY
    )
    full_strides: int = parameter(
        18,
        unit="-",
        low=0,
        high=10000,
        doc="N, full strides between the starting and the ending one",
        source="assumption: as many as 9 cycles take; the paper's figures seem to show 1",
    )
    speed_ratio: float = parameter(
        4.0 / 3.0,
        unit="-",
        low=1.01,
        high=2.0,
        doc="cruise over mean speed of a segment; 2 is nothing but blends",
        source=f"{_ARBITRARY}; blends of a quarter of the segment",
    )
    lift: Literal["exact", "printed"] = parameter(
        "exact",
        unit="-",
        doc="hip height that the lift counts from; printed assumes it over half the step",
        source="published: section III.A; exact is a correction",
    )
    ending: Literal["corrected", "late", "printed"] = parameter(
        "corrected",
        unit="-",
        doc="ending stride: cruise ratios of its own, lift at 0.8 t_f, or as printed",
        source="published: section III.A; corrected and late are corrections",
    )
    step_width: float = parameter(
        0.12, unit="m", low=0.0, high=0.5, doc="between the robot's feet", source="assumption"
    )
    stand_time: float = parameter(
        0.5, unit="s", low=0.0, high=10.0, doc="standing before walking", source="assumption"
    )

    def __post_init__(self) -> None:
        """Refuse strides that the leg is too short for.

        Raises:
            WrongValue: Says which length is allowed.
        """
        longest = 2.0 * self.segment
        if self.step_length >= longest:
            raise WrongValue(
                f"step_length is {self.step_length} m; legs of two segments of {self.segment} m "
                f"reach less than {longest} m: shorten step_length"
            )
        highest = longest * cos(asin(self.step_length / longest) / 2.0)
        if self.step_height >= highest:
            raise WrongValue(
                f"step_height is {self.step_height} m; the hips are {highest:.4f} m over the ankle "
                "when the foot is lifted: lower step_height"
            )

    @property
    def hip_height(self) -> float:
        """Hips over the soles when standing on straight legs, in [m]."""
        return 2.0 * self.segment + self.ankle_height

    @property
    def half_stride(self) -> float:
        """The paper's t_f, in [s]."""
        return self.gait_period / 4.0

    @property
    def startup_time(self) -> float:
        """Standing and the starting stride, in [s]."""
        return self.stand_time + self.half_stride

    @property
    def duration(self) -> float:
        """Standing and the whole walk, in [s]; afterwards the robot stands."""
        return self.stand_time + (2 * self.full_strides + 2) * self.half_stride

    @cached_property
    def angles(self) -> StrideAngles:
        """Angles of the postures, in [rad]."""
        return stride_angles(self.step_length, self.step_height, self.segment, self.lift)

    @cached_property
    def vias(self) -> tuple[tuple[Via, ...], tuple[Via, ...]]:
        """Via points of the left and of the right leg."""
        rest = Via(0.0, 0.0, 0.0, self.speed_ratio)
        legs: tuple[list[Via], list[Via]] = ([rest], [rest])
        for number, (start, support, swing) in enumerate(self._strides()):
            # Leg 1 supports first, then always the leg that has just landed.
            supporting = LEFT if number % 2 == 0 else RIGHT
            legs[supporting].extend(via._replace(time=start + via.time) for via in support)
            legs[1 - supporting].extend(via._replace(time=start + via.time) for via in swing)
        return tuple(legs[LEFT]), tuple(legs[RIGHT])

    def _strides(self) -> Iterator[tuple[float, list[Via], list[Via]]]:
        """Start in units of t_f, vias of the supporting and of the swinging leg of each stride."""
        theta, k = self.angles.touchdown, self.speed_ratio
        down, behind = Via(1.0, theta, -theta, k), Via(1.0, -theta, -theta, k)
        lifted = Via(0.5, self.angles.lift, -self.angles.lift, k)
        straight = Via(1.0, 0.0, 0.0, k)
        yield 0.0, [behind], [lifted, down]
        swing = [lifted._replace(time=1.5), down._replace(time=2.0)]
        for number in range(self.full_strides):
            yield 1.0 + 2.0 * number, [straight, behind._replace(time=2.0)], swing
        yield 1.0 + 2.0 * self.full_strides, *self._ending()

    def _ending(self) -> tuple[list[Via], list[Via]]:
        support, swing = (self.speed_ratio, self.speed_ratio)
        if self.ending == "corrected":
            support, swing = CORRECTED_RATIOS
        time = LATE_LIFT if self.ending == "late" else 0.5
        lifted = Via(time, self.angles.ending_thigh, self.angles.ending_shank, swing)
        return [Via(1.0, 0.0, 0.0, support)], [lifted, Via(1.0, 0.0, 0.0, swing)]

    def joint_motion(self, t: np.ndarray) -> JointMotion:
        """Left and right leg's thigh and shank at the instants t, in [s]. Shape (n, 2, 2)."""
        walked = np.asarray(t, dtype=float) - self.stand_time
        legs = [[self._segment_motion(walked, leg, part) for part in (1, 2)] for leg in self.vias]
        return JointMotion(*np.moveaxis(np.array(legs), (2, 3), (0, 1)))

    def _segment_motion(self, t: np.ndarray, vias: tuple[Via, ...], part: int) -> JointMotion:
        table = np.array(vias)
        times, values = table[:, 0] * self.half_stride, table[:, part]
        return blended_path(t, times, values, table[1:, 3])

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Commanded foot poses and motor angles at the instants t, in [s], t >= 0. Shape (n,)."""
        angles = self.joint_motion(t).position
        ankle = ankle_position(angles, self.segment)
        n = len(angles)
        position = np.empty((n, 2, 3))
        position[..., 0], position[..., 2] = ankle[..., 0], ankle[..., 1] - self.ankle_height
        position[..., 1] = np.array([0.5, -0.5]) * self.step_width
        stride = self._stride_number(np.asarray(t, dtype=float))
        walking = np.asarray(t) >= self.startup_time - 1e-9
        phase = np.mod((np.asarray(t) - self.startup_time) / self.gait_period, 1.0)
        joints = {JOINTS[i][j]: angles[:, i, j] for i in (LEFT, RIGHT) for j in (THIGH, SHANK)}
        return FeetPoses(
            position=position,
            heading=np.zeros((n, 2)),
            trunk_pitch=np.zeros(n),
            ankle_pitch=np.zeros((n, 2)),
            knee_only=np.zeros((n, 2)),
            swing=(stride >= 0)[:, None] & (stride[:, None] % 2 != np.arange(2)),
            phase=np.where(walking, phase, np.nan),
            step_index=np.where(walking, np.clip(stride - 1, 0, None), -1),
            joints=joints,
        )

    def _stride_number(self, t: np.ndarray) -> np.ndarray:
        """0 in the starting stride, 1 in the first full one; -1 standing before or after."""
        walked = (t - self.stand_time) / self.half_stride + 1e-9
        number = np.floor((walked + 1.0) / 2.0).astype(int)
        standing = (walked < 0.0) | (t >= self.duration - 1e-9)
        return np.where(standing, -1, number)
