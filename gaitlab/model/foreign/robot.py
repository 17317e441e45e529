"""A foreign robot as gaitlab's own are: a dataclass of parameters, its tree, its joint targets.

The class is made from what was found, with a field a joint that is held, so that everything that
reads, varies, prints and names the parameters of a shipped robot does it for a foreign one.
"""

from __future__ import annotations

import dataclasses
import hashlib
import keyword
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.kinematics.axis_leg import AxisLeg, SolePoses
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model.foreign.leg import FoundLeg
from gaitlab.model.foreign.reduced import SOLE_LENGTHS, Reduced
from gaitlab.model.gait import FeetPoses, changes
from gaitlab.model.limbs import Limb
from gaitlab.model.link_table import SIDES
from gaitlab.model.servo import Servo
from gaitlab.model.soles import Sole
from gaitlab.model.targets import both_legs, require_limits
from gaitlab.model.tree import Joint, Tree
from gaitlab.parameters import canonical_json, parameter

MISPLACED = 1e-6  # m by which a sole may be off before it counts as out of reach
MISTURNED = 1e-5  # rad
LEAST_TRUNK = 0.1  # share of the trunk's mass that is left at least
DIGITS = 9  # of lengths, masses and angles that tell one robot from another


@dataclass(frozen=True, kw_only=True)
class ForeignRobot:
    """What every foreign robot can do; `robot_class` gives it the numbers of one.

    Attributes:
        name: What results call it.
        found: What the robot is, as its file has it.
        own_servos: Servos that are numbers of its file and no file of theirs, by name.
        servo_sources: Where those numbers come from, by name and parameter.
        posture_fields: Name of the posture's field of each joint that is held.
        feet: Names of the left and the right foot link.
        mass: Of the robot, in [kg].
        sole: Of the left foot.
        posture: Angles of the joints that are held, in [rad].
    """

    name: ClassVar[str]
    found: ClassVar[Reduced]
    own_servos: ClassVar[Mapping[str, Servo]]
    servo_sources: ClassVar[Mapping[str, Mapping[str, str]]]
    posture_fields: ClassVar[Mapping[str, str]]
    feet: ClassVar[tuple[str, str]]

    mass: float
    sole: Sole
    posture: Any

    @cached_property
    def tree(self) -> Tree:
        """Links, the trunk first; a mass other than the file's is the trunk's."""
        trunk, *others = self.found.tree.links
        factor = 1.0 + (self.mass - round(self.found.tree.mass, DIGITS)) / trunk.mass
        if factor == 1.0:
            return self.found.tree
        scaled = tuple(factor * moment for moment in trunk.moments)
        return Tree((dataclasses.replace(trunk, mass=factor * trunk.mass, inertia=scaled), *others))

    def hip_offset(self) -> float:
        """The trunk's frame lies midway between the hips."""
        return 0.0

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Joint positions that put the feet there, all else held, in [rad]. Shape (n, joints).

        Raises:
            Infeasible: If a sole is out of reach or a leg's joint beyond its limit.
        """
        held = [getattr(self.posture, self.posture_fields[name]) for name in self.found.held]
        return both_legs(lambda side: self._leg_targets(feet, side), held)

    def limbs(self) -> Mapping[str, Limb]:
        """Both legs, from between the hips to the point of the sole below the ankle."""
        return {f"{side}_leg": self._limb(k) for k, side in enumerate(SIDES)}

    @cached_property
    def _legs(self) -> tuple[AxisLeg, AxisLeg]:
        left, right = (self._axis_leg(leg) for leg in self.found.legs)
        return left, right

    def _axis_leg(self, leg: FoundLeg) -> AxisLeg:
        return AxisLeg(
            axes=leg.axes,
            points=leg.points,
            sole=leg.ankle - self.sole.height * leg.rotation[:, 2],
            rotation=leg.rotation,
            limits=np.tile([-np.inf, np.inf], (len(leg.axes), 1)),
            holds=leg.holds,
        )

    def _leg_joints(self, side: int) -> tuple[Joint, ...]:
        """Joints of leg 0, left, or 1, right: they are first in the tree."""
        left = len(self.found.legs[0].joints)
        both = self.found.tree.joints
        return both[:left] if side == 0 else both[left : left + len(self.found.legs[1].joints)]

    def _leg_targets(self, feet: FeetPoses, side: int) -> np.ndarray:
        """Positions of a leg that put its sole in place, in [rad]. Shape (n, joints of the leg)."""
        leg, joints, limb = self.found.legs[side], self._leg_joints(side), f"{SIDES[side]}_leg"
        level = axis_rotation("y", -feet.trunk_pitch) @ axis_rotation("z", feet.heading[:, side])
        wanted = SolePoses(feet.position[:, side], level)
        changed = changes(*wanted)
        few = SolePoses(wanted.position[changed.first], wanted.rotation[changed.first])
        solved = self._legs[side].inverse(few, leg.standing)
        beyond = (solved.misplaced > MISPLACED) | (solved.misturned > MISTURNED)
        angles = solved.angles[changed.of]
        if beyond.any():
            first = int(np.argmax(beyond[changed.of]))
            require_limits(limb, joints, angles[:first])
            raise Infeasible(limb=limb, tick=first, reason=_out_of_reach(leg, wanted, first))
        require_limits(limb, joints, angles)
        return _with_ankle(angles, leg, joints, feet, side)

    def _limb(self, side: int) -> Limb:
        leg, chain = self._legs[side], self.found.legs[side]

        def forward(joints: np.ndarray) -> np.ndarray:
            pose = leg.forward(joints[None])
            return homogeneous(pose.rotation, pose.position)[0]

        def inverse(target: np.ndarray, heading: float) -> np.ndarray:
            wanted = SolePoses(target[None], axis_rotation("z", np.array([heading])))
            solved = leg.inverse(wanted, chain.standing)
            if solved.misplaced[0] > MISPLACED or solved.misturned[0] > MISTURNED:
                reason = _out_of_reach(chain, wanted, 0)
                raise Infeasible(limb=f"{SIDES[side]}_leg", tick=0, reason=reason)
            return solved.angles

        return Limb(
            name=f"{SIDES[side]}_leg",
            joints=self._leg_joints(side),
            target="the point of the level sole below the ankle, from midway between the hips",
            forward=forward,
            inverse=inverse,
            turns=chain.holds[2],
        )


def _out_of_reach(leg: FoundLeg, wanted: SolePoses, instant: int) -> str:
    thigh, shank = leg.segments
    hip = leg.points[leg.pitch[0]]
    ankle = wanted.position[instant] + wanted.rotation[instant] @ (
        leg.rotation.T @ (leg.ankle - leg.points[leg.pitch[2]])
    )
    away = float(np.linalg.norm(ankle - hip))
    return (
        f"the sole would have to be {1e3 * away:.1f} mm from the hip, thigh and shank are "
        f"{1e3 * (thigh + shank):.1f} mm long and the ankle is above the sole; shorten step_length "
        "or step_height, or change hip_height"
    )


def _with_ankle(
    angles: np.ndarray, leg: FoundLeg, joints: tuple[Joint, ...], feet: FeetPoses, side: int
) -> np.ndarray:
    """Positions of a leg whose level sole a gait pitches: what it adds gives way to the limit."""
    hip, _, ankle = leg.pitch
    way = np.sign(leg.axes[[hip, ankle], 1])
    added = feet.knee_only[:, side] * way[0] * angles[:, hip] + feet.ankle_pitch[:, side]
    turned = angles.copy()
    limits = joints[ankle].lower, joints[ankle].upper
    turned[:, ankle] = np.clip(angles[:, ankle] + way[1] * added, *limits)
    return turned


def robot_class(
    name: str,
    found: Reduced,
    servos: Mapping[str, Servo],
    sources: Mapping[str, str],
    servo_sources: Mapping[str, Mapping[str, str]],
    *,
    mass: float | None = None,
    kind: str = "flat",
) -> type[ForeignRobot]:
    """The class of a foreign robot; an instance of it without arguments is the robot of the file.

    Args:
        name: What results call it.
        found: What it is.
        servos: Servos of its own by name.
        sources: Where the mass and the sole's lengths come from, by their names.
        servo_sources: Where the numbers of those servos come from, by name and parameter.
        mass: As weighed, in [kg]; None for the sum of the file.
        kind: Of the sole.
    """
    trunk, own_mass = found.tree.links[0].mass, round(found.tree.mass, DIGITS)
    read = "read: the URDF"
    posture, names = _posture_class(found)
    sole = _sole_class(found, sources, kind)
    cls = dataclasses.make_dataclass(
        "Robot",
        [
            (
                "mass",
                float,
                parameter(
                    own_mass if mass is None else mass,
                    unit="kg",
                    low=own_mass - (1.0 - LEAST_TRUNK) * trunk,
                    high=3.0 * own_mass,
                    doc="mass of the robot; a difference to the file's is the trunk's",
                    source=sources.get("mass", read),
                ),
            ),
            ("sole", sole, field(default_factory=sole)),
            ("posture", posture, field(default_factory=posture)),
        ],
        bases=(ForeignRobot,),
        frozen=True,
        kw_only=True,
        namespace={
            "name": name,
            "found": found,
            "feet": found.feet,
            "own_servos": dict(servos),
            "servo_sources": dict(servo_sources),
            "posture_fields": names,
            "__doc__": f"{name}, a robot from a URDF.",
        },
    )
    cls.__module__ = __name__
    return cls


def _sole_class(found: Reduced, sources: Mapping[str, str], how: str) -> type[Sole]:
    """Sole of a robot with the lengths that were found as its defaults."""
    fields: list[Any] = [
        (
            name,
            float,
            parameter(
                round(getattr(found.sole, name), DIGITS) + 0.0,  # no -0
                unit="m",
                low=low,
                high=high,
                doc=doc,
                source=sources.get(name, "read: geometry of the foot"),
            ),
        )
        for name, (doc, low, high) in SOLE_LENGTHS.items()
    ]
    kind = parameter(
        how,
        unit="-",
        doc="flat is a grid of equal supports out to the edges, studs four corners",
        source="assumption",
    )
    return dataclasses.make_dataclass(
        "ForeignSole",
        [*fields, ("kind", Literal["flat", "studs"], kind)],
        bases=(Sole,),
        frozen=True,
        kw_only=True,
    )


def _posture_class(found: Reduced) -> tuple[type, dict[str, str]]:
    """A field for each joint that is held, and its name by the joint's."""
    joints = {joint.name: joint for joint in found.tree.joints}
    names = {name: _identifier(name) for name in found.held}
    fields = [
        (
            names[name],
            float,
            parameter(
                round(float(position), DIGITS),
                unit="rad",
                low=joints[name].lower,
                high=joints[name].upper,
                doc=f"{name} is held there",
                source="assumption",
            ),
        )
        for name, position in found.held.items()
    ]
    return dataclasses.make_dataclass("Posture", fields, frozen=True, kw_only=True), names


def _identifier(name: str) -> str:
    plain = name if not name[:1].isdigit() else f"_{name}"
    return f"{plain}_" if keyword.iskeyword(plain) else plain


def numbers_digest(found: Reduced) -> str:
    """SHA-256 of the numbers that make the robot, without those that are its parameters.

    Where its file lies, comments and what meshes are called change nothing.
    """
    links = [
        {
            "joint": None
            if link.joint is None
            else [
                link.joint.name,
                _rounded(link.joint.axis),
                *_rounded((link.joint.lower, link.joint.upper)),
            ],
            "name": link.name,
            "numbers": _rounded(
                (
                    *link.origin,
                    link.mass,
                    *link.centre,
                    *link.box.size,
                    *link.box.centre,
                    *(link.turn or ()),
                )
            ),
            "inertia": [float(f"{moment:.9g}") for moment in link.moments],
            "parent": link.parent,
        }
        for link in found.tree.links
    ]
    legs = [[*_rounded(leg.ankle), *_rounded(leg.rotation.ravel())] for leg in found.legs]
    text = canonical_json({"feet": found.feet, "legs": legs, "links": links})
    return hashlib.sha256(text.encode()).hexdigest()


def _rounded(values: Any) -> Any:
    if isinstance(values, str):
        return values
    return [round(float(value), DIGITS) + 0.0 for value in values]
