"""The minimum-actuation biped: four motors, and belts that keep the soles parallel to the trunk.

Each leg is a chain of thigh, idler, shank and foot. A belt holds the idler, the double pulley at
the knee, parallel to the trunk; the knee's motor turns the shank against the idler, so that its
angle is the shank's absolute one; a second belt holds the foot parallel to the idler. Only hip and
knee have motors. The paper leaves balance to a mechanism that it does not describe: the robot
walks on a gantry, by default one that holds its trunk level. Lengths and masses are not published.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from gaitlab.kinematics.belt_leg import ankle_position, segment_angles, within_reach
from gaitlab.kinematics.reach import require
from gaitlab.model import SIDES, Coupling, Gantry, Shape, Tree, require_limits
from gaitlab.model.gait import FeetPoses
from gaitlab.model.limbs import Limb, point_limb
from gaitlab.model.link_table import HERE, Table, below, links, read_table
from gaitlab.model.soles import Sole
from gaitlab.parameters import parameter

IDLER_INERTIA = 5e-3  # kg m^2; it never turns, and one as light as it looks stalls Bullet's solver
SAME = 1e-6  # m, how far gait and robot may disagree on where a foot is
_SOLE = "assumption: not published"


@dataclass(frozen=True, kw_only=True)
class BipedSole(Sole):
    """Sole of the biped."""

    length: float = parameter(0.20, unit="m", low=0.02, high=0.6, doc="along x", source=_SOLE)
    width: float = parameter(0.10, unit="m", low=0.02, high=0.4, doc="along y", source=_SOLE)
    heel: float = parameter(
        0.07, unit="m", low=0.0, high=0.5, doc="ankle axis to the heel edge", source=_SOLE
    )
    height: float = parameter(
        0.05, unit="m", low=0.01, high=0.2, doc="ankle axis over the sole", source=_SOLE
    )
    kind: Literal["flat", "studs"] = parameter(
        "flat", unit="-", doc="a grid of supports out to the edges, or four corners", source=_SOLE
    )


@dataclass(frozen=True, kw_only=True)
class Robot:
    """The biped; the trunk link frame lies between the hip axes."""

    name: ClassVar[str] = "biped"
    feet: ClassVar[tuple[str, str]] = ("left_foot", "right_foot")
    table: ClassVar[Table] = read_table(Path(__file__).with_name("biped_links.csv"))
    couplings: ClassVar[tuple[Coupling, ...]] = tuple(
        Coupling(f"{side}_{leader}", f"{side}_{follower}", -1.0)
        for side in SIDES
        for leader, follower in (("hip", "idler"), ("knee", "ankle"))
    )

    segment: float = parameter(
        0.30, unit="m", low=0.05, high=1.0, doc="l, thigh and shank", source="assumption: arbitrary"
    )
    hip_spacing: float = parameter(
        0.12, unit="m", low=0.0, high=0.5, doc="between the legs' planes", source="assumption"
    )
    gantry: Gantry = parameter(
        "level",
        unit="-",
        doc="rig: level holds lateral motion, roll, yaw and pitch, planar leaves pitch free",
        source="assumption: stands for the balancing mechanism that the paper leaves out",
    )
    sole: BipedSole = field(default_factory=BipedSole)

    def hip_offset(self) -> float:
        """Height of the trunk link frame over the hip axes, in [m]."""
        return 0.0

    @cached_property
    def tree(self) -> Tree:
        """Links of `biped_links.csv`: trunk, left leg, right leg; box sizes are plausible."""
        x, y, z = self.sole.centre
        bone, middle = (0.05, 0.05, 0.85 * self.segment), below(self.segment / 2.0)
        tread = (self.sole.length, self.sole.width, 0.012)
        shapes = {
            "trunk": Shape(HERE, (0.15, 0.22, 0.30), (0.0, 0.0, 0.18)),
            "thigh": Shape((0.0, 0.5 * self.hip_spacing, 0.0), bone, middle),
            "idler": Shape(below(self.segment), (0.05, 0.03, 0.05)),
            "shank": Shape(HERE, bone, middle),
            "foot": Shape(below(self.segment), tread, (x, y, z + tread[2] / 2.0)),
        }
        masses = {row["link"]: float(row["mass_kg"]) for row in self.table}
        return Tree(
            tuple(
                replace(link, inertia=(IDLER_INERTIA,) * 3) if "idler" in link.name else link
                for link in links(self.table, shapes, masses)
            )
        )

    def limbs(self) -> Mapping[str, Limb]:
        """Both legs as chains of their two motors; idler and ankle follow."""
        chain = {joint.name: joint for joint in self.tree.joints if joint.servo is not None}
        legs = (
            point_limb(
                f"{side}_leg",
                (chain[f"{side}_hip"], chain[f"{side}_knee"]),
                "the point of the sole below the ankle, from the hip axis: x forward, z up, y 0; "
                "the knee's angle is the shank's, from the downward vertical",
                forward=self._sole_pose,
                inverse=partial(self._branches, f"{side}_leg"),
            )
            for side in SIDES
        )
        return {leg.name: leg for leg in legs}

    def _sole_pose(self, angles: np.ndarray) -> np.ndarray:
        """Pose of the sole, always parallel to the trunk. Shapes (2,) to (4, 4)."""
        pose = np.eye(4)
        pose[[0, 2], 3] = ankle_position(angles, self.segment) - [0.0, self.sole.height]
        return pose

    def _branches(self, limb: str, target: np.ndarray) -> np.ndarray:
        """Thigh and shank with the knee forward, then backward. Shapes (3,) to (2, 2)."""
        x, y, z = target
        ankle, longest = np.array([x, z + self.sole.height]), 2.0 * self.segment
        plane = "y is {found:g} m, the leg moves in the plane y = 0"
        require(np.abs(y) <= SAME, y, limb, plane)
        reach = f"the ankle is {{found:.4f}} m from the hip, the leg reaches {longest:.4f} m"
        require(within_reach(ankle, self.segment), np.hypot(*ankle), limb, reach)
        thigh, shank = segment_angles(ankle, self.segment)
        return np.array([[thigh, shank], [shank, thigh]])

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        """Hip, idler, knee and ankle of both legs that put the feet there, in [rad].

        Shape (n, 8). The legs move in their own planes and the soles stay parallel to the trunk.

        Raises:
            Infeasible: If a foot is out of reach, turned or beside its plane, a joint beyond its
                limit, or the gait was made for legs of other lengths.
        """
        legs = [self._leg_targets(feet, index, side) for index, side in enumerate(SIDES)]
        targets = np.concatenate(legs, axis=1)
        require_limits("legs", self.tree.joints, targets)
        return targets

    def _leg_targets(self, feet: FeetPoses, index: int, side: str) -> np.ndarray:
        across = 0.5 * self.hip_spacing * (1.0 if side == "left" else -1.0)
        x, y, z = np.moveaxis(feet.position[:, index], -1, 0)
        ankle = np.stack([x, z + self.sole.height], axis=-1)
        turned = np.abs(feet.heading[:, index]) + np.abs(feet.ankle_pitch[:, index])
        _refuse(side, np.abs(y - across) > SAME, f"the foot stays {across} m beside the trunk's "
                "middle; set gait.step_width to robot.hip_spacing, sway to 0")  # fmt: skip
        _refuse(side, turned + np.abs(feet.trunk_pitch) > 0.0, "the belts keep the sole parallel "
                "to the trunk; set heading, lean and ankle pitch to 0")  # fmt: skip
        _refuse(side, ~within_reach(ankle, self.segment), f"the ankle is farther from the hip than "
                f"{2.0 * self.segment} m; shorten step_length, lower hip_height")  # fmt: skip
        self._require_same_leg(feet, side, ankle)
        thigh, shank = np.moveaxis(segment_angles(ankle, self.segment), -1, 0)
        return np.stack([thigh, -thigh, shank, -shank], axis=-1)

    def _require_same_leg(self, feet: FeetPoses, side: str, ankle: np.ndarray) -> None:
        """Refuse a gait in joint space whose legs are not this robot's."""
        names = (f"{side}_hip", f"{side}_knee")
        if all(name in feet.joints for name in names):
            angles = np.stack([feet.joints[name] for name in names], axis=-1)
            error = np.abs(ankle_position(angles, self.segment) - ankle).max(axis=-1)
            _refuse(side, error > SAME, f"the gait was made for legs of other lengths; set "
                    f"gait.segment to {self.segment} m and gait.ankle_height to "
                    f"{self.sole.height} m")  # fmt: skip


def _refuse(side: str, wrong: np.ndarray, reason: str) -> None:
    require(~wrong, wrong, f"{side}_leg", reason)
