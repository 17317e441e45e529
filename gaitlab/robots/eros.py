"""EROS: 52 cm, 20 joints, an aluminium soccer humanoid on 12.5 cm long feet.

Height, joints and their order are published; lengths, masses, limits and servos are not. What is
assumed says so in its source.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import pi
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from gaitlab.kinematics.arm import ArmLengths, hand_branches, hand_pose
from gaitlab.kinematics.head import HeadLengths, camera_pose, pointing_joints
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.model import SIDES, Joint, Shape, Side, Tree
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, head_limb, leg_limb, point_limb
from gaitlab.model.link_table import HERE, Table, below, links, read_table, shares
from gaitlab.model.soles import Sole
from gaitlab.model.targets import angle, both_legs, held, six_joint_targets
from gaitlab.parameters import parameter

TREAD = 0.012  # m, thickness of the foot plate


# The foot of a real robot of this size, 51 cm and 3.1 kg: its sole is 127 x 80 mm with its centre
# 12.5 mm outside the ankle, so that 15 mm stay free between soles under hips 70 mm apart. EROS'
# hips are 84 mm apart, as DARwIn-OP's scaled to its height, and 29 mm are free: a robot whose soles
# lag and roll by 20 mm, as these do, could not walk on less.
_OP3 = "assumption: ROBOTIS OP3, the mesh of the foot in its published description"
_FOOT = "assumption: a foot in proportion to the height"
_TALL = "assumption: the parts add up to the published 52 cm"
_DARWIN = "assumption: DARwIn-OP's proportions scaled to 52 cm, rounded"
_ARM = "assumption: proportions of a robot of this height"
_HEAD = "assumption: total height 52 cm"


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
class LegGeometry(LegLengths):
    """Lengths of a leg."""

    hip_spacing: float = parameter(
        0.042, unit="m", low=0.0, high=1.0, doc="dy, trunk centre plane to the hip", source=_DARWIN
    )
    hip_drop: float = parameter(
        0.035, unit="m", low=0.0, high=1.0, doc="dz1, leg origin down to the hip", source=_DARWIN
    )
    thigh: float = parameter(
        0.105, unit="m", low=0.01, high=2.0, doc="dz3, hip to knee", source=_DARWIN
    )
    shank: float = parameter(
        0.105, unit="m", low=0.01, high=2.0, doc="dz4, knee to ankle", source=_DARWIN
    )


@dataclass(frozen=True, kw_only=True)
class ArmGeometry(ArmLengths):
    """Lengths of an arm."""

    shoulder_spacing: float = parameter(
        0.090, unit="m", low=0.0, high=1.0, doc="dy, trunk centre plane to the arm", source=_ARM
    )
    shoulder_drop: float = parameter(
        0.018,
        unit="m",
        low=0.0,
        high=0.5,
        doc="dz1, shoulder pitch axis down to the roll axis",
        source=_ARM,
    )
    upper_arm: float = parameter(
        0.075, unit="m", low=0.01, high=1.0, doc="dz2, roll axis to the elbow", source=_ARM
    )
    forearm: float = parameter(
        0.120, unit="m", low=0.01, high=1.0, doc="dz3, elbow to the hand", source=_ARM
    )


@dataclass(frozen=True, kw_only=True)
class HeadGeometry(HeadLengths):
    """Lengths of neck and head."""

    neck: float = parameter(
        0.030, unit="m", low=0.0, high=0.5, doc="d1, neck base to the tilt axis", source=_HEAD
    )
    camera: float = parameter(
        0.045, unit="m", low=0.001, high=0.5, doc="d2, tilt axis to the camera", source=_HEAD
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
    """What arms and head hold while the legs walk; the right arm mirrors the left."""

    shoulder_pitch: float = angle(0.3, low=-pi, high=pi, doc="positive swings the arm back")
    shoulder_roll: float = angle(0.15, low=-0.26, high=2.09, doc="positive lifts it sideways")
    elbow: float = angle(-0.7, low=-2.44, high=0.0, doc="negative bends it forward")
    head_pan: float = angle(0.0, low=-2.09, high=2.09, doc="positive looks left")
    head_tilt: float = angle(0.0, low=-0.52, high=1.57, doc="positive looks down")


@dataclass(frozen=True, kw_only=True)
class Robot:
    """EROS; the trunk link frame is the legs' common origin, above and between the hips."""

    name: ClassVar[str] = "eros"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")
    table: ClassVar[Table] = read_table(Path(__file__).with_name("eros_links.csv"))

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
        """Links of `eros_links.csv`: trunk, left leg, right leg, left arm, right arm, head."""
        return Tree(tuple(links(self.table, self._shapes(), shares(self.table, self.mass))))

    def _shapes(self) -> Mapping[str, Shape]:
        """Where the links hang, and boxes of plausible sizes."""
        leg, arm, torso, neck, sole = self.leg, self.arm, self.torso, self.head.neck, self.sole
        x, y, z = sole.centre
        shoulder, drop = torso.shoulder_height, arm.shoulder_drop
        top, tall = shoulder + torso.neck_height, self.head.camera + torso.crown
        return {
            "trunk": Shape(HERE, (0.085, 0.125, top + 0.012), (0.0, 0.0, 0.5 * top - 0.006)),
            "pelvis": Shape(
                (0.0, leg.hip_spacing, -leg.hip_drop), (0.045, 0.045, 0.030), (0.0, 0.0, 0.008)
            ),
            "hip": Shape(HERE, (0.075, 0.045, 0.040), (-0.010, 0.0, 0.0)),
            "thigh": Shape(HERE, (0.045, 0.048, 0.85 * leg.thigh), below(leg.thigh / 2)),
            "shank": Shape(
                below(leg.thigh), (0.040, 0.045, 0.80 * leg.shank), below(leg.shank / 2)
            ),
            "ankle": Shape(below(leg.shank), (0.070, 0.045, 0.036)),
            "foot": Shape(HERE, (sole.length, sole.width, TREAD), (x, y, z + TREAD / 2)),
            "shoulder": Shape(
                (0.0, 0.0, shoulder),
                (0.040, 0.035, 0.040),
                (0.0, 0.9 * arm.shoulder_spacing, -drop / 2),
            ),
            "upper_arm": Shape(
                (0.0, arm.shoulder_spacing, -drop),
                (0.036, 0.036, arm.upper_arm),
                below(arm.upper_arm / 2),
            ),
            "forearm": Shape(
                below(arm.upper_arm), (0.030, 0.030, arm.forearm), below(arm.forearm / 2)
            ),
            "neck": Shape((0.0, 0.0, top), (0.030, 0.030, neck), (0.0, 0.0, neck / 2)),
            "head": Shape((0.0, 0.0, neck), (0.070, 0.085, tall), (0.0, 0.0, tall / 2)),
        }

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, arms and head held, in [rad]. Shape (n, 20).

        Raises:
            Infeasible: If a sole is out of reach or a leg joint beyond its limit.
        """
        origin, joints = np.array([0.0, 0.0, self.hip_offset()]), self.tree.joints

        def leg_targets(index: int) -> np.ndarray:
            limits = joints[6 * index : 6 * index + 6]
            return six_joint_targets(self.leg_of(SIDES[index]), limits, feet, index, origin)

        return both_legs(leg_targets, held(self.posture, joints[12:]))

    def leg_of(self, side: Side) -> Leg:
        """Kinematics of a leg in the trunk's frame."""
        return Leg(geometry=self.leg, ankle_height=self.sole.height, side=side)

    def limbs(self) -> Mapping[str, Limb]:
        """Legs, arms and head, in the frames of [Pristovani2018]."""
        joints = self.tree.joints
        pose, pointing = partial(camera_pose, self.head), partial(pointing_joints, self.head)
        limbs = [head_limb(pose, pointing, joints[18:])]
        for k, side in enumerate(SIDES):
            limbs.append(leg_limb(self.leg_of(side), joints[6 * k : 6 * k + 6], "the trunk"))
            limbs.append(self._arm_limb(side, joints[12 + 3 * k : 15 + 3 * k]))
        return {limb.name: limb for limb in limbs}

    def _arm_limb(self, side: Side, joints: Sequence[Joint]) -> Limb:
        def inverse(point: np.ndarray) -> np.ndarray:
            found = hand_branches(self.arm, point, side)
            return found[np.isfinite(found).all(axis=-1)]

        return point_limb(
            f"{side}_arm",
            joints,
            "the hand, in the frame of the arms' origin",
            forward=lambda position: hand_pose(self.arm, position, side),
            inverse=inverse,
        )
