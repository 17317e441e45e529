"""What is wrong in print in the EROS paper's kinematics: frames, head, arms and legs.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import degrees

import numpy as np

from gaitlab.kinematics.arm import hand_pose
from gaitlab.kinematics.head import camera_pose
from gaitlab.kinematics.leg import Leg, LegGeometry
from gaitlab.papers._printed_leg import EROS_EQUATIONS, eros_joints, miss
from gaitlab.papers.page import Erratum
from gaitlab.robots.eros import Robot

STEPPING = np.array([0.040, 0.045, -0.228])  # m, sole from the hip: ahead, aside, crouched
CROUCH = np.array([0.0, 0.0, -0.228])  # m, sole from the hip when standing
UNEQUAL = LegGeometry(thigh=0.110, shank=0.100)  # shows what equal links hide


def kinematics_errata() -> tuple[Erratum, ...]:
    """Those of Tables 3 to 6 and equations (2) to (35), in the paper's order."""
    return (_frame(), *_pose_errata(), *_leg_errata())


def left_leg(geometry: LegGeometry | None = None) -> Leg:
    """EROS's left leg, or one of other lengths."""
    robot = Robot()
    return Leg(geometry=geometry or robot.leg, ankle_height=robot.sole.height, side="left")


def _frame() -> Erratum:
    joints = np.array([0.3, 0.2, -0.4, 0.8, -0.4, -0.2])
    leg = left_leg()
    turned = joints * [-1.0, -1.0, 1.0, 1.0, 1.0, -1.0]
    apart = leg.sole_pose(joints)[:3, 3] - leg.sole_pose(turned)[:3, 3]
    return Erratum(
        where="Tables 3 to 6",
        printed="right limbs at +y with x forward and z up, a left-handed frame",
        correct="left limbs at +y; then every formula stands as it is",
        effect=(
            "a turn of 0.3 rad in yaw and 0.2 in roll read the other way: sole "
            f"{1e3 * np.linalg.norm(apart):.0f} mm off; none when walking straight"
        ),
    )


def _pose_errata() -> tuple[Erratum, ...]:
    robot, generator = Robot(), np.random.default_rng(3)
    look = generator.uniform([-2.0, -0.5], [2.0, 1.5], size=(2000, 2))
    printed = robot.head.camera * np.sin(look[:, 1]) ** 2
    camera = np.abs(printed - camera_pose(robot.head, look)[:, 1, 3]).max()
    arm = generator.uniform([-3.0, -0.2, -2.4], [3.0, 2.0, 0.0], size=(2000, 3))
    pose = hand_pose(robot.arm, arm, "right")
    c, s = np.cos(arm), np.sin(arm)
    r11 = c[:, 0] * c[:, 2] - c[:, 1] * s[:, 0]
    length = np.sqrt(r11**2 + pose[:, 1, 0] ** 2 + pose[:, 2, 0] ** 2)
    spacing = 2.0 * robot.arm.shoulder_spacing
    return (
        Erratum(
            where="(2), (3)",
            printed="second row of the fourth column: d2 sin q2 sin q2",
            correct="d2 sin q1 sin q2",
            effect=f"camera up to {1e3 * camera:.0f} mm off",
        ),
        Erratum(
            where="(5)",
            printed="R11 = cos q1 cos q3 - cos q2 sin q1",
            correct="cos q1 cos q3 - cos q2 sin q1 sin q3",
            effect=(
                f"no rotation any more: that column has a length of {length.min():.2f} to "
                f"{length.max():.2f}"
            ),
        ),
        Erratum(
            where="(5)",
            printed="first row of the third column called R33; phi ends in a sine",
            correct="R13; phi = cos q2 (dz2 + dz3 cos q3)",
            effect="no printed phi fits the printed R14 and R34",
        ),
        Erratum(
            where="(7)",
            printed="R24 taken from the right arm and given anew, with the index x",
            correct="R24 = -dy + dz2 sin q2 + dz3 sin q2 cos q3",
            effect=f"with the right arm's, the left hand is {1e3 * spacing:.0f} mm off",
        ),
        Erratum(
            where="Tables 5, 6",
            printed="knee q2, ankle pitch q3, ankle roll q3; Table 6 captioned as the right leg",
            correct="q4, q5, q6; the left leg",
            effect="none, indices",
        ),
    )


def _leg_errata() -> tuple[Erratum, ...]:
    texts = {
        11: ("tan^-1(Py / Px)", "atan2(Py, Px)"),
        12: ("P'y = Py + R0 sin beta", "P'y = R0 sin beta"),
        13: ("P'x = Px - R0 cos beta", "P'x = R0 cos beta"),
        14: ("-Pz + d6, hip offset never taken off", "Pz + dz6 counted from the hip"),
        15: ("tan^-1(P'y / Pz6) with Pz6 < 0", "atan2(P'y, -z)"),
        17: ("R2 = sqrt(P'x^2 + Pz6^2)", "hypot(P'x, R1)"),
        22: ("-d3 sin gamma_c", "dz4 sin gamma_c"),
        23: ("-d3 - d4 cos gamma_c", "dz3 - dz4 cos gamma_c"),
        25: ("q3 = gamma_a + gamma_b", "-(gamma_a + gamma_b) for a turn about +y"),
        27: ("q5 = q3 + q4", "-(q3 + q4)"),
    }
    found = [
        Erratum(where=f"({number})", printed=printed, correct=correct, effect=_effect(number))
        for number, (printed, correct) in texts.items()
    ]
    together = miss(eros_joints, left_leg(), STEPPING, EROS_EQUATIONS)
    index = Erratum(
        where="(18) to (35)",
        printed="(26) numbered 20, sigma for theta; (30) Delta F; (32) to (34) as (25) to (27)",
        correct="theta, Delta P; the left leg has the right leg's formulas",
        effect=f"all ten equations above as printed: {together}",
    )
    return (*found, index)


def _effect(number: int) -> str:
    """Effect of one equation, on the target that shows it."""
    found = miss(eros_joints, left_leg(), STEPPING, {number})
    if number == 11:
        behind = miss(eros_joints, left_leg(), STEPPING * [-1.0, 1.0, 1.0], {number})
        return f"none ahead; a foot behind: {behind}; at Px = 0 it divides by zero"
    if number in (12, 13):
        both = miss(eros_joints, left_leg(), STEPPING, {12, 13})
        return f"{found}; with its twin as printed too: {both}"
    if number == 22:
        unequal = miss(eros_joints, left_leg(UNEQUAL), STEPPING, {number})
        return f"none for equal links; thigh 110 mm, shank 100 mm: {unequal}"
    if number == 27:
        standing = miss(eros_joints, left_leg(), CROUCH, {number})
        return f"{found}; standing: {degrees(standing.tilt):.1f} degrees"
    return str(found)
