"""EROS: 52 cm, 20 joints, an aluminium soccer humanoid on 12.5 cm long feet.

Height, joints and their order are published; lengths, masses, limits and servos are not. What is
assumed says so in its source.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import pi
from typing import ClassVar, Literal

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.arm import ArmGeometry
from gaitlab.kinematics.head import HeadGeometry, camera_pose, pointing_joints
from gaitlab.kinematics.leg import Leg, LegGeometry
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model import Box, Link, Part, Tree, both_legs, limb, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, head_limb, leg_limb, short_arm_limb
from gaitlab.model.soles import Sole
from gaitlab.parameters import parameter

Side = Literal["left", "right"]
Axis = Literal["x", "y", "z"]
Vector = tuple[float, float, float]
SIDES: tuple[Side, Side] = ("left", "right")

# Link masses in [kg] of a robot of 3.50 kg, an assumption; parameter `mass` scales them together.
MASSES = {
    **{"trunk": 0.95, "neck": 0.03, "head": 0.12},
    **{"shoulder": 0.06, "upper_arm": 0.12, "forearm": 0.12},
    **{"pelvis": 0.10, "hip": 0.18, "thigh": 0.22, "shank": 0.12, "ankle": 0.16, "foot": 0.12},
}
SINGLE = ("trunk", "neck", "head")  # links that come once; all others come left and right
TABLE_MASS = sum(mass if name in SINGLE else 2.0 * mass for name, mass in MASSES.items())

# Joint limits in degrees, lower and upper, an assumption; the right arm's roll is mirrored.
LIMITS_DEG = {
    "hip_yaw": (-45.0, 45.0),
    "hip_roll": (-40.0, 40.0),
    "hip_pitch": (-100.0, 35.0),
    "knee": (0.0, 130.0),
    "ankle_pitch": (-70.0, 60.0),
    "ankle_roll": (-40.0, 40.0),
    "shoulder_pitch": (-180.0, 180.0),
    "shoulder_roll": (-15.0, 120.0),
    "elbow": (-140.0, 0.0),
    "head_pan": (-120.0, 120.0),
    "head_tilt": (-30.0, 90.0),
}
TREAD = 0.012  # m, thickness of the foot plate


# The foot of a real robot of this size, 51 cm and 3.1 kg: its sole is 127 x 80 mm with its centre
# 12.5 mm outside the ankle, so that 15 mm stay free between soles under hips 70 mm apart. EROS'
# hips are 84 mm apart, as DARwIn-OP's scaled to its height, and 29 mm are free: a robot whose soles
# lag and roll by 20 mm, as these do, could not walk on less.
_OP3 = "assumption: ROBOTIS OP3, the mesh of the foot in its published description"
_FOOT = "assumption: a foot in proportion to the height"
_TALL = "assumption: the parts add up to the published 52 cm"


@dataclass(frozen=True, kw_only=True)
class ErosSole(Sole):
    """Sole of EROS."""

    length: float = parameter(
        0.125, unit="m", low=0.02, high=0.4, doc="sole along x of the foot", source=_FOOT
    )
    width: float = parameter(
        0.080, unit="m", low=0.02, high=0.3, doc="sole along y of the foot", source=_OP3
    )
    outward: float = parameter(
        0.0125, unit="m", low=-0.05, high=0.05, doc="sole's centre outside the ankle", source=_OP3
    )
    heel: float = parameter(
        0.055, unit="m", low=0.0, high=0.3, doc="ankle axis to the heel edge", source=_FOOT
    )
    height: float = parameter(
        0.038, unit="m", low=0.01, high=0.2, doc="dz6, ankle axis over the sole", source=_TALL
    )
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the paper mentions no studs; chosen after walking trials on both kinds",
    )


@dataclass(frozen=True, kw_only=True)
class TorsoGeometry:
    """Lengths above the leg origin."""

    shoulder_height: float = parameter(
        0.110, unit="m", low=0.02, high=1.0, doc="leg origin to the shoulder axis", source=_TALL
    )
    neck_height: float = parameter(
        0.022, unit="m", low=0.0, high=0.5, doc="shoulder axis to the neck base", source=_TALL
    )
    crown: float = parameter(
        0.030, unit="m", low=0.0, high=0.3, doc="camera to the top of the head", source=_TALL
    )


@dataclass(frozen=True, kw_only=True)
class ErosPosture:
    """What arms and head hold while the legs walk."""

    shoulder_pitch: float = parameter(
        0.3, unit="rad", low=-pi, high=pi, doc="positive swings the arm back", source="assumption"
    )
    shoulder_roll: float = parameter(
        0.15,
        unit="rad",
        low=-0.26,
        high=2.09,
        doc="positive lifts it sideways",
        source="assumption",
    )
    elbow: float = parameter(
        -0.7, unit="rad", low=-2.44, high=0.0, doc="negative bends it forward", source="assumption"
    )
    head_pan: float = parameter(
        0.0, unit="rad", low=-2.09, high=2.09, doc="positive looks left", source="assumption"
    )
    head_tilt: float = parameter(
        0.0, unit="rad", low=-0.52, high=1.57, doc="positive looks down", source="assumption"
    )

    def joints(self) -> tuple[float, ...]:
        """Joint positions of the left arm, the right arm and the head, in [rad]."""
        left = (self.shoulder_pitch, self.shoulder_roll, self.elbow)
        right = (self.shoulder_pitch, -self.shoulder_roll, self.elbow)
        return (*left, *right, self.head_pan, self.head_tilt)


@dataclass(frozen=True, kw_only=True)
class Robot:
    """EROS; the trunk link frame is the legs' common origin, above and between the hips."""

    name: ClassVar[str] = "eros"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")

    mass: float = parameter(
        3.50,
        unit="kg",
        low=0.5,
        high=20.0,
        doc="mass of the robot, over all links in fixed shares",
        source="assumption: another EROS of 56 cm weighs 3.8 kg; try 3.0 to 4.0",
    )
    self_collision: bool = parameter(
        False,
        unit="-",
        doc="whether arms, trunk and thighs collide too; the two lower legs always do",
        source="assumption: they do not meet in a walk",
    )
    leg: LegGeometry = field(default_factory=LegGeometry)
    sole: ErosSole = field(default_factory=ErosSole)
    torso: TorsoGeometry = field(default_factory=TorsoGeometry)
    arm: ArmGeometry = field(default_factory=ArmGeometry)
    head: HeadGeometry = field(default_factory=HeadGeometry)
    posture: ErosPosture = field(default_factory=ErosPosture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: trunk, left leg, right leg, left arm, right arm, head; box sizes are plausible."""
        legs = (link for side in SIDES for link in self._leg_links(side))
        arms = (link for side in SIDES for link in self._arm_links(side))
        top = self.torso.shoulder_height + self.torso.neck_height
        trunk = Link(
            name="trunk",
            parent=None,
            origin=_HERE,
            joint=None,
            mass=self._mass("trunk"),
            box=Box(size=(0.085, 0.125, top + 0.012), centre=(0.0, 0.0, 0.5 * top - 0.006)),
        )
        return Tree((trunk, *legs, *arms, *self._head_links()))

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, arms and head held, in [rad]. Shape (n, 20).

        Raises:
            Infeasible: If a sole is out of reach or a leg joint beyond its limit.
        """
        legs = both_legs(lambda index: self._leg_targets(feet, index, SIDES[index]))
        held = np.tile(self.posture.joints(), (len(feet.position), 1))
        return np.concatenate([*legs, held], axis=1)

    def limbs(self) -> Mapping[str, Limb]:
        """Legs, arms and head, in the frames of [Pristovani2018]."""
        joints = self.tree.joints
        found = [
            head_limb(
                partial(camera_pose, self.head), partial(pointing_joints, self.head), joints[18:]
            )
        ]
        for k, side in enumerate(SIDES):
            leg = Leg(geometry=self.leg, ankle_height=self.sole.height, side=side)
            found.append(leg_limb(leg, joints[6 * k : 6 * k + 6], "the trunk"))
            found.append(short_arm_limb(self.arm, joints[12 + 3 * k : 15 + 3 * k], side))
        return {each.name: each for each in found}

    def _leg_targets(self, feet: FeetPoses, index: int, side: Side) -> np.ndarray:
        level = axis_rotation("y", -feet.trunk_pitch) @ axis_rotation("z", feet.heading[:, index])
        position = feet.position[:, index] - [0.0, 0.0, self.hip_offset()]
        joints = self._leg_joints(homogeneous(level, position), index, side)
        # Only the added part gives way to the limit; the level sole's own angle has been checked.
        added = feet.knee_only[:, index] * joints[:, 2] + feet.ankle_pitch[:, index]
        ankle = self.tree.joints[6 * index + 4]
        joints[:, 4] = np.clip(joints[:, 4] + added, ankle.lower, ankle.upper)
        return joints

    def _leg_joints(self, pose: np.ndarray, index: int, side: Side) -> np.ndarray:
        """Joints of a leg; the first instant out of reach or beyond a limit is refused."""
        leg = Leg(geometry=self.leg, ankle_height=self.sole.height, side=side)
        limits = self.tree.joints[6 * index : 6 * index + 6]
        try:
            joints = leg.pose_joints(pose)
        except Infeasible as problem:
            require_limits(problem.limb, limits, leg.pose_joints(pose[: problem.tick]))
            raise
        require_limits(f"{side}_leg", limits, joints)
        return joints

    def _mass(self, link: str) -> float:
        return MASSES[link] * self.mass / TABLE_MASS

    def _part(
        self, name: str, joint: str, axis: Axis, origin: Vector, size: Vector, centre: Vector
    ) -> Part:
        lower, upper = np.radians(LIMITS_DEG[joint]).tolist()
        box = Box(size=size, centre=centre)
        return Part(name, joint, axis, (lower, upper), origin, self._mass(name), box)

    def _leg_links(self, side: Side) -> Iterator[Link]:
        part, sole, thigh, shank = self._part, self.sole, self.leg.thigh, self.leg.shank
        hip = (0.0, _mirrored(self.leg.hip_spacing, side), -self.leg.hip_drop)
        x, y, z = sole.centre_of(SIDES.index(side))
        upper, lower = (0.045, 0.048, 0.85 * thigh), (0.040, 0.045, 0.80 * shank)
        tread = (sole.length, sole.width, TREAD)
        parts = (
            part("pelvis", "hip_yaw", "z", hip, (0.045, 0.045, 0.030), (0.0, 0.0, 0.008)),
            part("hip", "hip_roll", "x", _HERE, (0.075, 0.045, 0.040), (-0.010, 0.0, 0.0)),
            part("thigh", "hip_pitch", "y", _HERE, upper, _below(thigh / 2)),
            part("shank", "knee", "y", _below(thigh), lower, _below(shank / 2)),
            part("ankle", "ankle_pitch", "y", _below(shank), (0.070, 0.045, 0.036), _HERE),
            part("foot", "ankle_roll", "x", _HERE, tread, (x, y, z + TREAD / 2)),
        )
        return limb(parts, parent="trunk", servo="mx_64", prefix=f"{side}_")

    def _arm_links(self, side: Side) -> Iterator[Link]:
        part, arm, upper, forearm = self._part, self.arm, self.arm.upper_arm, self.arm.forearm
        across = _mirrored(arm.shoulder_spacing, side)
        top, roll = (0.0, 0.0, self.torso.shoulder_height), (0.0, across, -arm.shoulder_drop)
        inner = (0.0, 0.9 * across, -arm.shoulder_drop / 2)
        thick, thin = (0.036, 0.036, upper), (0.030, 0.030, forearm)
        arm_part = part("upper_arm", "shoulder_roll", "x", roll, thick, _below(upper / 2))
        parts = (
            part("shoulder", "shoulder_pitch", "y", top, (0.040, 0.035, 0.040), inner),
            arm_part if side == "left" else _turned_over(arm_part),
            part("forearm", "elbow", "y", _below(upper), thin, _below(forearm / 2)),
        )
        return limb(parts, parent="trunk", servo="mx_28", prefix=f"{side}_")

    def _head_links(self) -> Iterator[Link]:
        part, neck = self._part, self.head.neck
        base = (0.0, 0.0, self.torso.shoulder_height + self.torso.neck_height)
        tall = self.head.camera + self.torso.crown
        parts = (
            part("neck", "head_pan", "z", base, (0.030, 0.030, neck), _below(-neck / 2)),
            part("head", "head_tilt", "y", _below(-neck), (0.070, 0.085, tall), _below(-tall / 2)),
        )
        return limb(parts, parent="trunk", servo="mx_28")


_HERE = (0.0, 0.0, 0.0)


def _below(distance: float) -> Vector:
    return (0.0, 0.0, -distance)


def _mirrored(left: float, side: Side) -> float:
    return left if side == "left" else -left


def _turned_over(part: Part) -> Part:
    """The same part on the other side of a joint that turns outwards: its limits mirror."""
    lower, upper = part.limits
    return part._replace(limits=(-upper, -lower))
