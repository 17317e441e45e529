"""NAO's leg: a hip yaw-pitch axis slanted by 45 degrees, then roll, pitch, knee and ankle.

Joint signs are NAO's: pitch about +y, roll about +x. `geometric_angles` is the inverse kinematics
of [Shaari2015], whose leg has no yaw-pitch axis; `SlantedLeg` has, and any pose of the sole.

Corrections to [Shaari2015]:
    (2.8) the denominator is the hip-to-ankle distance of that leg; print has L1.
    (2.9) gives the roll for y to the right; NAO's hip roll is the negative of it.
    (2.11) B is an asin, the side opposite the knee's angle over the distance, and the hip pitch is
        B + asin(x / D) as in its own figure; mixed with the printed pi/2 - A it is 41 degrees off.
    (2.12) the ankle is knee less hip pitch; print subtracts the ankle from itself.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
    naoV40: Aldebaran, H25 V4.0 links and joints; the same numbers in ros-naoqi/nao_robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation

SLANT = pi / 4.0  # rad, of the yaw-pitch axis between down and outwards


class SlantedLegAngles(NamedTuple):
    """Joints of [Shaari2015] in NAO's signs, in [rad], and what they are made of. Shape (...)."""

    hip_roll: np.ndarray
    hip_pitch: np.ndarray
    knee_pitch: np.ndarray
    ankle_pitch: np.ndarray
    ankle_roll: np.ndarray
    knee_inside: np.ndarray
    thigh_to_line: np.ndarray
    distance: np.ndarray


def geometric_angles(ankle: np.ndarray, thigh: float, tibia: float) -> SlantedLegAngles:
    """Joints that put a level foot there, [Shaari2015] eqs. (2.6) to (2.12), corrected.

    Args:
        ankle: Ankle seen from the hip joint, in [m]; within reach and below it. Shape (..., 3).
        thigh: L2, hip to knee, in [m].
        tibia: L1, knee to ankle, in [m].
    """
    x, y, z = np.moveaxis(np.asarray(ankle, dtype=float), -1, 0)
    distance = np.sqrt(x * x + y * y + z * z)
    cosine = (thigh**2 + tibia**2 - distance**2) / (2.0 * thigh * tibia)
    inside = np.arccos(np.clip(cosine, -1.0, 1.0))
    to_line = np.arcsin(tibia * np.sin(inside) / distance)
    flexion, roll = to_line + np.arcsin(x / distance), np.arctan2(y, -z)
    knee = pi - inside
    return SlantedLegAngles(roll, -flexion, knee, flexion - knee, -roll, inside, to_line, distance)


@dataclass(frozen=True, kw_only=True)
class SlantedLeg:
    """One leg from its hip joint; turning the frame by the slant makes the yaw axis upright.

    Attributes:
        thigh: Hip to knee, in [m].
        tibia: Knee to ankle, in [m].
        ankle_height: Ankle over the sole, in [m]; 0 for poses of the ankle itself.
        side: The left leg's axis points left and down, the right one's left and up.
    """

    thigh: float
    tibia: float
    ankle_height: float
    side: Literal["left", "right"]

    def sole_pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the sole seen from the hip joint, [naoV40].

        Args:
            joints: Hip yaw-pitch, roll, pitch, knee, ankle pitch, roll, in [rad]. Shape (..., 6).

        Returns:
            Homogeneous transform, positions in [m]. Shape (..., 4, 4).
        """
        return _turned(self._upright.sole_pose(joints * self._signs - self._offset), self._slant)

    def pose_joints(self, pose: np.ndarray) -> np.ndarray:
        """Joints that give the sole a pose seen from the hip joint, the inverse of `sole_pose`.

        Derived here from `Leg.pose_joints`: in the turned frame the chain is yaw, roll, pitch.

        Args:
            pose: Homogeneous transform, positions in [m]. Shape (..., 4, 4).

        Returns:
            Joints, in [rad]. Shape (..., 6).

        Raises:
            Infeasible: If the ankle is out of reach or the sole faces away from the hip.
        """
        upright = self._upright.pose_joints(_turned(pose, -self._slant))
        return (upright + self._offset) * self._signs

    @property
    def _slant(self) -> float:
        return SLANT if self.side == "left" else -SLANT

    @property
    def _offset(self) -> np.ndarray:
        return np.array([0.0, self._slant, 0.0, 0.0, 0.0, 0.0])

    @property
    def _signs(self) -> np.ndarray:
        """The left axis, turned upright, points down."""
        return np.array([-1.0 if self.side == "left" else 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])

    @property
    def _upright(self) -> Leg:
        geometry = LegLengths(hip_spacing=0.0, hip_drop=0.0, thigh=self.thigh, shank=self.tibia)
        return Leg(geometry=geometry, ankle_height=self.ankle_height, side=self.side)


def _turned(pose: np.ndarray, angle: float) -> np.ndarray:
    """Poses seen from a frame turned about x by minus an angle, in [rad]. Shape (..., 4, 4)."""
    turn = np.eye(4)
    turn[:3, :3] = axis_rotation("x", np.array(angle))
    return turn @ pose
