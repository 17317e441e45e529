"""NAO H25 V4.0: 57 cm, 5.195 kg, 24 joints without the hands; masses and lengths as published.

Each link is the uniform box that has its published mass, centre of mass and moments of inertia
about the link's axes; the products of inertia are left out. Both hips turn on one motor: a pose
that needs two yaw-pitch angles is refused.

References:
    naoV40: Aldebaran, H25 V4.0 links, joints and masses; the same numbers in ros-naoqi/nao_robot.
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.slanted_leg import SlantedLeg
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model import SIDES, Axis, Box, Joint, Link, Side, Tree, Vector
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb
from gaitlab.model.link_table import HERE, Row, read_table
from gaitlab.model.soles import Sole
from gaitlab.model.targets import angle, both_legs, held, six_joint_targets
from gaitlab.model.tree import box_of_inertia
from gaitlab.parameters import parameter

COUPLED = 1e-6  # rad by which the two hip yaw-pitch angles may differ, for rounding only

_NAO = "published: Aldebaran H25 V4.0"


LINKS, JOINTS, FORCE_SENSORS = (
    read_table(Path(__file__).with_name(f"nao_v40_{name}.csv"))
    for name in ("links", "joints", "force_sensors")
)


@dataclass(frozen=True, kw_only=True)
class NaoSole(Sole):
    """Sole of NAO: its bounding box, farther out than in."""

    length: float = parameter(
        0.157, unit="m", low=0.02, high=0.4, doc="sole along x of the foot", source=_NAO
    )
    width: float = parameter(
        0.088, unit="m", low=0.02, high=0.3, doc="sole along y of the foot", source=_NAO
    )
    heel: float = parameter(
        0.047, unit="m", low=0.0, high=0.3, doc="ankle axis to the heel edge", source=_NAO
    )
    height: float = parameter(
        0.04519, unit="m", low=0.01, high=0.2, doc="ankle axis over the sole", source=_NAO
    )
    outward: float = parameter(
        0.006, unit="m", low=-0.05, high=0.05, doc="sole's centre outside the ankle", source=_NAO
    )
    kind: Literal["flat", "studs"] = parameter(
        "flat",
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption: the box around a sole that is really rounded",
    )

    def sensors(self, foot: int) -> np.ndarray:
        """The four FSRs in the ankle frame, in [m]. Shape (4, 2)."""
        table = FORCE_SENSORS[4 * foot : 4 * foot + 4]
        return np.array([[float(row["x_m"]), float(row["y_m"])] for row in table])


@dataclass(frozen=True, kw_only=True)
class NaoLeg:
    """Lengths of the legs."""

    hip_spacing: float = parameter(
        0.050, unit="m", low=0.01, high=0.5, doc="trunk centre plane to the hip", source=_NAO
    )
    hip_drop: float = parameter(
        0.085, unit="m", low=0.0, high=0.5, doc="trunk frame down to the hip", source=_NAO
    )
    thigh: float = parameter(
        0.100, unit="m", low=0.01, high=1.0, doc="L2, hip to knee", source=_NAO
    )
    tibia: float = parameter(
        0.1029, unit="m", low=0.01, high=1.0, doc="L1, knee to ankle; in print 0.1", source=_NAO
    )


@dataclass(frozen=True, kw_only=True)
class NaoPosture:
    """What arms and head hold while the legs walk; the right arm mirrors the left."""

    shoulder_pitch: float = angle(1.4, low=-2.0, high=2.0, doc="positive lowers the arm")
    shoulder_roll: float = angle(0.15, low=-0.3, high=1.3, doc="positive is outwards")
    elbow_yaw: float = angle(-1.2, low=-2.0, high=2.0, doc="turns the bent forearm")
    elbow_roll: float = angle(-0.5, low=-1.5, high=-0.04, doc="negative bends it")


@dataclass(frozen=True, kw_only=True)
class Robot:
    """NAO; the trunk link frame is the torso's, over and between the hips."""

    name: ClassVar[str] = "nao"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")

    mass: float = parameter(
        5.195402,
        unit="kg",
        low=1.0,
        high=20.0,
        doc="mass of the robot, over all links in the published shares",
        source=_NAO,
    )
    leg: NaoLeg = field(default_factory=NaoLeg)
    sole: NaoSole = field(default_factory=NaoSole)
    posture: NaoPosture = field(default_factory=NaoPosture)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return self.leg.hip_drop

    @cached_property
    def tree(self) -> Tree:
        """Links: trunk, left leg, right leg, left arm, right arm, head."""
        table = {row["link"]: row for row in LINKS}
        scale = self.mass / sum(float(row["mass_kg"]) for row in LINKS)
        joints = [row for row in JOINTS[2:] + JOINTS[:2] if row["child"] in table]
        trunk = _link(table["torso"], scale, None, HERE, None)
        return Tree((trunk, *(self._jointed(row, table[row["child"]], scale) for row in joints)))

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, arms and head held, in [rad]. Shape (n, 24).

        Raises:
            Infeasible: If a sole is out of reach, a leg joint beyond its limit, or the hips would
                have to turn by two different angles.
        """
        joints = self.tree.joints

        def leg_targets(index: int) -> np.ndarray:
            leg, limits = self.leg_of(SIDES[index], self.sole.height), joints[6 * index :][:6]
            hip = np.array([0.0, self._hip(SIDES[index]), 0.0])
            return six_joint_targets(leg, limits, feet, index, hip)

        targets = both_legs(leg_targets, held(self.posture, joints[12:]))
        _require_coupled(targets[:, 0], targets[:, 6])
        return targets

    def leg_of(self, side: Side, ankle_height: float = 0.0) -> SlantedLeg:
        """Kinematics of a leg from the hip joint to the ankle, or to a sole below it, in [m]."""
        lengths = self.leg
        return SlantedLeg(
            thigh=lengths.thigh, tibia=lengths.tibia, ankle_height=ankle_height, side=side
        )

    def _hip(self, side: str) -> float:
        """Lateral place of the hip, in [m]."""
        return self.leg.hip_spacing if side == "left" else -self.leg.hip_spacing

    def limbs(self) -> Mapping[str, Limb]:
        """Both legs from the hip joint to the ankle, as in [Shaari2015]."""
        return {f"{side}_leg": self._limb(k, side) for k, side in enumerate(SIDES)}

    def _limb(self, index: int, side: Side) -> Limb:
        leg = self.leg_of(side)

        def inverse(target: np.ndarray, heading: float) -> np.ndarray:
            return leg.pose_joints(homogeneous(axis_rotation("z", np.array(heading)), target)[None])

        return Limb(
            name=f"{side}_leg",
            joints=self.tree.joints[6 * index : 6 * index + 6],
            target="the ankle seen from the hip joint, the foot level",
            forward=leg.sole_pose,
            inverse=inverse,
        )

    def _jointed(self, row: Row, link: Row, scale: float) -> Link:
        name = _snake(row["joint"])
        joint = Joint(
            name=name,
            axis=_axis(row["axis"]),
            lower=float(row["lower_rad"]),
            upper=float(row["upper_rad"]),
            servo=_servo(name),
        )
        return _link(link, scale, _part_name(row["parent"]), self._origin(name, row), joint)

    def _origin(self, joint: str, row: Row) -> Vector:
        """Joint frame in its parent's, in [m]; the legs' lengths are parameters."""
        side, _, what = joint.partition("_")
        own: dict[str, Vector] = {
            "hip_yaw_pitch": (
                0.0,
                self._hip(side),
                -self.leg.hip_drop,
            ),
            "knee_pitch": (0.0, 0.0, -self.leg.thigh),
            "ankle_pitch": (0.0, 0.0, -self.leg.tibia),
        }
        return own.get(what, (float(row["x_m"]), float(row["y_m"]), float(row["z_m"])))


def _require_coupled(left: np.ndarray, right: np.ndarray) -> None:
    apart = np.abs(left - right) > COUPLED
    if not apart.any():
        return
    tick = int(np.argmax(apart))
    reason = (
        f"left_hip_yaw_pitch would have to turn to {left[tick]:.3f} rad and right_hip_yaw_pitch to "
        f"{right[tick]:.3f} rad, but one motor turns both; walk straight with trunk_pitch 0"
    )
    raise Infeasible(limb="left_leg", tick=tick, reason=reason)


_PARTS = {"torso": "trunk", "ankle_pitch": "ankle", "ankle": "foot", "wrist": "hand"}


def _snake(name: str) -> str:
    """`LHipYawPitch` to `left_hip_yaw_pitch`, `HeadYaw` to `head_yaw`."""
    sided = re.match(r"([LR])(?=[A-Z])|([lr])_", name)
    side = {"l": "left_", "r": "right_"}[sided[0][0].lower()] if sided else ""
    rest = name[sided.end() :] if sided else name
    return side + re.sub(r"(?<!^)(?=[A-Z])", "_", rest).lower()


def _part_name(link: str) -> str:
    """Our word for a link of [naoV40]: `l_ankle`, which carries the sole, is `left_foot`."""
    side, underscore, part = _snake(link).partition("_")
    if not underscore:
        return _PARTS.get(side, side)
    return f"{side}_{_PARTS.get(part, part)}"


def _axis(text: str) -> Axis:
    x, y, z = (float(part) for part in text.split())
    if y and z:  # the slanted hips; print has six digits of the square root of a half
        return (0.0, float(np.sign(y)) * sqrt(0.5), float(np.sign(z)) * sqrt(0.5))
    return "x" if x else "y" if y else "z"


def _servo(joint: str) -> str:
    leg = any(part in joint for part in ("hip", "knee", "ankle"))
    if not leg:
        return "nao_arm"
    slow = joint.endswith(("roll", "yaw_pitch"))
    return "nao_leg_roll" if slow else "nao_leg_pitch"


def _link(row: Row, scale: float, parent: str | None, origin: Vector, joint: Joint | None) -> Link:
    mass = float(row["mass_kg"])
    moments = (float(row["ixx"]), float(row["iyy"]), float(row["izz"]))
    centre = (float(row["com_x_m"]), float(row["com_y_m"]), float(row["com_z_m"]))
    return Link(
        name=_part_name(row["link"]),
        parent=parent,
        origin=origin,
        joint=joint,
        mass=scale * mass,
        box=Box(size=box_of_inertia(mass, moments), centre=centre),
    )
