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

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi
from typing import ClassVar, Literal

import numpy as np

from gaitlab.kinematics.dh_arm import DhArm
from gaitlab.kinematics.dh_head import DhHead
from gaitlab.kinematics.flow_geometry import FlowArm, FlowLeg, FlowTorso, metres
from gaitlab.kinematics.leg import Leg
from gaitlab.kinematics.parallelogram import parallelogram_joints, plate_joints
from gaitlab.model import Coupling, Tree, both_legs, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, arm_limb, head_limb, leg_limb
from gaitlab.model.soles import Sole, require_parallel
from gaitlab.parameters import parameter
from gaitlab.robots._flow_links import HIP_PITCH, SHANK, SIDES, FlowSkeleton, Side


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
class FlowPosture:
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
    posture: FlowPosture = field(default_factory=FlowPosture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: pelvis, left leg, right leg, torso, left arm, right arm, head."""
        skeleton = FlowSkeleton(
            mass=self.mass,
            arm_joints=self.arm_joints,
            parallelogram=self.parallelogram,
            leg=self.leg,
            sole=self.sole,
            torso=self.torso,
            arm=self.arm,
        )
        return Tree(skeleton.links())

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
