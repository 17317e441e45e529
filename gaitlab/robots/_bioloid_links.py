"""Links of the Bioloid: what each weighs and how far its joint turns; all servos are alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitlab.kinematics.bioloid_geometry import BioloidLeg, UpperBody
from gaitlab.model import Box, Link, Part, limb
from gaitlab.model.soles import Sole
from gaitlab.parameters import parameter

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
_HERE = (0.0, 0.0, 0.0)
_AX_12 = (0.050, 0.032, 0.040)  # m, the servo's own size
_WEIGHT = "assumption: the parts add up to the published 3 kg"


def _kilograms(default: float, high: float, doc: str, source: str) -> float:
    value: float = parameter(default, unit="kg", low=0.0, high=high, doc=doc, source=source)
    return value


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
class BioloidSkeleton:
    """What the links are made from, each a parameter of the robot.

    Attributes:
        leg: Lengths of a leg.
        sole: The left sole.
        upper_body: Lengths above the hips.
        masses: Of servos, frames, electronics and costume.
    """

    leg: BioloidLeg
    sole: Sole
    upper_body: UpperBody
    masses: Masses

    def links(self) -> tuple[Link, ...]:
        """Trunk, left leg, right leg, waist, left arm, right arm, head."""
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
        return (trunk, *legs, *self._waist_links(), *arms, *self._head_links())

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


def _below(distance: float) -> Vector:
    return (0.0, 0.0, -distance)


def _mirrored(left: float, side: Side) -> float:
    return left if side == "left" else -left


def _turned_over(part: Part) -> Part:
    """The same part of the right arm: limits about x and z mirror."""
    lower, upper = part.limits
    return part if part.axis == "y" else part._replace(limits=(-upper, -lower))
