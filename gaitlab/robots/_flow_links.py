"""Links of FLoW: what each weighs, how far its joint turns and which servo drives it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import radians
from typing import Literal

from gaitlab.kinematics.flow_geometry import FlowArm, FlowLeg, FlowTorso
from gaitlab.model import Axis, Box, Link, Part, limb
from gaitlab.model.soles import Sole

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
class FlowSkeleton:
    """What the links are made from, each a parameter of the robot.

    Attributes:
        mass: Of the whole robot, in [kg].
        arm_joints: Joints an arm.
        parallelogram: Whether plates are links of their own, `geared`, or not.
        leg: Lengths of a leg.
        sole: The left sole.
        torso: Lengths of torso, neck and head.
        arm: Lengths of an arm.
    """

    mass: float
    arm_joints: Literal[5, 6, 7]
    parallelogram: Literal["serial", "geared"]
    leg: FlowLeg
    sole: Sole
    torso: FlowTorso
    arm: FlowArm

    def links(self) -> tuple[Link, ...]:
        """Pelvis, left leg, right leg, torso, left arm, right arm, head."""
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
        return (trunk, *legs, *self._torso_links(), *arms, *self._head_links())

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
