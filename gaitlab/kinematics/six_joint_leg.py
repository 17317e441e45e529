"""A six-joint leg in closed form: sole pose from joints and joints from sole pose.

Joints are hip yaw, hip roll, hip pitch, knee, ankle pitch, ankle roll; positive pitch is a
rotation about +y, so a bent knee is positive and a raised toe negative. In print the right limbs
lie at +y; here y points left, so the side with s = +1 is the left one and every formula stands.

Corrections to the printed inverse kinematics of [Pristovani2018], eqs. (9) to (35):
    (11) atan2 instead of tan^-1, which loses the quadrant and divides by zero at Px = 0.
    (12), (13) P'y = R0 sin(beta) and P'x = R0 cos(beta), without Py and Px before them.
    (14) z = Pz + dz6 counted from the hip: dy and dz1 are taken off first.
    (15), (30) the ankle lies below the hip: atan2(P'y, -z).
    (17) R2 = hypot(P'x, R1); print squares the height alone.
    (18) to (20) right; the cosine is clipped, for rounding only.
    (22), (23) gamma_b = atan2(dz4 sin(q4), dz3 + dz4 cos(q4)); print has dz3 twice, a wrong sign.
    (25), (32) q3 = -(gamma_a + gamma_b) for a rotation about +y.
    (26), (33) q4 = pi - gamma_c.
    (27), (34) q5 = -(q3 + q4): print leaves the sole tilted by twice that angle.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitlab.kinematics.reach import ROUNDING, require
from gaitlab.kinematics.transforms import axis_rotation, homogeneous, turned


@dataclass(frozen=True, kw_only=True)
class LegLengths:
    """Lengths between the leg's joints; hip axes intersect, ankle axes intersect.

    Attributes:
        hip_spacing: dy, trunk centre plane to the hip, in [m].
        hip_drop: dz1, leg origin down to the hip, in [m].
        thigh: dz3, hip to knee, in [m].
        shank: dz4, knee to ankle, in [m].
    """

    hip_spacing: float
    hip_drop: float
    thigh: float
    shank: float


@dataclass(frozen=True, kw_only=True)
class Leg:
    """One leg of a robot; poses are in the leg origin's frame, which is the trunk's.

    Attributes:
        geometry: Lengths between the joints.
        ankle_height: dz6, ankle axes over the sole, in [m].
        side: The left leg lies at +y.
        yaw_axis: `hip` turns the leg about its own hip; `trunk` turns the hip's offset along,
            as [Pristovani2018] Tables 5 and 6 have it. Equal at zero yaw.
    """

    geometry: LegLengths
    ankle_height: float
    side: Literal["left", "right"]
    yaw_axis: Literal["hip", "trunk"] = "hip"

    @property
    def hip(self) -> np.ndarray:
        """Hip at zero yaw, in [m]. Shape (3,)."""
        spacing = self.geometry.hip_spacing
        return np.array(
            [0.0, spacing if self.side == "left" else -spacing, -self.geometry.hip_drop]
        )

    def sole_pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the sole below the ankle, chain of [Pristovani2018] Tables 5 and 6.

        Args:
            joints: In [rad]. Shape (..., 6).

        Returns:
            Homogeneous transform, positions in [m]. Shape (..., 4, 4).
        """
        yaw, *rest = (
            axis_rotation(axis, angle)
            for axis, angle in zip("zxyyyx", np.moveaxis(joints, -1, 0), strict=True)
        )
        roll, pitch, knee, ankle_pitch, ankle_roll = rest
        thigh = yaw @ roll @ pitch
        shank = thigh @ knee
        foot = shank @ ankle_pitch @ ankle_roll
        hip = yaw @ self.hip if self.yaw_axis == "trunk" else self.hip
        lengths = (self.geometry.thigh, self.geometry.shank, self.ankle_height)
        drops = (
            rotation[..., 2] * length
            for rotation, length in zip((thigh, shank, foot), lengths, strict=True)
        )
        return homogeneous(foot, hip - sum(drops))

    def flat_joints(self, position: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """Joints that put a level sole there, [Pristovani2018] eqs. (9) to (35), corrected.

        The knee bends forward; hip roll stays within +-pi/2.

        Args:
            position: Point of the sole below the ankle, in [m]. Shape (..., 3).
            heading: Yaw of the foot, in [rad]. Shape (...).

        Returns:
            Joints, in [rad]. Shape (..., 6).

        Raises:
            Infeasible: If the ankle is out of reach or not below the hip.
        """
        x, y, z = np.moveaxis(self._ankle_from_hip(position, heading), -1, 0)
        require(
            z < 0.0,
            z,
            self._name,
            "ankle lies {found:.4f} m above the hip, it must lie below; raise hip_height or lower"
            " step_height",
        )
        r1 = np.hypot(y, z)
        knee = self._knee(np.hypot(x, r1))
        gamma_a = np.arctan2(x, r1)
        thigh, shank = self.geometry.thigh, self.geometry.shank
        gamma_b = np.arctan2(shank * np.sin(knee), thigh + shank * np.cos(knee))
        pitch, roll = -(gamma_a + gamma_b), np.arctan2(y, -z)
        yaw = np.broadcast_to(heading, knee.shape)
        return np.stack([yaw, roll, pitch, knee, -(pitch + knee), -roll], axis=-1)

    def flat_branches(self, position: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """Both ways to put a level sole there, knee forward first; derived here.

        Hip to ankle stays where it is when the knee bends the other way, so the hip pitch moves
        to the other side of it. Arguments and errors as of `flat_joints`. Shape (..., 2, 6).
        """
        forward = self.flat_joints(position, heading)
        yaw, roll, pitch, knee, _, ankle_roll = np.moveaxis(forward, -1, 0)
        thigh, shank = self.geometry.thigh, self.geometry.shank
        pitch = pitch + 2.0 * np.arctan2(shank * np.sin(knee), thigh + shank * np.cos(knee))
        backward = np.stack([yaw, roll, pitch, -knee, knee - pitch, ankle_roll], axis=-1)
        return np.stack([forward, backward], axis=-2)

    def pose_joints(self, pose: np.ndarray) -> np.ndarray:
        """Joints that give the sole any pose, derived here for the yaw axis through the hip.

        With r the hip seen from the ankle in the foot's frame, |r| fixes the knee, its direction
        the two ankle joints; what then remains of the rotation is Rz(yaw) Rx(roll) Ry(pitch).

        Args:
            pose: Homogeneous transform of the sole, positions in [m]. Shape (..., 4, 4).

        Returns:
            Joints, in [rad]. Shape (..., 6).

        Raises:
            Infeasible: If the ankle is out of reach or the sole faces away from the hip.
            ValueError: If the yaw axis is not the hip's.
        """
        if self.yaw_axis != "hip":
            raise ValueError("pose_joints needs yaw_axis 'hip'; use flat_joints for 'trunk'")
        rotation, sole = pose[..., :3, :3], pose[..., :3, 3]
        ankle = sole + self.ankle_height * rotation[..., 2]
        r = np.einsum("...ji,...j->...i", rotation, self.hip - ankle)
        require(
            r[..., 2] > 0.0,
            r[..., 2],
            self._name,
            "along the sole's normal the hip lies {found:.4f} m above the ankle, it must be more"
            " than 0; raise hip_height or lower step_height",
        )
        knee = self._knee(np.linalg.norm(r, axis=-1))
        ankle_pitch, ankle_roll = self._ankle(r, knee)
        above = turned(axis_rotation("x", -ankle_roll), "y", -knee - ankle_pitch)
        hip = _yaw_roll_pitch(rotation @ above)
        return np.stack([*hip, knee, ankle_pitch, ankle_roll], axis=-1)

    def _ankle_from_hip(self, position: np.ndarray, heading: np.ndarray) -> np.ndarray:
        turn = axis_rotation("z", -np.asarray(heading, dtype=float))
        position = np.asarray(position, dtype=float)
        if self.yaw_axis == "trunk":
            ankle = np.einsum("...ij,...j->...i", turn, position) - self.hip
        else:
            ankle = np.einsum("...ij,...j->...i", turn, position - self.hip)
        return ankle + np.array([0.0, 0.0, self.ankle_height])

    def _ankle(self, r: np.ndarray, knee: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y, z = np.moveaxis(r, -1, 0)
        thigh, shank = self.geometry.thigh, self.geometry.shank
        bend = np.arctan2(-thigh * np.sin(knee), shank + thigh * np.cos(knee))
        return bend - np.arctan2(x, np.hypot(y, z)), np.arctan2(y, z)

    def _knee(self, reach: np.ndarray) -> np.ndarray:
        """Knee angle by the cosine rule, [Pristovani2018] eqs. (18) to (20) and (26)."""
        thigh, shank = self.geometry.thigh, self.geometry.shank
        low, high = abs(thigh - shank), thigh + shank
        require(
            (reach >= low - ROUNDING) & (reach <= high + ROUNDING),
            reach,
            self._name,
            f"hip to ankle would have to be {{found:.4f}} m, the leg spans [{low:.4f}, {high:.4f}]"
            " m; shorten step_length or step_height, or change hip_height",
        )
        cosine = (thigh**2 + shank**2 - reach**2) / (2.0 * thigh * shank)
        return np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))

    @property
    def _name(self) -> str:
        return f"{self.side}_leg"


def _yaw_roll_pitch(rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles of a rotation Rz(yaw) Rx(roll) Ry(pitch), in [rad]. Shape (...) each."""
    yaw = np.arctan2(-rotation[..., 0, 1], rotation[..., 1, 1])
    roll = np.arcsin(np.clip(rotation[..., 2, 1], -1.0, 1.0))
    pitch = np.arctan2(-rotation[..., 2, 0], rotation[..., 2, 2])
    return yaw, roll, pitch
