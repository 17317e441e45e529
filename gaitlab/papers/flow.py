"""Audit of the FLoW paper: it prints equations and two numbers, so its equations are checked.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from math import degrees

import numpy as np

from gaitlab.kinematics.dh import dh_transform
from gaitlab.kinematics.parallelogram import dh_sole_pose, serial_joints, sole_pose
from gaitlab.papers._flow_errata import STANDING, errata
from gaitlab.papers._parallelogram import parallelogram_table
from gaitlab.papers._printed_arm import printed_tip_error
from gaitlab.papers.page import Comparison, Page, Row, Table
from gaitlab.papers.printed import rows as rows_of
from gaitlab.robots.flow import Robot

PAPER = (
    "Luky Yanto, Raden Sanggar Dewanto, Dadet Pramadihanto, Eko Henfri Binugroho, *Teen-Size "
    'Humanoid "FLoW" Complete Analytical Kinematics*, Politeknik Elektronika Negeri Surabaya, no '
    "year printed."
)
SUMMARY = (
    "The paper publishes two numbers, height and mass, and no link length, joint range, pose or "
    "error figure, so there is no result to reproduce. What can be checked are its equations. The "
    "transform of a joint (1), the inverse kinematics of the head (8, with one repair in 9), of "
    "the arm's first three joints (15 to 17) and the leg's heading (25 to 29) are right; the arm's "
    "forward kinematics (12 to 14) is right after three repairs. The head's forward kinematics (5 "
    "to 7) describes another head, the leg's (22 to 24) cannot be recovered, and the leg's inverse "
    "kinematics needs five repairs. How many joints an arm or a leg has cannot be decided from the "
    "text. Every effect below is computed with the assumed lengths."
)


def audit() -> Page:
    """The page of the FLoW paper."""
    return Page(
        title="FLoW: complete analytical kinematics of a teen-size humanoid",
        paper=PAPER,
        summary=SUMMARY,
        comparisons=(_facts(), _joint_counts()),
        tables=(_identities(), _lengths(), parallelogram_table()),
        errata=errata(),
        assumptions=ASSUMPTIONS,
    )


def _facts() -> Comparison:
    robot = Robot()
    printed = {row["quantity"]: float(row["value"]) for row in rows_of("flow_facts")[:2]}
    torso, leg = robot.torso, robot.leg
    height = robot.sole.height + leg.shank + leg.thigh + leg.hip_drop + torso.waist_height
    height += torso.shoulder_height + torso.neck_height + torso.neck + torso.eyes + torso.crown
    rows = (
        Row(label="height, cm", printed=printed["height"], ours=100.0 * height),
        Row(label="mass, kg", printed=printed["mass"], ours=round(robot.tree.mass, 9)),
    )
    return Comparison(title="Published numbers", unit="-", digits=1, rows=rows)


def _joint_counts() -> Comparison:
    """What the paper counts, part by part, beside the model's joints."""
    joints = [joint.name for joint in Robot().tree.joints]
    legs = sum("hip" in name or "knee" in name or "ankle" in name for name in joints)
    arm = sum(any(p in name for p in ("shoulder", "arm", "elbow")) for name in joints) // 2
    head = sum(name.startswith("head") for name in joints)
    ours = {
        "head": (head, ""),
        "hip": (4, "2 hip yaw and 2 hip roll here; print has 2 at the waist and 2 at the hip"),
        "legs": (legs - 4, "without hip yaw and roll"),
        "body incl. head": (head + 1, "waist yaw and head"),
        "arm": (arm, "7 with `robot.arm_joints: 7`"),
        "hand (arm)": (arm, "6 with `robot.arm_joints: 6`"),
        "down body (hip and leg)": (legs // 2, "a leg"),
        "foot (leg)": (legs // 2 - 1, "free joints a leg, the parallelograms take one"),
    }
    rows = [
        Row(
            label=f"{row['body_part']}, {row['where']}",
            printed=int(row["dof_as_printed"]),
            ours=ours[row["body_part"]][0],
            note=_unless_equal(row["dof_as_printed"], *ours[row["body_part"]]),
        )
        for row in rows_of("flow_dof_claims")
    ]
    title = "Degrees of freedom, which the paper counts in different ways"
    return Comparison(title=title, unit="-", digits=0, rows=rows)


def _unless_equal(printed: str, ours: int, note: str) -> str:
    """A note on how to get the printed count, where it is not the default."""
    return "" if int(printed) == ours and "robot." in note else note


def _identities() -> Table:
    """Largest difference between equations that must agree, over random joints."""
    generator = np.random.default_rng(1)
    leg, arm = Robot().leg_of("left"), Robot().arm_of("left")
    angles = generator.uniform(-1.2, 1.2, size=(2000, 5))
    joints = generator.uniform(-1.5, 1.5, size=(2000, 5))
    poses = arm.pose(joints)
    again = arm.pose(arm.pose_joints(poses)) - poses[:, None]
    serial = leg.sole_pose(serial_joints(angles))
    turn = dh_transform(np.array(0.0), 0.1, 0.2, 0.0)[:3, 3] - [0.2, 0.0, 0.1]
    found = {
        "(1) shifts by d along z and a along x": turn,
        "(12) to (14), repaired, against the product of the five rows": printed_tip_error(arm, ())[
            0
        ],
        "(15) to (17): arm to its joints and back, four branches": again,
        "(20): six rows against the leg's chain": dh_sole_pose(leg, serial_joints(angles)) - serial,
        "parallelograms against the leg's chain": sole_pose(leg, angles) - serial,
    }
    return Table(
        title="Equations that hold",
        text="Largest difference over 2000 random poses.",
        header=("equation", "difference [m]"),
        rows=[(label, f"{np.abs(error).max():.0e}") for label, error in found.items()],
    )


def _lengths() -> Table:
    """How the answer of a standing leg depends on lengths that nobody published."""
    rows = []
    for change in (-0.02, -0.01, 0.0, 0.01, 0.02):
        robot = Robot()
        leg = robot.leg_of("left")
        geometry = type(robot.leg)(thigh=robot.leg.thigh + change, shank=robot.leg.shank - change)
        changed = type(leg)(geometry=geometry, ankle_height=leg.ankle_height, side="left")
        joints = changed.flat_joints(changed.hip + STANDING, np.array(0.0))
        lengths = f"{1e3 * geometry.thigh:.0f}", f"{1e3 * geometry.shank:.0f}"
        rows.append((*lengths, *(f"{degrees(float(angle)):.2f}" for angle in joints[2:5])))
    return Table(
        title="What the unpublished lengths decide",
        text="Joints of the standing leg, 450 mm from hip to ankle, in degrees.",
        header=("thigh [mm]", "shank [mm]", "hip pitch", "knee", "ankle pitch"),
        rows=rows,
    )


ASSUMPTIONS = (
    ("every length", "see `gaitlab show flow`; equal leg links, the parts add up to 110 cm"),
    ("mass of the parts", "shares of the published 12.5 kg"),
    ("joint ranges", "those of robots of this size; thigh and shank at most 75 degrees ahead"),
    (
        "servos",
        "MX-106, in pairs but for the hip's yaw; one MX-106 cannot hold the robot on one leg",
    ),
    ("how many joints", "25, of which 23 are independent; arms of 6 or 7 as an option"),
    (
        "the parallelograms",
        "the sole stays parallel to the pelvis; by the ankle's command, or by gears in Bullet",
    ),
    ("joints 6 and 7 of the arm", "a wrist that bends and turns; no equation is printed"),
    ("a walk", "the paper has none; `gait: flow` is ours"),
    ("results", "none are printed, so nothing simulated agrees or disagrees with the paper"),
)
