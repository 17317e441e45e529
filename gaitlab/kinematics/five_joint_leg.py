"""A leg without hip yaw: hip roll, hip pitch, knee, ankle pitch, ankle roll, in closed form.

Five joints place the ankle and make the sole level; which way the foot then points follows. With
the trunk leaning by l over a leg rolled by r it turns by about l r, derived here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitlab.kinematics.leg import Leg, LegGeometry
from gaitlab.kinematics.planar_leg import bent_leg
from gaitlab.kinematics.transforms import axis_rotation


@dataclass(frozen=True, kw_only=True)
class FiveJointLeg:
    """One leg of a robot; poses are in the trunk's frame.

    Attributes:
        geometry: Lengths between the joints.
        ankle_height: Ankle axes over the sole, in [m].
        side: The left leg lies at +y.
    """

    geometry: LegGeometry
    ankle_height: float
    side: Literal["left", "right"]

    @property
    def hip(self) -> np.ndarray:
        """Crossing of the hip axes, in [m]. Shape (3,)."""
        return self._with_yaw.hip

    @property
    def _with_yaw(self) -> Leg:
        return Leg(geometry=self.geometry, ankle_height=self.ankle_height, side=self.side)

    def sole_pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the sole below the ankle, positions in [m]. Shapes (..., 5) to (..., 4, 4)."""
        joints = np.asarray(joints, dtype=float)
        unturned = np.zeros((*joints.shape[:-1], 1))
        return self._with_yaw.sole_pose(np.concatenate([unturned, joints], axis=-1))

    def level_joints(self, position: np.ndarray, trunk_pitch: np.ndarray | float) -> np.ndarray:
        """Joints that put a level sole there, derived here.

        The up direction, seen from the shank, is what the two ankle joints have to meet.

        Args:
            position: Point of the sole below the ankle, in [m]. Shape (..., 3).
            trunk_pitch: Forward lean of the trunk, in [rad]. Shape (...).

        Returns:
            Joints, in [rad]. Shape (..., 5).

        Raises:
            Infeasible: If the ankle is out of reach.
        """
        up = axis_rotation("y", -np.asarray(trunk_pitch, dtype=float))[..., 2]
        x, y, z = np.moveaxis(position + self.ankle_height * up - self.hip, -1, 0)
        lengths = self.geometry.thigh, self.geometry.shank
        alpha, knee = bent_leg(x, np.hypot(y, z), *lengths, f"{self.side}_leg")
        roll, pitch = np.arctan2(y, -z), -alpha
        above = axis_rotation("x", roll) @ axis_rotation("y", pitch + knee)
        ux, uy, uz = np.moveaxis(np.einsum("...ji,...j->...i", above, up), -1, 0)
        ankle_pitch, ankle_roll = np.arctan2(ux, uz), -np.arcsin(np.clip(uy, -1.0, 1.0))
        return np.stack([roll, pitch, knee, ankle_pitch, ankle_roll], axis=-1)
