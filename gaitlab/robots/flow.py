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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.dh import DhArm, DhHead
from gaitlab.kinematics.parallelogram import parallelogram_joints, plate_joints
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.model import SIDES, Coupling, Joint, Shape, Side, Tree, Vector, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, head_limb, leg_limb, point_limb
from gaitlab.model.link_table import HERE, Table, below, links, read_table, shares
from gaitlab.model.soles import Sole
from gaitlab.model.targets import angle, both_legs, held
from gaitlab.parameters import parameter

TREAD = 0.015  # m, thickness of the foot plate
BONE = 0.050  # m, breadth of thigh, shank and arm
_TALL = "assumption: the parts add up to the published 110 cm; equal leg links follow 2 d4 in print"


def _metres(default: float, doc: str, low: float = 0.01) -> float:
    """A length in [m] of at least `low`, as a field of a dataclass."""
    value: float = parameter(default, unit="m", low=low, high=2.0, doc=doc, source=_TALL)
    return value


@dataclass(frozen=True, kw_only=True)
class FlowLeg(LegLengths):
    """Lengths of the leg."""

    hip_spacing: float = _metres(0.085, "dy, pelvis centre plane to the hip", low=0.0)
    hip_drop: float = _metres(0.060, "dz1, pelvis origin down to the hip", low=0.0)
    thigh: float = _metres(0.230, "l1, hip to knee")
    shank: float = _metres(0.230, "l2, knee to ankle")


@dataclass(frozen=True, kw_only=True)
class FlowArm:
    """Lengths of the arm."""

    spacing: float = _metres(0.160, "body centre plane to the shoulder", low=0.0)
    rise: float = _metres(0.0, "d1, arm base up to the shoulder's centre", low=0.0)
    upper_arm: float = _metres(0.190, "d3, shoulder to elbow")
    forearm: float = _metres(0.210, "d5, elbow to the tip; with a wrist, the hand is part of it")
    hand: float = _metres(0.060, "d7, wrist to the tip, for an arm of 6 or 7 joints")


@dataclass(frozen=True, kw_only=True)
class FlowTorso:
    """Lengths above the pelvis origin."""

    waist_height: float = _metres(0.060, "pelvis origin to the waist")
    shoulder_height: float = _metres(0.250, "waist to the shoulder line")
    neck_height: float = _metres(0.040, "shoulder line to the neck base", low=0.0)
    neck: float = _metres(0.050, "d, neck base to the tilt axis", low=0.0)
    eyes: float = _metres(0.070, "a, tilt axis to the eyes")
    crown: float = _metres(0.050, "eyes to the top of the head", low=0.0)


@dataclass(frozen=True, kw_only=True)
class FlowSole(Sole):
    """Sole of FLoW."""

    length: float = _metres(0.200, "sole along x of the foot")
    width: float = _metres(0.110, "sole along y of the foot")
    heel: float = _metres(0.085, "ankle axis to the heel edge", low=0.0)
    height: float = _metres(0.060, "dz6, ankle axis over the sole")
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the paper does not describe the sole",
    )


@dataclass(frozen=True, kw_only=True)
class FlowPosture:
    """What waist, arms and head hold while the legs walk; both arms alike."""

    shoulder_lift: float = angle(0.2, low=0.0, high=2.79, doc="positive lifts the arm")
    shoulder_turn: float = angle(1.2, low=-pi, high=pi, doc="0 lifts forward, pi/2 out")
    elbow: float = angle(0.5, low=0.0, high=2.44, doc="positive bends the elbow")


@dataclass(frozen=True, kw_only=True)
class Robot:
    """FLoW; the trunk link is the pelvis, its frame the legs' common origin."""

    name: ClassVar[str] = "flow"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")
    table: ClassVar[Table] = read_table(Path(__file__).with_name("flow_links.csv"))

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
    posture: FlowPosture = field(default_factory=FlowPosture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links of `flow_links.csv`: pelvis, left and right leg, torso, both arms, head."""
        arm = [row["link"] for row in self.table if row["limb"] == "arm"]
        table = [
            row
            for row in self.table
            if row["legs"] in ("", self.parallelogram) and row["link"] not in arm[self.arm_joints :]
        ]
        return Tree(tuple(links(table, self._shapes(), self._masses())))

    def _masses(self) -> Mapping[str, float]:
        """Of the links, in [kg]."""
        masses, wrist = shares(self.table, self.mass), self.arm_joints - 4
        if self.parallelogram == "serial":
            masses["shank"] += masses["knee_plate"]
        return {**masses, **dict.fromkeys(("hand", "wrist", "palm"), masses["hand"] / wrist)}

    def _shapes(self) -> Mapping[str, Shape]:
        """Where the links hang, and boxes of plausible sizes."""
        leg, torso, arm, sole = self.leg, self.torso, self.arm, self.sole
        x, y, z = sole.centre
        trunk, skull = torso.shoulder_height + 0.02, torso.eyes + torso.crown
        base = torso.shoulder_height + torso.neck_height
        forearm = arm.forearm - (0.0 if self.arm_joints == 5 else arm.hand)
        return {
            "pelvis": Shape(HERE, (0.10, 0.20, 0.10)),
            "hip_yaw": Shape((0.0, leg.hip_spacing, -leg.hip_drop), (0.06, 0.06, 0.02)),
            "hip_roll": Shape(HERE, _cube(0.08)),
            "thigh": Shape(HERE, *_bone(leg.thigh)),
            "knee_plate": Shape(below(leg.thigh), _cube(0.06)),
            "shank": Shape(
                below(leg.thigh) if self.parallelogram == "serial" else HERE, *_bone(leg.shank)
            ),
            "ankle_plate": Shape(below(leg.shank), _cube(0.06)),
            "foot": Shape(HERE, (sole.length, sole.width, TREAD), (x, y, z + TREAD / 2)),
            "torso": Shape(
                (0.0, 0.0, torso.waist_height), (0.12, 0.22, trunk), (0.0, 0.0, trunk / 2)
            ),
            "shoulder": Shape((0.0, arm.spacing, torso.shoulder_height), _cube(0.05)),
            "shoulder_lift": Shape((0.0, 0.0, arm.rise), _cube(0.06)),
            "upper_arm": Shape(HERE, *_bone(arm.upper_arm)),
            "forearm": Shape(below(arm.upper_arm), *_bone(0.7 * forearm)),
            "hand": Shape(HERE, *_tip(forearm)),
            "wrist": Shape(below(forearm), _cube(0.03)),
            "palm": Shape(HERE, *_tip(arm.hand)),
            "neck": Shape((0.0, 0.0, base), (0.04, 0.04, torso.neck), (0.0, 0.0, torso.neck / 2)),
            "head": Shape((0.0, 0.0, torso.neck), (0.12, 0.12, skull), (0.0, 0.0, skull / 2)),
        }

    @property
    def couplings(self) -> tuple[Coupling, ...]:
        """What keeps the plates of geared legs parallel to the pelvis."""
        if self.parallelogram == "serial":
            return ()
        pairs = (("hip_pitch", "knee_plate"), ("shank_pitch", "ankle_pitch"))
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
        _require_parallel(feet)
        others = self.tree.joints[2 * self._leg_joints :]
        return both_legs(lambda index: self._leg_targets(feet, index), held(self.posture, others))

    @property
    def _leg_joints(self) -> int:
        return 6 if self.parallelogram == "serial" else 7

    def limbs(self) -> Mapping[str, Limb]:
        """Legs, as serial chains, arms and head, each in the frame of [Yanto]."""
        joints = replace(self, parallelogram="serial").tree.joints
        count, head = self.arm_joints, self.head_of()
        limbs = [
            leg_limb(self.leg_of(side), joints[6 * k : 6 * k + 6], "the pelvis")
            for k, side in enumerate(SIDES)
        ]
        for k, side in enumerate(SIDES):
            limbs.append(self._arm_limb(side, joints[13 + count * k : 13 + count * (k + 1)]))
        limbs.append(head_limb(head.pose, head.pointing, joints[-2:]))
        return {limb.name: limb for limb in limbs}

    def _arm_limb(self, side: Side, joints: Sequence[Joint]) -> Limb:
        """An arm whose elbow hangs as low as it can and whose wrist is straight."""
        arm, count = self.arm_of(side), len(joints)
        return point_limb(
            arm.name,
            joints,
            "the tip of the arm, in the frame of the shoulder",
            forward=lambda position: arm.pose(np.pad(position, (0, len(arm.rows) - count))),
            inverse=lambda point: arm.point_joints(point)[:, :count],
        )

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

    def _leg_targets(self, feet: FeetPoses, index: int) -> np.ndarray:
        side, count = SIDES[index], self._leg_joints
        position = feet.position[:, index] - [0.0, 0.0, self.hip_offset()]
        joints = self.leg_of(side).flat_joints(position, feet.heading[:, index])
        if self.parallelogram == "geared":
            joints = plate_joints(parallelogram_joints(joints))
        limits = self.tree.joints[count * index : count * (index + 1)]
        require_limits(f"{side}_leg", limits, joints)
        return joints


def _require_parallel(feet: FeetPoses) -> None:
    """Refuse a sole that is to pitch against the trunk, which parallelogram legs do not allow.

    Raises:
        Infeasible: Names the first such foot and instant, and what the gait asks for.
    """
    turned = {
        "trunk_pitch": np.abs(feet.trunk_pitch)[:, None] * np.ones((1, 2)),
        "ankle_pitch": np.abs(feet.ankle_pitch),
        "knee_only": np.abs(feet.knee_only),
    }
    for name, amount in turned.items():
        if np.any(amount > 0.0):
            tick, foot = (int(i) for i in np.argwhere(amount > 0.0)[0])
            reason = (
                f"the gait asks for {name} {amount[tick, foot]:.4f}; parallelograms keep the "
                "sole parallel to the pelvis, so it must be 0"
            )
            raise Infeasible(limb=f"{SIDES[foot]}_leg", tick=tick, reason=reason)


def _cube(edge: float) -> Vector:
    return (edge, edge, edge)


def _bone(length: float) -> tuple[Vector, Vector]:
    """Size and centre of a link that hangs down, a little short of the next joint."""
    return (BONE, BONE, 0.85 * length), below(length / 2.0)


def _tip(length: float) -> tuple[Vector, Vector]:
    """Size and centre of the last third of a link, out to its tip."""
    return (BONE, BONE, length / 3.0), below(length * 5.0 / 6.0)
