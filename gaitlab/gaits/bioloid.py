"""The five-pose keyframe gait of the Bioloid dance robot: upright, lift, step, lift, step.

The poses are hip-to-ankle positions in the torso's frame, [Setiyono] Table 2; between them the
joints move, which is why this gait sets the leg joints itself. Both step poses only stand on level
soles if one lean holds for both legs: with the published ankle law (`ankle_law: published`) the
soles are 18 degrees out of parallel, `flat` corrects it. Timing and interpolation are not
published, nor is the sign of the stance leg's ankle roll settled (`stance_omega_sign`).

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang. Table 2, eqs. (1) to (9).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import hypot, radians
from typing import Any, Literal

import numpy as np

from gaitlab.kinematics.planar_leg import (
    AnkleLaw,
    Coupling,
    LegAngles,
    joints_of,
    leg_angles,
    sole_points,
)
from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

SIDES = ("left", "right")
JOINTS = ("hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
UPRIGHT, CYCLE = 0, (1, 2, 3, 4)  # rows of the table of poses; the cycle repeats four of them
SWINGING = ((1, 0), (1, 0), (0, 1), (0, 1))  # left, right foot on the way to each pose of the cycle
FRONT_RISE = 0.010 / 0.035  # -, Table 2: the front foot stands 1 cm higher at 3.5 cm ahead
ROUNDING = 1e-9  # share of a control period


def _table_2(default: float, low: float, high: float, doc: str) -> Any:
    source = "published: Table 2"
    return parameter(default, unit="m", low=low, high=high, doc=doc, source=source)


def _length(default: float, doc: str, source: str) -> Any:
    return parameter(default, unit="m", low=0.001, high=0.5, doc=doc, source=source)


@dataclass(frozen=True, kw_only=True)
class Gait:
    """The walk of [Setiyono] section 2.3; with its defaults the poses are Table 2.

    Upright stands still, then lift left, step left, lift right, step right repeat. The start-up
    stands with level trunk, leans, and walks one cycle.
    """

    step_length: float = _table_2(0.035, -0.08, 0.08, "x of the front less the rear foot in a step")
    step_height: float = _table_2(0.015, 0.0, 0.06, "y of stance less y of swing foot")
    lateral_sway: float = _table_2(
        0.010, -0.05, 0.05, "z of the hips over the stance foot in a lift"
    )
    swing_shift: float = _table_2(0.025, -0.05, 0.05, "z of the swing foot in a lift, inwards")
    step_shift: float = _table_2(0.005, -0.05, 0.05, "z of both feet in a step")
    leg_drop: float = _table_2(0.115, 0.03, 0.15, "y of a foot that stands")
    upright_x: float = _table_2(0.020, -0.1, 0.1, "x of both feet in upright")
    lift_x: float = _table_2(0.035, -0.1, 0.1, "x of the stance foot in a lift")
    swing_x: float = _table_2(0.030, -0.1, 0.1, "x of the swing foot in a lift")
    step_x: float = _table_2(0.0325, -0.1, 0.1, "mean x of both feet in a step")
    ankle_law: AnkleLaw = parameter(
        "flat",
        unit="-",
        doc="gamma of eq. (7) as printed, or the one that keeps both soles level",
        source="reconstruction: the measured ankles obey the flat law",
    )
    coupling: Coupling = parameter(
        "planar",
        unit="-",
        doc="R of a rolled leg as printed, or over its real length",
        source="published: eq. (1); spatial is a correction",
    )
    stance_omega_sign: Literal[1, -1] = parameter(
        1,
        unit="-",
        doc="ankle roll of the stance leg in a lift: 1 as eq. (9), -1 as both robots measured",
        source="published: eq. (9); Tables 7 to 10 show the opposite",
    )
    standing_pitch: float = parameter(
        radians(9.9),
        unit="rad",
        low=-0.2,
        high=0.6,
        doc="lean of the trunk in upright",
        source="published: mean of Tables 7 to 10",
    )
    trunk_pitch: float = parameter(
        radians(17.2),
        unit="rad",
        low=-0.2,
        high=0.6,
        doc="lean of the trunk in all other poses",
        source="published: mean of Tables 7 to 10",
    )
    move_time: float = parameter(
        0.4,
        unit="s",
        low=0.02,
        high=5.0,
        doc="from pose to pose",
        source="assumption: not published; below 0.1 s no servo follows",
    )
    pause_time: float = parameter(
        0.0, unit="s", low=0.0, high=5.0, doc="rest in every pose", source="assumption"
    )
    profile: Literal["cubic", "linear"] = parameter(
        "cubic", unit="-", doc="how a joint moves between poses", source="assumption"
    )
    waist_sway: float = parameter(
        0.0,
        unit="rad",
        low=-0.5,
        high=0.5,
        doc="waist roll towards the stance leg in a lift",
        source="assumption: the text moves the waist, no angle is given",
    )
    control_period: float = parameter(
        0.008,
        unit="s",
        low=0.001,
        high=0.1,
        doc="between two targets",
        source="assumption: step of the RoboPlus motion player",
    )
    standing_offset: float = parameter(
        0.015,
        unit="m",
        low=-0.05,
        high=0.05,
        doc="hips ahead of the ankles while standing with a level trunk, before upright",
        source="assumption",
    )
    stand_time: float = parameter(
        1.0, unit="s", low=0.1, high=10.0, doc="standing before walking", source="assumption"
    )
    thigh: float = _length(0.075, "L1", "published: 7.5 cm")
    shank: float = _length(0.075, "L2", "published: 7.5 cm")
    hip_spacing: float = _length(0.0385, "hip off the centre plane", "assumption")
    ankle_height: float = _length(0.030, "ankle over the sole", "assumption")

    @property
    def hip_height(self) -> float:
        """Height of the hip axes over the soles in upright, in [m]."""
        return hypot(self.upright_x, self.leg_drop) + self.ankle_height

    @property
    def gait_period(self) -> float:
        """Four poses, in [s]."""
        return len(CYCLE) * self._pose_time

    @property
    def startup_time(self) -> float:
        """Standing, leaning and one cycle, in [s]."""
        return self._walk_start + self.gait_period

    @cached_property
    def targets(self) -> np.ndarray:
        """x, y, z from hip to ankle in every pose, in [m]. Shape (5, left and right, 3).

        Poses are upright, lift left, step left, lift right, step right, as in Table 2.
        """
        upright = (self.upright_x, self.leg_drop, 0.0)
        stance = (self.lift_x, self.leg_drop, self.lateral_sway)
        swing = (self.swing_x, self.leg_drop - self.step_height, -self.swing_shift)
        moved, left = self._step_feet()
        turned = [1.0, 1.0, -1.0]  # the other leg: only z changes sign
        lift_right = np.array([stance, swing])
        step_right = np.array([left, moved])
        lift_left, step_left = lift_right[::-1] * turned, step_right[::-1] * turned
        return np.stack([np.array([upright] * 2), lift_left, step_left, lift_right, step_right])

    @cached_property
    def angles(self) -> LegAngles:
        """Leg angles of every pose in the paper's signs, in [rad]. Shape (5, 2) each.

        Raises:
            Infeasible: If a pose is out of reach; the tick it names is the pose.
        """
        sign = np.ones((5, 2))
        sign[1, 1] = sign[3, 0] = self.stance_omega_sign
        return leg_angles(
            self.targets,
            thigh=self.thigh,
            shank=self.shank,
            coupling=self.coupling,
            ankle_law=self.ankle_law,
            lean=self._lean[:, None],
            omega_sign=sign,
        )

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Joints and the foot poses they mean, at the instants t, in [s], t >= 0. Shape (n,)."""
        tick = np.floor(np.asarray(t) / self.control_period + ROUNDING)
        time = tick * self.control_period
        pose, since = self._pose(time)
        legs, lean, waist = self._at(time, pose, since)
        (count, segment), walking = np.divmod(pose, 4), pose >= 4
        in_air = (segment % 2 == 0) | (since < self.move_time - ROUNDING)
        names = [f"{side}_{joint}" for side in SIDES for joint in JOINTS]
        return FeetPoses(
            position=sole_points(
                legs,
                lean,
                thigh=self.thigh,
                shank=self.shank,
                hip_spacing=self.hip_spacing,
                ankle_height=self.ankle_height,
            ),
            heading=np.zeros((len(time), 2)),
            trunk_pitch=lean,
            ankle_pitch=np.zeros((len(time), 2)),
            knee_only=np.zeros((len(time), 2)),
            swing=np.array(SWINGING, dtype=bool)[segment] & (in_air & (pose >= 0))[:, None],
            phase=np.where(walking, (segment + since / self._pose_time) / 4.0, np.nan),
            step_index=np.where(walking, 2 * (count - 1) + segment // 2, -1).astype(int),
            joints={
                **dict(zip(names, legs.reshape(len(time), -1).T, strict=True)),
                "waist_roll": waist,
            },
        )

    @property
    def _pose_time(self) -> float:
        return self.move_time + self.pause_time

    @property
    def _walk_start(self) -> float:
        return 2.0 * self.stand_time

    @property
    def _lean(self) -> np.ndarray:
        return np.array([self.standing_pitch] + [self.trunk_pitch] * 4)

    def _step_feet(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """x, y, z of the foot that has stepped, on the right, and of the other, on the left."""
        half, rise = 0.5 * self.step_length, FRONT_RISE * abs(self.step_length)
        up, down = self.leg_drop - rise, self.leg_drop
        moved, other = (up, down) if half >= 0.0 else (down, up)
        return (
            (self.step_x + half, moved, -self.step_shift),
            (self.step_x - half, other, self.step_shift),
        )

    def _pose(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pose under way, counted from the first lift, negative before; and the time in it, [s]."""
        walked = time - self._walk_start
        pose = np.floor(walked / self._pose_time + ROUNDING).astype(int)
        return pose, np.maximum(walked - pose * self._pose_time, 0.0)

    def _at(
        self, time: np.ndarray, pose: np.ndarray, since: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Leg joints (n, 2, 5), lean (n,) and waist roll (n,) at instants, in [rad]."""
        level = len(self._lean)  # the row after the table's: standing with a level trunk
        end = np.where(pose < 0, UPRIGHT, 1 + pose % 4)
        start = np.where(pose < 0, level, np.where(pose == 0, UPRIGHT, 1 + (pose - 1) % 4))
        leaning = (time - self.stand_time) / self.stand_time
        share = self._eased(np.clip(np.where(pose < 0, leaning, since / self.move_time), 0.0, 1.0))
        tables = self._legs, np.append(self._lean, 0.0), self._waist
        legs, lean, waist = (_blend(rows[start], rows[end], share) for rows in tables)
        return legs, lean, waist

    def _eased(self, share: np.ndarray) -> np.ndarray:
        return share if self.profile == "linear" else share**2 * (3.0 - 2.0 * share)

    @cached_property
    def _legs(self) -> np.ndarray:
        """Leg joints of the five poses and of standing with a level trunk. Shape (6, 2, 5)."""
        drop = hypot(self.upright_x, self.leg_drop)
        level = leg_angles(
            np.array([[-self.standing_offset, drop, 0.0]] * 2),
            thigh=self.thigh,
            shank=self.shank,
            ankle_law="flat",
        )
        return np.concatenate([joints_of(self.angles), joints_of(level)[None]])

    @property
    def _waist(self) -> np.ndarray:
        """Waist roll of every pose; positive leans right, over the right foot in lift left."""
        return np.array([0.0, self.waist_sway, 0.0, -self.waist_sway, 0.0, 0.0])


def _blend(start: np.ndarray, end: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Rows between two ends, shares along the first axis."""
    part = share.reshape(-1, *[1] * (start.ndim - 1))
    return (1.0 - part) * start + part * end
