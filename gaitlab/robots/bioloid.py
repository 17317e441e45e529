"""Bioloid: a 40 cm, 3 kg dance robot on 23 AX-12 servos, legs without hip yaw.

Height, mass, finger span, the count of joints of each part, thigh and shank are published. How
arms and waist are jointed, hip spacing, sole, limits and where the mass sits are not; what is
assumed says so in its source.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
    ROBOTIS-eManual: e-Manual of the Dynamixel AX-12A, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar, Literal

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.bioloid_geometry import TALL, BioloidLeg, UpperBody, metres
from gaitlab.kinematics.dynamixel import servo_counts
from gaitlab.kinematics.five_joint_leg import FiveJointLeg
from gaitlab.kinematics.head import HeadGeometry, camera_pose, pointing_joints
from gaitlab.model import ROUNDING, Tree, both_legs, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, head_limb, planar_leg_limb
from gaitlab.model.soles import Sole
from gaitlab.parameters import parameter
from gaitlab.robots._bioloid_links import SIDES, BioloidSkeleton, Masses, Side

# Joints whose right servo is turned over.
MIRRORED = ("hip_pitch", "knee", "ankle_pitch", "shoulder_pitch", "elbow")
_SOLE = "assumption: the published 12 cm2 is no area of a sole that bears this robot"


def _angle(default: float, low: float, high: float, doc: str) -> Any:
    return parameter(default, unit="rad", low=low, high=high, doc=doc, source="assumption")


@dataclass(frozen=True, kw_only=True)
class BioloidSole(Sole):
    """Sole of the Bioloid."""

    length: float = metres(0.100, 0.3, "sole along x of the foot", _SOLE)
    width: float = metres(0.065, 0.2, "sole along y of the foot", _SOLE)
    heel: float = metres(0.045, 0.3, "ankle axis to the heel edge", _SOLE)
    height: float = metres(0.030, 0.2, "ankle axis over the sole", TALL)
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the kit's plastic plate",
    )


@dataclass(frozen=True, kw_only=True)
class BioloidPosture:
    """What waist, arms and head hold unless a gait moves them."""

    waist_yaw: float = _angle(0.0, -1.57, 1.57, "positive turns left")
    waist_roll: float = _angle(0.0, -0.52, 0.52, "positive leans right")
    waist_pitch: float = _angle(0.0, -0.52, 0.78, "positive leans forward")
    shoulder_pitch: float = _angle(0.2, -2.6, 2.6, "positive swings the arm back")
    shoulder_roll: float = _angle(0.2, -0.17, 2.09, "positive lifts it sideways")
    arm_yaw: float = _angle(0.0, -1.57, 1.57, "positive turns it outwards")
    elbow: float = _angle(-0.6, -2.26, 0.0, "negative bends it forward")
    head_pan: float = _angle(0.0, -1.57, 1.57, "positive looks left")
    head_tilt: float = _angle(0.0, -0.78, 0.78, "positive looks down")

    def joints(self) -> tuple[float, ...]:
        """Joint positions of the waist, the left arm, the right arm and the head, in [rad]."""
        waist = (self.waist_yaw, self.waist_roll, self.waist_pitch)
        left = (self.shoulder_pitch, self.shoulder_roll, self.arm_yaw, self.elbow)
        right = (self.shoulder_pitch, -self.shoulder_roll, -self.arm_yaw, self.elbow)
        return (*waist, *left, *right, self.head_pan, self.head_tilt)


@dataclass(frozen=True, kw_only=True)
class Robot:
    """Bioloid; the trunk link is the pelvis, on which a waist of three joints carries the chest."""

    name: ClassVar[str] = "bioloid"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")

    leg: BioloidLeg = field(default_factory=BioloidLeg)
    sole: BioloidSole = field(default_factory=BioloidSole)
    upper_body: UpperBody = field(default_factory=UpperBody)
    masses: Masses = field(default_factory=Masses)
    posture: BioloidPosture = field(default_factory=BioloidPosture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: trunk, left leg, right leg, waist, left arm, right arm, head."""
        skeleton = BioloidSkeleton(
            leg=self.leg, sole=self.sole, upper_body=self.upper_body, masses=self.masses
        )
        return Tree(skeleton.links())

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put level feet there, all else held, in [rad]. Shape (n, 23).

        Which way the feet point follows from the lean, the legs have no hip yaw.

        Raises:
            Infeasible: If a sole is out of reach, is to be turned, or a joint is beyond its limit.
        """
        legs = both_legs(lambda index: self._leg_targets(feet, index, SIDES[index]))
        held = np.tile(self.posture.joints(), (len(feet.position), 1))
        return np.concatenate([*legs, held], axis=1)

    def servo_counts(self, joints: np.ndarray) -> np.ndarray:
        """Goal positions of the servos in counts, 512 at zero angle. Shape (..., 23)."""
        return servo_counts(joints, self.servo_directions)

    @cached_property
    def servo_directions(self) -> np.ndarray:
        """1 or -1 for each joint: the right pitch servos are turned over, an assumption."""
        over = tuple(f"right_{joint}" for joint in MIRRORED)
        return np.array([-1 if joint.name in over else 1 for joint in self.tree.joints])

    def limbs(self) -> Mapping[str, Limb]:
        """Legs in the frame of [Setiyono], and the head."""
        joints, body = self.tree.joints, self.upper_body
        head = HeadGeometry(neck=body.neck, camera=body.head)
        legs = [
            planar_leg_limb(self.leg, joints[5 * k : 5 * k + 5], side, self._leg_directions[k])
            for k, side in enumerate(SIDES)
        ]
        pose, pointing = partial(camera_pose, head), partial(pointing_joints, head)
        return {each.name: each for each in (*legs, head_limb(pose, pointing, joints[-2:]))}

    @property
    def _leg_directions(self) -> np.ndarray:
        return self.servo_directions[:10].reshape(2, 5)

    def leg_of(self, side: Side) -> FiveJointLeg:
        """Kinematics of a leg in the trunk's frame."""
        return FiveJointLeg(geometry=self.leg, ankle_height=self.sole.height, side=side)

    def _leg_targets(self, feet: FeetPoses, index: int, side: Side) -> np.ndarray:
        _require_straight(feet.heading[:, index], side)
        position = feet.position[:, index] - [0.0, 0.0, self.hip_offset()]
        joints = self.leg_of(side).level_joints(position, feet.trunk_pitch)
        limits = self.tree.joints[5 * index : 5 * index + 5]
        require_limits(f"{side}_leg", limits, joints)
        # Only the added part gives way to the limit; the level sole's own angle has been checked.
        added = feet.knee_only[:, index] * joints[:, 1] + feet.ankle_pitch[:, index]
        joints[:, 3] = np.clip(joints[:, 3] + added, limits[3].lower, limits[3].upper)
        return joints


def _require_straight(heading: np.ndarray, side: Side) -> None:
    turned = np.flatnonzero(np.abs(heading) > ROUNDING)
    if len(turned):
        found = heading[turned[0]]
        reason = f"foot would have to turn by {found:.3f} rad, the leg has no hip yaw: allowed is 0"
        raise Infeasible(limb=f"{side}_leg", tick=int(turned[0]), reason=reason)
