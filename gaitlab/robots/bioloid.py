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
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from gaitlab.kinematics.head import HeadLengths, camera_pose, pointing_joints
from gaitlab.kinematics.planar_leg import (
    FiveJointLeg,
    LegAngles,
    angles_of,
    ankle_position,
    joints_of,
    leg_angles,
)
from gaitlab.kinematics.reach import require
from gaitlab.kinematics.six_joint_leg import LegLengths
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model import ROUNDING, SIDES, Shape, Side, Tree, Vector, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, head_limb, point_limb
from gaitlab.model.link_table import HERE, Table, below, links, read_table
from gaitlab.model.soles import Sole
from gaitlab.model.targets import angle, both_legs, held, with_ankle
from gaitlab.parameters import parameter
from gaitlab.servos.counts import ax_counts

# Joints whose right servo is turned over.
MIRRORED = ("hip_pitch", "knee", "ankle_pitch", "shoulder_pitch", "elbow")
AX_12: Vector = (0.050, 0.032, 0.040)  # m, the servo's own size
PAPER_FRAME = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])  # and back
_SOLE = "assumption: the published 12 cm2 is no area of a sole that bears this robot"
_TALL = "assumption: the parts add up to the published 40 cm"
_SPACE = "assumption: room of two AX-12 beside each other"
_SPAN = "assumption: the arms add up to the published span of 55 cm"
_WEIGHT = "assumption: the parts add up to the published 3 kg"


def _metres(default: float, high: float, doc: str, source: str) -> float:
    """A length in [m] of at least 5 mm, as a field of a dataclass."""
    value: float = parameter(default, unit="m", low=0.005, high=high, doc=doc, source=source)
    return value


def _kilograms(default: float, high: float, doc: str, source: str) -> float:
    value: float = parameter(default, unit="kg", low=0.0, high=high, doc=doc, source=source)
    return value


@dataclass(frozen=True, kw_only=True)
class BioloidLeg(LegLengths):
    """Lengths of a leg."""

    hip_spacing: float = _metres(0.0385, 0.3, "trunk centre plane to the hip", _SPACE)
    hip_drop: float = _metres(0.030, 0.3, "trunk link frame down to the hip", _SPACE)
    thigh: float = _metres(0.075, 0.5, "L1, hip to knee", "published: 7.5 cm")
    shank: float = _metres(0.075, 0.5, "L2, knee to ankle", "published: 7.5 cm")


@dataclass(frozen=True, kw_only=True)
class UpperBody:
    """Lengths above the hips."""

    waist_height: float = _metres(0.020, 0.2, "trunk link frame to the waist axes", _TALL)
    shoulder_height: float = _metres(0.080, 0.5, "waist to the shoulder axis", _TALL)
    shoulder_spacing: float = _metres(0.070, 0.3, "centre plane to the arm", _SPAN)
    upper_arm: float = _metres(0.090, 0.5, "shoulder to the elbow", _SPAN)
    forearm: float = _metres(0.115, 0.5, "elbow to the fingertips", _SPAN)
    neck: float = _metres(0.035, 0.2, "shoulder axis to the head's tilt axis", _TALL)
    head: float = _metres(0.055, 0.3, "tilt axis to the crown", _TALL)


@dataclass(frozen=True, kw_only=True)
class Masses:
    """What the robot is made of, beside its servos."""

    servo: float = _kilograms(0.0546, 0.5, "one AX-12A", "published: ROBOTIS e-Manual AX-12A")
    frames: float = _kilograms(0.50, 5.0, "brackets and plates", _WEIGHT)
    electronics: float = _kilograms(0.35, 5.0, "battery and CM-530, in the chest", _WEIGHT)
    costume: float = _kilograms(
        0.8942, 5.0, "dress and its brackets, half on the hips, half on the chest", _WEIGHT
    )


@dataclass(frozen=True, kw_only=True)
class BioloidSole(Sole):
    """Sole of the Bioloid."""

    length: float = _metres(0.100, 0.3, "sole along x of the foot", _SOLE)
    width: float = _metres(0.065, 0.2, "sole along y of the foot", _SOLE)
    heel: float = _metres(0.045, 0.3, "ankle axis to the heel edge", _SOLE)
    height: float = _metres(0.030, 0.2, "ankle axis over the sole", _TALL)
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the kit's plastic plate",
    )


@dataclass(frozen=True, kw_only=True)
class BioloidPosture:
    """What waist, arms and head hold unless a gait moves them; the right arm mirrors the left."""

    waist_yaw: float = angle(0.0, low=-1.57, high=1.57, doc="positive turns left")
    waist_roll: float = angle(0.0, low=-0.52, high=0.52, doc="positive leans right")
    waist_pitch: float = angle(0.0, low=-0.52, high=0.78, doc="positive leans forward")
    shoulder_pitch: float = angle(0.2, low=-2.6, high=2.6, doc="positive swings the arm back")
    shoulder_roll: float = angle(0.2, low=-0.17, high=2.09, doc="positive lifts it sideways")
    arm_yaw: float = angle(0.0, low=-1.57, high=1.57, doc="positive turns it outwards")
    elbow: float = angle(-0.6, low=-2.26, high=0.0, doc="negative bends it forward")
    head_pan: float = angle(0.0, low=-1.57, high=1.57, doc="positive looks left")
    head_tilt: float = angle(0.0, low=-0.78, high=0.78, doc="positive looks down")


@dataclass(frozen=True, kw_only=True)
class Robot:
    """Bioloid; the trunk link is the pelvis, on which a waist of three joints carries the chest."""

    name: ClassVar[str] = "bioloid"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")
    table: ClassVar[Table] = read_table(Path(__file__).with_name("bioloid_links.csv"))

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
        """Links of `bioloid_links.csv`: trunk, legs, waist, arms, head, each left before right."""
        return Tree(tuple(links(self.table, self._shapes(), self._masses())))

    def _masses(self) -> Mapping[str, float]:
        """Of the links: their servos, their share of the frames and what they wear, in [kg]."""
        servo, frames, costume = self.masses.servo, self.masses.frames, 0.5 * self.masses.costume
        worn = {"trunk": costume, "chest": costume + self.masses.electronics}
        return {
            row["link"]: int(row["servos_carried"]) * servo
            + float(row["frame_share"]) * frames
            + worn.get(row["link"], 0.0)
            for row in self.table
        }

    def _shapes(self) -> Mapping[str, Shape]:
        """Where the links hang, and boxes of plausible sizes."""
        leg, body, sole = self.leg, self.upper_body, self.sole
        thigh, shank, upper, forearm = leg.thigh, leg.shank, body.upper_arm, body.forearm
        across, tall = body.shoulder_spacing, body.shoulder_height
        x, y, z = sole.centre
        return {
            "trunk": Shape(HERE, (0.070, 0.115, 0.045), (-0.005, 0.0, -0.012)),
            "hip": Shape((0.0, leg.hip_spacing, -leg.hip_drop), AX_12),
            "thigh": Shape(HERE, (0.040, 0.045, thigh), below(0.7 * thigh)),
            "shank": Shape(below(thigh), (0.035, 0.040, shank), below(0.6 * shank)),
            "ankle": Shape(below(shank), AX_12),
            "foot": Shape(HERE, (sole.length, sole.width, 0.006), (x, y, z + 0.003)),
            "waist_turn": Shape((0.0, 0.0, body.waist_height), (0.040, 0.040, 0.020)),
            "waist": Shape(HERE, AX_12),
            "chest": Shape(HERE, (0.075, 0.110, tall + 0.015), (-0.008, 0.0, 0.5 * tall + 0.008)),
            "shoulder": Shape((0.0, 0.0, tall), AX_12, (0.0, 0.9 * across, 0.0)),
            "upper_arm": Shape((0.0, across, 0.0), (0.035, 0.035, 0.045), below(0.020)),
            "arm_turn": Shape(HERE, (0.032, 0.032, 0.045), below(0.8 * upper)),
            "forearm": Shape(below(upper), (0.025, 0.03, forearm), below(0.5 * forearm)),
            "neck": Shape((0.0, 0.0, tall), (0.032, 0.040, 0.035), (0.0, 0.0, 0.5 * body.neck)),
            "head": Shape(
                (0.0, 0.0, body.neck), (0.055, 0.065, body.head), (0.0, 0.0, 0.5 * body.head)
            ),
        }

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put level feet there, all else held, in [rad]. Shape (n, 23).

        Which way the feet point follows from the lean, the legs have no hip yaw.

        Raises:
            Infeasible: If a sole is out of reach, is to be turned, or a joint is beyond its limit.
        """
        others = self.tree.joints[10:]
        return both_legs(lambda index: self._leg_targets(feet, index), held(self.posture, others))

    @cached_property
    def servo_directions(self) -> np.ndarray:
        """1 or -1 for each joint: the right pitch servos are turned over, an assumption."""
        over = tuple(f"right_{joint}" for joint in MIRRORED)
        return np.array([-1 if joint.name in over else 1 for joint in self.tree.joints])

    def limbs(self) -> Mapping[str, Limb]:
        """Legs in the frame of [Setiyono], and the head."""
        head = HeadLengths(neck=self.upper_body.neck, camera=self.upper_body.head)
        pose, pointing = partial(camera_pose, head), partial(pointing_joints, head)
        legs = [self._leg_limb(index) for index in (0, 1)]
        head_itself = head_limb(pose, pointing, self.tree.joints[-2:])
        return {limb.name: limb for limb in (*legs, head_itself)}

    def _leg_limb(self, index: int) -> Limb:
        """A leg, its target as the paper has it; the sole is level."""
        thigh, shank, name = self.leg.thigh, self.leg.shank, f"{SIDES[index]}_leg"
        own = slice(5 * index, 5 * index + 5)
        directions = self.servo_directions[own]

        def forward(position: np.ndarray) -> np.ndarray:
            ankle = ankle_position(
                angles_of(position), thigh=thigh, shank=shank, coupling="spatial"
            )
            roll, *pitches, ankle_roll = position
            sole = axis_rotation("x", roll) @ axis_rotation("y", sum(pitches))
            sole = PAPER_FRAME @ sole @ axis_rotation("x", ankle_roll) @ PAPER_FRAME
            return homogeneous(sole, ankle)

        def inverse(point: np.ndarray) -> np.ndarray:
            found = leg_angles(
                point, thigh=thigh, shank=shank, coupling="spatial", ankle_law="flat", limb=name
            )
            folded = 2.0 * np.arctan2(point[0], np.hypot(point[1], point[2])) - found.alpha
            beta = -found.beta
            backwards = LegAngles(folded, beta, beta - folded, found.theta, found.omega)
            return np.stack([joints_of(found), joints_of(backwards)])

        return point_limb(
            name,
            self.tree.joints[own],
            "the ankle's pitch axis from the hip's: x forward, y down, z to the robot's right",
            forward=forward,
            inverse=inverse,
            counts=lambda position: ax_counts(position, directions),
        )

    def leg_of(self, side: Side) -> FiveJointLeg:
        """Kinematics of a leg in the trunk's frame."""
        return FiveJointLeg(geometry=self.leg, ankle_height=self.sole.height, side=side)

    def _leg_targets(self, feet: FeetPoses, index: int) -> np.ndarray:
        side = SIDES[index]
        heading = feet.heading[:, index]
        require(
            np.abs(heading) <= ROUNDING,
            heading,
            f"{side}_leg",
            "foot would have to turn by {found:.3f} rad, the leg has no hip yaw: allowed is 0",
        )
        position = feet.position[:, index] - [0.0, 0.0, self.hip_offset()]
        joints = self.leg_of(side).level_joints(position, feet.trunk_pitch)
        limits = self.tree.joints[5 * index : 5 * index + 5]
        require_limits(f"{side}_leg", limits, joints)
        return with_ankle(joints, limits, feet, index)
