"""Hip, knee and ankle of a leg without hip yaw, in the terms of the Bioloid paper.

Target (x, y, z): from the hip pitch axis to the ankle pitch axis, along the torso; x forward, y
down, z to the robot's right (the sign of z is inferred from Table 2: in every lift the stance foot
then lies inward of its hip). Angles: alpha hip flexion, beta knee flexion, gamma ankle
dorsiflexion, theta hip roll, omega ankle roll. The torso leans over the sole by
lambda = alpha + gamma - beta.

Corrections to the printed equations of [Setiyono]:
    alpha1 = atan2(x, y); the printed acos(y / R) loses the sign of x.
    (7) gamma = alpha2 holds the torso along hip to ankle, so the lean is alpha1 and differs
        from leg to leg; soles are parallel with gamma = beta - alpha + lambda, one lambda for both.
    (8) theta = atan2(z, y); print has x / y, which is the tangent of alpha1.
    (1) to (7) put R = hypot(x, y), but a leg rolled by theta has to span hypot(y, z) downwards.

`FiveJointLeg` is the same leg in the trunk's frame. Five joints place the ankle and make the sole
level; which way the foot then points follows. With the trunk leaning by l over a leg rolled by r it
turns by about l r, derived here.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from gaitlab.kinematics.reach import ROUNDING, require
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths
from gaitlab.kinematics.transforms import axis_rotation

Coupling = Literal["planar", "spatial"]
AnkleLaw = Literal["published", "flat"]


class LegAngles(NamedTuple):
    """Angles in the paper's signs, in [rad]. Shape (...) each."""

    alpha: np.ndarray
    beta: np.ndarray
    gamma: np.ndarray
    theta: np.ndarray
    omega: np.ndarray

    @property
    def lean(self) -> np.ndarray:
        """Lean lambda of the torso over the sole, positive forward, in [rad]. Shape (...)."""
        return self.alpha + self.gamma - self.beta


def bent_leg(
    x: np.ndarray, down: np.ndarray, thigh: float, shank: float, limb: str
) -> tuple[np.ndarray, np.ndarray]:
    """Hip and knee flexion that span x forward and so much down, [Setiyono] eqs. (1) to (6).

    Args:
        x: Ankle ahead of the hip, in [m]. Shape (...).
        down: Ankle below the hip in the plane of the leg, in [m]. Shape (...).
        thigh: L1, in [m].
        shank: L2, in [m].
        limb: Name for the message.

    Returns:
        alpha and beta >= 0, in [rad]. Shape (...) each.

    Raises:
        Infeasible: If the leg is too short or cannot fold so far.
    """
    reach = np.hypot(x, down)
    low, high = abs(thigh - shank), thigh + shank
    # A leg that folds up completely has no direction, hence at least a rounding error of reach.
    require(
        (reach >= max(low - ROUNDING, ROUNDING)) & (reach <= high + ROUNDING),
        reach,
        limb,
        f"hip to ankle would have to be {{found:.4f}} m, the leg spans [{low:.4f}, {high:.4f}] m; "
        "shorten step_length or step_height, or change hip_height",
    )
    alpha2 = _angle_between(thigh, reach, shank)
    beta1 = _angle_between(thigh, shank, reach)
    return np.arctan2(x, down) + alpha2, np.pi - beta1


def _angle_between(
    one: float, other: np.ndarray | float, opposite: np.ndarray | float
) -> np.ndarray:
    """Angle between two sides of a triangle by the cosine rule; clipped for rounding only."""
    cosine = (one**2 + np.square(other) - np.square(opposite)) / (2.0 * one * np.asarray(other))
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def leg_angles(
    target: np.ndarray,
    *,
    thigh: float,
    shank: float,
    coupling: Coupling = "planar",
    ankle_law: AnkleLaw = "published",
    lean: np.ndarray | float = 0.0,
    omega_sign: np.ndarray | float = 1.0,
    limb: str = "leg",
) -> LegAngles:
    """Angles that put the ankle there, [Setiyono] eqs. (1) to (9), corrected.

    Args:
        target: x, y, z from hip to ankle, in [m]. Shape (..., 3).
        thigh: L1, in [m].
        shank: L2, in [m].
        coupling: `planar` spans hypot(x, y) as printed, `spatial` reaches the target.
        ankle_law: `published` gamma = alpha2, eq. (7), or `flat`.
        lean: lambda that the flat law holds, in [rad]. Shape (...).
        omega_sign: 1 is eq. (9), -1 what the paper measured of stance legs. Shape (...).
        limb: Name for the message.

    Raises:
        Infeasible: If the target is out of reach.
    """
    x, y, z = np.moveaxis(np.asarray(target, dtype=float), -1, 0)
    down = np.hypot(y, z) if coupling == "spatial" else y
    alpha, beta = bent_leg(x, down, thigh, shank, limb)
    held = np.arctan2(x, down) if ankle_law == "published" else lean
    theta = np.arctan2(z, y)
    return LegAngles(alpha, beta, beta - alpha + held, theta, omega_sign * theta)


def ankle_position(
    angles: LegAngles, *, thigh: float, shank: float, coupling: Coupling = "planar"
) -> np.ndarray:
    """Where the ankle is: x, y, z from the hip, in [m], inverting `leg_angles`. Shape (..., 3).

    `planar` reads y in the plane of the leg and z as y tan(theta), as the printed inverse does;
    `spatial` is where a rolled leg really ends.
    """
    alpha, beta, theta = angles.alpha, angles.beta, angles.theta
    x = thigh * np.sin(alpha) + shank * np.sin(alpha - beta)
    down = thigh * np.cos(alpha) + shank * np.cos(alpha - beta)
    if coupling == "planar":
        return np.stack([x, down, down * np.tan(theta)], axis=-1)
    return np.stack([x, down * np.cos(theta), down * np.sin(theta)], axis=-1)


def joints_of(angles: LegAngles) -> np.ndarray:
    """Hip roll, hip pitch, knee, ankle pitch, ankle roll, in [rad]. Shape (..., 5).

    Axes here are x forward, y left; a bent knee is positive, a raised toe negative.
    """
    return np.stack(
        [-angles.theta, -angles.alpha, angles.beta, -angles.gamma, angles.omega], axis=-1
    )


def angles_of(joints: np.ndarray) -> LegAngles:
    """The paper's angles of joints (..., 5), the inverse of `joints_of`."""
    roll, pitch, knee, ankle_pitch, ankle_roll = np.moveaxis(np.asarray(joints, dtype=float), -1, 0)
    return LegAngles(-pitch, knee, -ankle_pitch, -roll, ankle_roll)


def sole_points(
    joints: np.ndarray,
    lean: np.ndarray,
    *,
    thigh: float,
    shank: float,
    hip_spacing: float,
    ankle_height: float,
) -> np.ndarray:
    """Points of level soles straight below the ankles, hip frame, in [m]. Shape (n, 2, 3).

    Args:
        joints: Of the left and the right leg, as `joints_of` gives them. Shape (n, 2, 5).
        lean: Of the torso over the soles, in [rad]. Shape (n,).
        thigh: L1, in [m].
        shank: L2, in [m].
        hip_spacing: Hip off the centre plane, in [m].
        ankle_height: Ankle over the sole, in [m].
    """
    angles = angles_of(joints)
    x, y, z = np.moveaxis(
        ankle_position(angles, thigh=thigh, shank=shank, coupling="spatial"), -1, 0
    )
    hips = np.array([hip_spacing, -hip_spacing])
    up = axis_rotation("y", -lean)[..., 2]
    return np.stack([x, hips - z, -y], axis=-1) - ankle_height * up[:, None]


@dataclass(frozen=True, kw_only=True)
class FiveJointLeg:
    """One leg of a robot; poses are in the trunk's frame.

    Attributes:
        geometry: Lengths between the joints.
        ankle_height: Ankle axes over the sole, in [m].
        side: The left leg lies at +y.
    """

    geometry: LegLengths
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
