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

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar, Literal

import numpy as np

from gaitlab.body import ROUNDING, Box, Link, Part, Tree, both_legs, limb, require_limits
from gaitlab.errors import Infeasible
from gaitlab.kinematics.dynamixel import servo_counts
from gaitlab.kinematics.five_joint_leg import FiveJointLeg
from gaitlab.kinematics.head import HeadGeometry, camera_pose, pointing_joints
from gaitlab.kinematics.leg import LegGeometry
from gaitlab.limbs import Limb, head_limb, planar_leg_limb
from gaitlab.motion import FeetPoses
from gaitlab.parameters import parameter
from gaitlab.soles import Sole

Side = Literal["left", "right"]
Axis = Literal["x", "y", "z"]
Vector = tuple[float, float, float]
SIDES: tuple[Side, Side] = ("left", "right")
SERVO = "ax_12"

# Servos that a link carries: those of the joints below it, but for the foot's own.
SERVOS = {
    **{"trunk": 3, "waist_turn": 1, "waist": 1, "chest": 3, "neck": 1, "head": 0},
    **{"hip": 1, "thigh": 1, "shank": 1, "ankle": 1, "foot": 0},
    **{"shoulder": 1, "upper_arm": 1, "arm_turn": 1, "forearm": 0},
}
# Share of the frames' mass, an assumption; left and right limbs count twice, the sum is 1.
FRAMES = {
    **{"trunk": 0.120, "waist_turn": 0.020, "waist": 0.020, "chest": 0.160},
    **{"neck": 0.008, "head": 0.040, "hip": 0.030, "thigh": 0.040, "shank": 0.040},
    **{"ankle": 0.020, "foot": 0.090, "shoulder": 0.016, "upper_arm": 0.020},
    **{"arm_turn": 0.016, "forearm": 0.044},
}

# Joint limits in degrees, lower and upper, an assumption within the servo's +-150.
LIMITS_DEG = {
    "hip_roll": (-45.0, 45.0),
    "hip_pitch": (-110.0, 45.0),
    "knee": (0.0, 135.0),
    "ankle_pitch": (-90.0, 60.0),
    "ankle_roll": (-45.0, 45.0),
    "waist_yaw": (-90.0, 90.0),
    "waist_roll": (-30.0, 30.0),
    "waist_pitch": (-30.0, 45.0),
    "shoulder_pitch": (-149.0, 149.0),
    "shoulder_roll": (-10.0, 120.0),
    "arm_yaw": (-90.0, 90.0),
    "elbow": (-130.0, 0.0),
    "head_pan": (-90.0, 90.0),
    "head_tilt": (-45.0, 45.0),
}
MIRRORED = (
    "hip_pitch",
    "knee",
    "ankle_pitch",
    "shoulder_pitch",
    "elbow",
)  # right servo turned over

_SPACE = "assumption: room of two AX-12 beside each other"
_TALL = "assumption: the parts add up to the published 40 cm"
_SPAN = "assumption: the arms add up to the published span of 55 cm"
_WEIGHT = "assumption: the parts add up to the published 3 kg"
_SOLE = "assumption: the published 12 cm2 is no area of a sole that bears this robot"


def _length(default: float, high: float, doc: str, source: str) -> Any:
    return parameter(default, unit="m", low=0.005, high=high, doc=doc, source=source)


def _mass(default: float, high: float, doc: str, source: str) -> Any:
    return parameter(default, unit="kg", low=0.0, high=high, doc=doc, source=source)


def _angle(default: float, low: float, high: float, doc: str) -> Any:
    return parameter(default, unit="rad", low=low, high=high, doc=doc, source="assumption")


@dataclass(frozen=True, kw_only=True)
class BioloidLeg(LegGeometry):
    """Lengths of a leg."""

    hip_spacing: float = _length(0.0385, 0.3, "trunk centre plane to the hip", _SPACE)
    hip_drop: float = _length(0.030, 0.3, "trunk link frame down to the hip", _SPACE)
    thigh: float = _length(0.075, 0.5, "L1, hip to knee", "published: 7.5 cm")
    shank: float = _length(0.075, 0.5, "L2, knee to ankle", "published: 7.5 cm")


@dataclass(frozen=True, kw_only=True)
class BioloidSole(Sole):
    """Sole of the Bioloid."""

    length: float = _length(0.100, 0.3, "sole along x of the foot", _SOLE)
    width: float = _length(0.065, 0.2, "sole along y of the foot", _SOLE)
    heel: float = _length(0.045, 0.3, "ankle axis to the heel edge", _SOLE)
    height: float = _length(0.030, 0.2, "ankle axis over the sole", _TALL)
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the kit's plastic plate",
    )


@dataclass(frozen=True, kw_only=True)
class UpperBody:
    """Lengths above the hips."""

    waist_height: float = _length(0.020, 0.2, "trunk link frame to the waist axes", _TALL)
    shoulder_height: float = _length(0.080, 0.5, "waist to the shoulder axis", _TALL)
    shoulder_spacing: float = _length(0.070, 0.3, "centre plane to the arm", _SPAN)
    upper_arm: float = _length(0.090, 0.5, "shoulder to the elbow", _SPAN)
    forearm: float = _length(0.115, 0.5, "elbow to the fingertips", _SPAN)
    neck: float = _length(0.035, 0.2, "shoulder axis to the head's tilt axis", _TALL)
    head: float = _length(0.055, 0.3, "tilt axis to the crown", _TALL)


@dataclass(frozen=True, kw_only=True)
class Masses:
    """What the robot is made of, beside its servos."""

    servo: float = _mass(0.0546, 0.5, "one AX-12A", "published: ROBOTIS e-Manual AX-12A")
    frames: float = _mass(0.50, 5.0, "brackets and plates", _WEIGHT)
    electronics: float = _mass(0.35, 5.0, "battery and CM-530, in the chest", _WEIGHT)
    costume: float = _mass(
        0.8942, 5.0, "dress and its brackets, half on the hips, half on the chest", _WEIGHT
    )


@dataclass(frozen=True, kw_only=True)
class Posture:
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
    posture: Posture = field(default_factory=Posture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: trunk, left leg, right leg, waist, left arm, right arm, head."""
        trunk = Link(
            name="trunk",
            parent=None,
            origin=_HERE,
            joint=None,
            mass=self._mass("trunk"),
            box=Box(size=(0.070, 0.115, 0.045), centre=(-0.005, 0.0, -0.012)),
        )
        legs = (link for side in SIDES for link in self._leg_links(side))
        arms = (link for side in SIDES for link in self._arm_links(side))
        return Tree((trunk, *legs, *self._waist_links(), *arms, *self._head_links()))

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

    def _mass(self, link: str) -> float:
        masses = self.masses
        worn = {"trunk": 0.5 * masses.costume, "chest": 0.5 * masses.costume + masses.electronics}
        return SERVOS[link] * masses.servo + FRAMES[link] * masses.frames + worn.get(link, 0.0)

    def _part(
        self, name: str, joint: str, axis: Axis, origin: Vector, size: Vector, centre: Vector
    ) -> Part:
        lower, upper = np.radians(LIMITS_DEG[joint]).tolist()
        box = Box(size=size, centre=centre)
        return Part(name, joint, axis, (lower, upper), origin, self._mass(name), box)

    def _leg_links(self, side: Side) -> Iterator[Link]:
        part, sole, thigh, shank = self._part, self.sole, self.leg.thigh, self.leg.shank
        hip = (0.0, _mirrored(self.leg.hip_spacing, side), -self.leg.hip_drop)
        x, y, z = sole.centre
        tread = (sole.length, sole.width, 0.006)
        parts = (
            part("hip", "hip_roll", "x", hip, _AX_12, _HERE),
            part("thigh", "hip_pitch", "y", _HERE, (0.040, 0.045, thigh), _below(0.7 * thigh)),
            part("shank", "knee", "y", _below(thigh), (0.035, 0.040, shank), _below(0.6 * shank)),
            part("ankle", "ankle_pitch", "y", _below(shank), _AX_12, _HERE),
            part("foot", "ankle_roll", "x", _HERE, tread, (x, y, z + 0.003)),
        )
        return limb(parts, parent="trunk", servo=SERVO, prefix=f"{side}_")

    def _waist_links(self) -> Iterator[Link]:
        part, body = self._part, self.upper_body
        at, tall = (0.0, 0.0, body.waist_height), body.shoulder_height
        chest = (0.075, 0.110, tall + 0.015)
        parts = (
            part("waist_turn", "waist_yaw", "z", at, (0.040, 0.040, 0.020), _HERE),
            part("waist", "waist_roll", "x", _HERE, _AX_12, _HERE),
            part("chest", "waist_pitch", "y", _HERE, chest, (-0.008, 0.0, 0.5 * tall + 0.008)),
        )
        return limb(parts, parent="trunk", servo=SERVO)

    def _arm_links(self, side: Side) -> Iterator[Link]:
        part, body = self._part, self.upper_body
        across = _mirrored(body.shoulder_spacing, side)
        top, roll = (0.0, 0.0, body.shoulder_height), (0.0, across, 0.0)
        upper, lower = body.upper_arm, body.forearm
        parts = (
            part("shoulder", "shoulder_pitch", "y", top, _AX_12, (0.0, 0.9 * across, 0.0)),
            part("upper_arm", "shoulder_roll", "x", roll, (0.035, 0.035, 0.045), _below(0.020)),
            part("arm_turn", "arm_yaw", "z", _HERE, (0.032, 0.032, 0.045), _below(0.8 * upper)),
            part("forearm", "elbow", "y", _below(upper), (0.025, 0.03, lower), _below(0.5 * lower)),
        )
        own = parts if side == "left" else tuple(_turned_over(part) for part in parts)
        return limb(own, parent="chest", servo=SERVO, prefix=f"{side}_")

    def _head_links(self) -> Iterator[Link]:
        part, body = self._part, self.upper_body
        base, crown = (0.0, 0.0, body.shoulder_height), body.head
        lift, centre = (0.0, 0.0, body.neck), (0.0, 0.0, 0.5 * crown)
        parts = (
            part("neck", "head_pan", "z", base, (0.032, 0.040, 0.035), _below(-0.5 * body.neck)),
            part("head", "head_tilt", "y", lift, (0.055, 0.065, crown), centre),
        )
        return limb(parts, parent="chest", servo=SERVO)


_HERE = (0.0, 0.0, 0.0)
_AX_12 = (0.050, 0.032, 0.040)  # m, the servo's own size


def _below(distance: float) -> Vector:
    return (0.0, 0.0, -distance)


def _mirrored(left: float, side: Side) -> float:
    return left if side == "left" else -left


def _turned_over(part: Part) -> Part:
    """The same part of the right arm: limits about x and z mirror."""
    lower, upper = part.limits
    return part if part.axis == "y" else part._replace(limits=(-upper, -lower))


def _require_straight(heading: np.ndarray, side: Side) -> None:
    turned = np.flatnonzero(np.abs(heading) > ROUNDING)
    if len(turned):
        found = heading[turned[0]]
        reason = f"foot would have to turn by {found:.3f} rad, the leg has no hip yaw: allowed is 0"
        raise Infeasible(limb=f"{side}_leg", tick=int(turned[0]), reason=reason)
