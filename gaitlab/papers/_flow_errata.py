"""What is wrong in print in the FLoW paper, each mistake with the size of its effect.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from math import degrees

import numpy as np

from gaitlab.papers._printed_arm import (
    head_miss,
    pointing_error,
    printed_tip_error,
    roll_error,
    shoulder_sensitivity,
)
from gaitlab.papers._printed_leg import flow_joints, miss, printed_cosine
from gaitlab.papers.page import Erratum
from gaitlab.robots.flow import Robot

STANDING = np.array([0.0, 0.0, -0.51])  # m, sole from the hip: 0.45 m from hip to ankle
STEPPING = np.array([0.10, 0.03, -0.46])  # m, sole from the hip, a foot ahead and aside


def errata() -> tuple[Erratum, ...]:
    """Every mistake, in the paper's order."""
    return (*_head_errata(), *_arm_errata(), *_leg_errata())


def _head_errata() -> tuple[Erratum, ...]:
    head = Robot().head_of()
    return (
        Erratum(
            where="(3)",
            printed="0T3 = 0T1 1T2",
            correct="0T2, the product of two factors",
            effect="none, a label",
        ),
        Erratum(
            where="(5) to (7)",
            printed="Px = a cos(q1 + q2), Py with a wrong sign, Pz = 2 (d1 + d2)",
            correct="P = (a c1 s2, a s1 s2, d + a c2), a head that pans and tilts",
            effect=f"eyes up to {1e3 * head_miss(head):.0f} mm off within the head's range",
        ),
        Erratum(
            where="(9)",
            printed="tan^-1(dX / Z)",
            correct="atan2(hypot(dX, dY), Z - d)",
            effect=f"tilt up to {degrees(pointing_error(head)):.0f} degrees off when looking aside",
        ),
    )


def _arm_errata() -> tuple[Erratum, ...]:
    arm = Robot().arm_of("left")

    def effect(equation: int) -> str:
        error = np.linalg.norm(printed_tip_error(arm, (equation,)), axis=-1)
        return f"tip {1e3 * error.mean():.0f} mm off on average, {1e3 * error.max():.0f} mm at most"

    return (
        Erratum(
            where="(12)",
            printed="... + c4 s2) + d3 c1 s2",
            correct="... + c4 c1 s2) + d3 c1 s2",
            effect=effect(12),
        ),
        Erratum(
            where="(13)",
            printed="d3 (s1 (s2 - d5 (s4 c1 s3 - c2 c3 s1)) - c4 s1 s1)",
            correct="d3 s1 s2 - d5 (s4 (c1 s3 - s1 c2 c3) - c4 s1 s2)",
            effect=effect(13),
        ),
        Erratum(
            where="(14)",
            printed="... - d3 c1 s2",
            correct="... - d3 c2",
            effect=effect(14),
        ),
        Erratum(
            where="(16)",
            printed="divides by cos q1",
            correct="atan2(c1 Ex + s1 Ey, d1 - Ez) with E the elbow",
            effect=(
                "at q1 = 89.9 degrees, 0.1 mm in Px turns q2 by "
                f"{degrees(shoulder_sensitivity(arm)):.1f} degrees"
            ),
        ),
        Erratum(
            where="(18)",
            printed="q4 = tan^-1(R1 / L1), neither defined",
            correct="atan2(hypot(u, v), c1 s2 ax + s1 s2 ay - c2 az), u and v as in (17)",
            effect="no value can be computed",
        ),
        Erratum(
            where="(19)",
            printed="q5 = q3 + q4, a line of the leg's",
            correct="atan2 of the rotation that the first four joints leave over",
            effect=f"hand turned by {degrees(roll_error(arm)):.0f} degrees on average",
        ),
    )


def _leg_errata() -> tuple[Erratum, ...]:
    leg = Robot().leg_of("left")

    def effect(*equations: int) -> str:
        return f"foot ahead and aside: {miss(flow_joints, leg, STEPPING, equations)}"

    lost = float(np.hypot(leg.hip[1], leg.hip[2]))
    cosines = ", ".join(f"{printed_cosine(leg, sole):.2f}" for sole in (STANDING, STEPPING))
    return (
        Erratum(
            where="(22) to (24)",
            printed="sums of d1 to d5 with single sines, and an undefined sigma1",
            correct="the chain yaw, roll, pitch, knee, pitch, roll, derived anew",
            effect="no value can be computed: sigma1 is a label of the algebra program",
        ),
        Erratum(
            where="(30)",
            printed="R2 = sqrt(R1^2 + dY^2), R1 undefined",
            correct="R1 = hypot(dY, Z), R2 = hypot(dX, R1)",
            effect=effect(30),
        ),
        Erratum(
            where="(31)",
            printed="acos((L1^2 + L2^2 + R2^2) / (2 L1^2 + L2^2))",
            correct="acos((L1^2 + L2^2 - R2^2) / (2 L1 L2))",
            effect=f"no angle at all: the argument is {cosines} where it may be at most 1",
        ),
        Erratum(
            where="(32)",
            printed="(31) once more",
            correct="theta_sa = atan2(dX, R1), which (35) needs",
            effect=f"without it {effect(32)}",
        ),
        Erratum(
            where="(34)",
            printed="asin(L2 sin theta_sc / R2)",
            correct="atan2(L2 sin q4, L1 + L2 cos q4)",
            effect=f"none while the angle is below 90 degrees; {_folded()}",
        ),
        Erratum(
            where="(35)",
            printed="q3 = theta_sa + theta_sc",
            correct="-(theta_sa + theta_sb) for a turn about +y",
            effect=effect(35),
        ),
        Erratum(
            where="(36)",
            printed="q4 = 180 - theta_sb",
            correct="180 - theta_sc",
            effect=effect(36),
        ),
        Erratum(
            where="(37)",
            printed="q5 = q3 + q4",
            correct="-(q3 + q4) in a serial leg; as printed it is the shank's absolute angle",
            effect=effect(37),
        ),
        Erratum(where="(38)", printed="q6 = q2", correct="q6 = -q2", effect=effect(38)),
        Erratum(
            where="(25) to (34)",
            printed="hip offset and ankle height are never taken off",
            correct="take dy, dz1 and dz6 off first",
            effect=(
                f"every target {1e3 * lost:.0f} mm off for the hip and "
                f"{1e3 * leg.ankle_height:.0f} mm for the ankle"
            ),
        ),
    )


def _folded() -> str:
    """A leg with a long shank, deeply folded, where the arc sine picks the wrong angle."""
    robot = Robot()
    leg = robot.leg_of("left")
    geometry = type(robot.leg)(thigh=0.20, shank=0.26)
    folded = type(leg)(geometry=geometry, ankle_height=leg.ankle_height, side="left")
    found = miss(flow_joints, folded, np.array([0.0, 0.0, -0.12 - leg.ankle_height]), (34,))
    return f"thigh 200, shank 260, folded to 120 mm: {found}"
