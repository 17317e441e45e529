"""FLoW: 110 cm, 12.5 kg, a teen-size humanoid whose legs are parallelograms.

Height and mass are published, and equations for head, arm and leg; every length, mass, limit and
servo is assumed. The paper counts joints in three ways (legs 8, 6 or 5; arms 7, 6 or 5); what
satisfies most of its statements are 6 joints a leg of which the parallelograms leave 5 free, 5 an
arm with a wrist of 1 or 2 as an option, 2 for the head and 1 at the waist: 25 joints, 23 free.

The foot keeps the pitch of the pelvis. `parallelogram: serial` models that by the command, the
ankle pitch is minus the sum of hip pitch and knee and as strong as rods are; `geared` has the
knee's and the ankle's plate as links of their own, each tied to the link above it.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi, radians
from typing import ClassVar, Literal

import numpy as np

from gaitlab.body import Axis, Box, Coupling, Link, Part, Tree, both_legs, limb, require_limits
from gaitlab.kinematics.dh_arm import DhArm
from gaitlab.kinematics.dh_head import DhHead
from gaitlab.kinematics.flow_geometry import FlowArm, FlowLeg, FlowTorso, metres
from gaitlab.kinematics.leg import Leg
from gaitlab.kinematics.parallelogram import parallelogram_joints, plate_joints
from gaitlab.limbs import Limb, arm_limb, head_limb, leg_limb
from gaitlab.motion import FeetPoses
from gaitlab.parameters import parameter
from gaitlab.soles import Sole, require_parallel

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
Vector = tuple[float, float, float]

# Link masses in [kg] of a robot of 12.50 kg, an assumption; parameter `mass` scales them together.
# Rods are counted with thigh and shank; a serial leg carries the knee's plate with its shank.
MASSES = {
    **{"pelvis": 1.30, "torso": 3.00, "neck": 0.15, "head": 0.55},
    **{"shoulder": 0.10, "shoulder_lift": 0.15, "upper_arm": 0.35, "forearm": 0.25, "hand": 0.10},
    **{"hip_yaw": 0.35, "hip_roll": 0.45, "thigh": 0.70, "knee_plate": 0.25, "shank": 0.50},
    **{"ankle_plate": 0.20, "foot": 0.35},
}
SINGLE = ("pelvis", "torso", "neck", "head")  # links that come once; others come left and right
TABLE_MASS = sum(mass if name in SINGLE else 2.0 * mass for name, mass in MASSES.items())

# Joint limits in degrees, lower and upper, an assumption. Thigh and shank of a parallelogram stop
# well short of 90 degrees from the plates, where it would flip.
LIMITS_DEG = {
    "hip_yaw": (-45.0, 45.0),
    "hip_roll": (-35.0, 35.0),
    "hip_pitch": (-75.0, 40.0),
    "knee": (0.0, 130.0),
    "ankle_pitch": (-75.0, 40.0),
    "ankle_roll": (-35.0, 35.0),
    "knee_plate": (-40.0, 75.0),
    "shank_pitch": (-40.0, 75.0),
    "waist_yaw": (-60.0, 60.0),
    "shoulder_turn": (-180.0, 180.0),
    "shoulder_lift": (0.0, 160.0),
    "upper_arm_turn": (-120.0, 120.0),
    "elbow": (0.0, 140.0),
    "forearm_turn": (-150.0, 150.0),
    "wrist_bend": (-90.0, 90.0),
    "wrist_turn": (-150.0, 150.0),
    "head_pan": (-120.0, 120.0),
    "head_tilt": (-30.0, 90.0),
}
HIP_PITCH, SHANK, PAIR = "hip_pitch", "shank_pitch", "mx_106_pair"
# Servos of a leg, but for the yaw's single MX-106: one cannot carry the robot on one leg, two can.
# The rods' share is a strong ankle, or a gear and no servo.
_ROLLS = {"hip_roll": PAIR, "ankle_roll": PAIR}
SERVOS: dict[str, dict[str, str | None]] = {
    "serial": {**_ROLLS, HIP_PITCH: PAIR, "knee": PAIR, "ankle_pitch": "parallelogram_rods"},
    "geared": {**_ROLLS, HIP_PITCH: PAIR, SHANK: PAIR, "knee_plate": None, "ankle_pitch": None},
}
TREAD = 0.015  # m, thickness of the foot plate
BONE = 0.050  # m, breadth of thigh, shank and arm
_HERE: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class FlowSole(Sole):
    """Sole of FLoW."""

    length: float = metres(0.200, "sole along x of the foot")
    width: float = metres(0.110, "sole along y of the foot")
    heel: float = metres(0.085, "ankle axis to the heel edge", low=0.0)
    height: float = metres(0.060, "dz6, ankle axis over the sole")
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the paper does not describe the sole",
    )


@dataclass(frozen=True, kw_only=True)
class Posture:
    """What waist, arms and head hold while the legs walk; both arms alike."""

    shoulder_lift: float = parameter(
        0.2, unit="rad", low=0.0, high=2.79, doc="positive lifts the arm", source="assumption"
    )
    shoulder_turn: float = parameter(
        1.2, unit="rad", low=-pi, high=pi, doc="0 lifts forward, pi/2 out", source="assumption"
    )
    elbow: float = parameter(
        0.5, unit="rad", low=0.0, high=2.44, doc="positive bends the elbow", source="assumption"
    )


@dataclass(frozen=True, kw_only=True)
class Robot:
    """FLoW; the trunk link is the pelvis, its frame the legs' common origin."""

    name: ClassVar[str] = "flow"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")

    mass: float = parameter(
        12.5,
        unit="kg",
        low=2.0,
        high=60.0,
        doc="mass of the robot, over all links in fixed shares",
        source="published: introduction; the shares are an assumption",
    )
    arm_joints: Literal[5, 6, 7] = parameter(
        5, unit="-", doc="joints an arm", source="published: 5, 6 and 7; only 5 have equations"
    )
    parallelogram: Literal["serial", "geared"] = parameter(
        "serial",
        unit="-",
        doc="serial commands the ankle as the rods would hold it, geared has plates and gears",
        source="reconstruction: the paper calls the legs parallelograms and models none",
    )
    leg: FlowLeg = field(default_factory=FlowLeg)
    sole: FlowSole = field(default_factory=FlowSole)
    torso: FlowTorso = field(default_factory=FlowTorso)
    arm: FlowArm = field(default_factory=FlowArm)
    posture: Posture = field(default_factory=Posture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: pelvis, left leg, right leg, torso, left arm, right arm, head."""
        legs = (link for side in SIDES for link in self._leg_links(side))
        arms = (link for side in SIDES for link in self._arm_links(side))
        pelvis = Box(size=(0.10, 0.20, 0.10), centre=_HERE)
        trunk = Link(
            name="pelvis",
            parent=None,
            origin=_HERE,
            joint=None,
            mass=self._mass("pelvis"),
            box=pelvis,
        )
        return Tree((trunk, *legs, *self._torso_links(), *arms, *self._head_links()))

    @property
    def couplings(self) -> tuple[Coupling, ...]:
        """What keeps the plates of geared legs parallel to the pelvis."""
        if self.parallelogram == "serial":
            return ()
        pairs = ((HIP_PITCH, "knee_plate"), (SHANK, "ankle_pitch"))
        return tuple(
            Coupling(f"{side}_{upper}", f"{side}_{plate}", -1.0)
            for side in SIDES
            for upper, plate in pairs
        )

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, the rest held, in [rad]. Shape (n, joints).

        Raises:
            Infeasible: If a sole is out of reach, a leg joint beyond its limit, or a sole is to
                pitch against the pelvis, which parallelograms do not allow.
        """
        require_parallel(feet)
        legs = both_legs(lambda index: self._leg_targets(feet, index, SIDES[index]))
        held = np.tile(self._held(), (len(feet.position), 1))
        return np.concatenate([*legs, held], axis=1)

    def limbs(self) -> Mapping[str, Limb]:
        """Legs, as serial chains, arms and head, each in the frame of [Yanto]."""
        joints = replace(self, parallelogram="serial").tree.joints
        arm, head = self.arm_joints, self.head_of()
        found = [
            leg_limb(self.leg_of(side), joints[6 * k : 6 * k + 6], "the pelvis")
            for k, side in enumerate(SIDES)
        ]
        for k, side in enumerate(SIDES):
            found.append(arm_limb(self.arm_of(side), joints[13 + arm * k : 13 + arm * (k + 1)]))
        return {
            each.name: each for each in (*found, head_limb(head.pose, head.pointing, joints[-2:]))
        }

    def leg_of(self, side: Side) -> Leg:
        """Serial kinematics of a leg."""
        return Leg(geometry=self.leg, ankle_height=self.sole.height, side=side)

    def arm_of(self, side: Side) -> DhArm:
        """Kinematics of an arm."""
        hand = None if self.arm_joints == 5 else self.arm.hand
        forearm = self.arm.forearm - (hand or 0.0)
        return DhArm(
            rise=self.arm.rise,
            upper_arm=self.arm.upper_arm,
            forearm=forearm,
            hand=hand,
            name=f"{side}_arm",
        )

    def head_of(self) -> DhHead:
        """Kinematics of the head."""
        return DhHead(neck=self.torso.neck, eyes=self.torso.eyes)

    def _leg_targets(self, feet: FeetPoses, index: int, side: Side) -> np.ndarray:
        leg, count = self.leg_of(side), 6 if self.parallelogram == "serial" else 7
        position = feet.position[:, index] - [0.0, 0.0, self.hip_offset()]
        joints = leg.flat_joints(position, feet.heading[:, index])
        if self.parallelogram == "geared":
            joints = plate_joints(parallelogram_joints(joints))
        limits = self.tree.joints[count * index : count * (index + 1)]
        require_limits(f"{side}_leg", limits, joints)
        return joints

    def _held(self) -> tuple[float, ...]:
        """Waist, arms and head while the legs walk; turns of the right arm mirror."""
        posture, wrist = self.posture, (0.0,) * (self.arm_joints - 4)
        lift, turn, elbow = posture.shoulder_lift, posture.shoulder_turn, posture.elbow
        left, right = (turn, lift, 0.0, elbow, *wrist), (-turn, lift, 0.0, elbow, *wrist)
        return (0.0, *left, *right, 0.0, 0.0)

    def _mass(self, link: str) -> float:
        return MASSES[link] * self.mass / TABLE_MASS

    def _part(
        self, name: str, joint: str, axis: Axis, origin: Vector, box: Box, mass: float | None = None
    ) -> Part:
        lower, upper = (radians(limit) for limit in LIMITS_DEG[joint])
        mass = self._mass(name) if mass is None else mass
        return Part(name, joint, axis, (lower, upper), origin, mass, box)

    def _leg_links(self, side: Side) -> Iterator[Link]:
        part, sole, leg = self._part, self.sole, self.leg
        hip = (0.0, leg.hip_spacing if side == "left" else -leg.hip_spacing, -leg.hip_drop)
        x, y, z = sole.centre
        tread = Box(size=(sole.length, sole.width, TREAD), centre=(x, y, z + TREAD / 2))
        top = (
            part("hip_yaw", "hip_yaw", "z", hip, _block(0.06, 0.02)),
            part("hip_roll", "hip_roll", "x", _HERE, _block(0.08)),
            part("thigh", HIP_PITCH, "y", _HERE, _bone(leg.thigh)),
        )
        foot = part("foot", "ankle_roll", "x", _HERE, tread)
        parts = (*top, *self._below_the_knee(), foot)
        servos = SERVOS[self.parallelogram]
        for link in limb(parts, parent="pelvis", servo="mx_106", prefix=f"{side}_"):
            assert link.joint is not None  # every link of a limb has one
            name = link.joint.name.removeprefix(f"{side}_")
            yield replace(link, joint=replace(link.joint, servo=servos.get(name, link.joint.servo)))

    def _below_the_knee(self) -> tuple[Part, ...]:
        part, leg = self._part, self.leg
        shank = _bone(leg.shank)
        ankle = part("ankle_plate", "ankle_pitch", "y", _below(leg.shank), _block(0.06))
        if self.parallelogram == "serial":
            mass = self._mass("shank") + self._mass("knee_plate")
            return part("shank", "knee", "y", _below(leg.thigh), shank, mass), ankle
        plate = part("knee_plate", "knee_plate", "y", _below(leg.thigh), _block(0.06))
        return plate, part("shank", SHANK, "y", _HERE, shank), ankle

    def _torso_links(self) -> Iterator[Link]:
        torso = self.torso
        tall = torso.shoulder_height + 0.02
        box = Box(size=(0.12, 0.22, tall), centre=_below(-tall / 2))
        waist = self._part("torso", "waist_yaw", "z", _below(-torso.waist_height), box)
        yield from limb((waist,), parent="pelvis", servo="mx_106")

    def _arm_links(self, side: Side) -> Iterator[Link]:
        part, arm, count = self._part, self.arm, self.arm_joints
        across = arm.spacing if side == "left" else -arm.spacing
        shoulder = (0.0, across, self.torso.shoulder_height)
        fore, mass = arm.forearm - (0.0 if count == 5 else arm.hand), self._mass("hand")
        each = mass / (count - 4)
        parts = (
            part("shoulder", "shoulder_turn", "z", shoulder, _block(0.05)),
            part("shoulder_lift", "shoulder_lift", "-y", _below(-arm.rise), _block(0.06)),
            part("upper_arm", "upper_arm_turn", "-z", _HERE, _bone(arm.upper_arm)),
            part("forearm", "elbow", "-y", _below(arm.upper_arm), _bone(0.7 * fore)),
            part("hand", "forearm_turn", "-z", _HERE, _tip(fore), each),
            part("wrist", "wrist_bend", "-y", _below(fore), _block(0.03), each),
            part("palm", "wrist_turn", "-z", _HERE, _tip(arm.hand), each),
        )
        yield from limb(parts[:count], parent="torso", servo="mx_64", prefix=f"{side}_")

    def _head_links(self) -> Iterator[Link]:
        part, torso = self._part, self.torso
        base = _below(-torso.shoulder_height - torso.neck_height)
        tall = torso.eyes + torso.crown
        skull = Box(size=(0.12, 0.12, tall), centre=_below(-tall / 2))
        neck = Box(size=(0.04, 0.04, torso.neck), centre=_below(-torso.neck / 2))
        parts = (
            part("neck", "head_pan", "z", base, neck),
            part("head", "head_tilt", "y", _below(-torso.neck), skull),
        )
        yield from limb(parts, parent="torso", servo="mx_28")


def _below(distance: float) -> Vector:
    return (0.0, 0.0, -distance)


def _block(edge: float, height: float | None = None) -> Box:
    return Box(size=(edge, edge, edge if height is None else height), centre=_HERE)


def _bone(length: float) -> Box:
    """A link that hangs down, a little short of the next joint."""
    return Box(size=(BONE, BONE, 0.85 * length), centre=_below(length / 2.0))


def _tip(length: float) -> Box:
    """The last third of a link, out to its tip."""
    return Box(size=(BONE, BONE, length / 3.0), centre=_below(length * 5.0 / 6.0))
