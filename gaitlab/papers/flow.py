"""Audit of the FLoW paper: it prints equations and two numbers, so its equations are checked.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from math import degrees
from typing import Literal

import numpy as np

from gaitlab.gaits.flow import Gait
from gaitlab.kinematics.dh import dh_transform
from gaitlab.kinematics.parallelogram import dh_sole_pose, serial_joints, sole_pose
from gaitlab.log import TrialLog
from gaitlab.model.settings import EngineSettings, Horizon, Spread
from gaitlab.papers import flow_effects
from gaitlab.papers.as_printed import printed_tip_error
from gaitlab.papers.flow_effects import STANDING
from gaitlab.papers.page import (
    Page,
    PrintedNumber,
    PrintedTable,
    Table,
    assumptions_of,
    errata_of,
    text_of,
)
from gaitlab.papers.printed import rows as rows_of
from gaitlab.robots.flow import Robot
from gaitlab.servos.files import load_servo
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Names, Trial, plugin
from gaitlab.surfaces.files import load_surface

MODELS: tuple[Literal["serial"], Literal["geared"]] = ("serial", "geared")  # of the parallelograms
SURFACE = "carpet_4mm"
ITERATIONS = 200  # of the solver; with 50 the gears of a loaded leg do not converge
STAND = 0.3  # s, standing before the walk


def audit() -> Page:
    """The page of the FLoW paper."""
    robot = Robot()
    printed = {row["quantity"]: float(row["value"]) for row in rows_of("flow_facts")[:2]}
    torso, leg = robot.torso, robot.leg
    height = robot.sole.height + leg.shank + leg.thigh + leg.hip_drop + torso.waist_height
    height += torso.shoulder_height + torso.neck_height + torso.neck + torso.eyes + torso.crown
    rows = (
        PrintedNumber(label="height, cm", printed=printed["height"], ours=100.0 * height),
        PrintedNumber(label="mass, kg", printed=printed["mass"], ours=round(robot.tree.mass, 9)),
    )
    facts = PrintedTable(title="Published numbers", unit="-", digits=1, rows=rows)
    return Page(
        title=text_of("flow", "title"),
        paper=text_of("flow", "paper"),
        summary=text_of("flow", "summary"),
        comparisons=(facts, _joint_counts()),
        tables=(_identities(), _lengths(), parallelogram_table()),
        errata=errata_of("flow", flow_effects),
        assumptions=assumptions_of("flow"),
    )


def _joint_counts() -> PrintedTable:
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
        PrintedNumber(
            label=f"{row['body_part']}, {row['where']}",
            printed=int(row["dof_as_printed"]),
            ours=ours[row["body_part"]][0],
            note=_unless_equal(row["dof_as_printed"], *ours[row["body_part"]]),
        )
        for row in rows_of("flow_dof_claims")
    ]
    title = "Degrees of freedom, which the paper counts in different ways"
    return PrintedTable(title=title, unit="-", digits=0, rows=rows)


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


def parallelogram_table() -> Table:
    """How well each model keeps the soles parallel to the pelvis, and what carries that."""
    return Table(
        title="Parallelograms by the ankle's command and by gears",
        text=(
            f"Start-up and one cycle of the walk on {SURFACE}, {ITERATIONS} iterations of the "
            "solver. Rods would let no sole pitch against the pelvis; with a commanded ankle it "
            "pitches by what the loaded hip and knee give way. The ankle's torque is what rods "
            "carry; gears carry it without a motor."
        ),
        header=("model", "largest sole pitch [degrees]", "ankle torque [N m]", "distance [m]"),
        rows=[_row(model) for model in MODELS],
    )


def _row(model: Literal["serial", "geared"]) -> tuple[str, ...]:
    robot = Robot(parallelogram=model)
    log = simulate(_trial(robot))
    pitch = np.degrees(sole_pitch(robot, log).max())
    torque = np.abs(log.arrays["left_ankle_pitch_torque"]).max()
    walked = log.arrays["trunk_x"][-1] - log.arrays["trunk_x"][0]
    carried = f"{torque:.1f}" if model == "serial" else "no motor"
    return model, f"{pitch:.2f}", carried, f"{walked:.2f}"


def sole_pitch(robot: Robot, log: TrialLog) -> np.ndarray:
    """Pitch of both soles against the pelvis, in [rad]. Shape (ticks, 2)."""
    columns = [log.arrays[f"{joint.name}_position"] for joint in robot.tree.joints]
    joints = np.stack(columns, axis=-1).astype(float)
    n = len(joints)
    poses = robot.tree.poses(np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), joints)
    feet = [robot.tree.index(name) for name in robot.feet]
    return np.abs(np.arcsin(poses.rotation[:, feet, 2, 0]))


def _trial(robot: Robot) -> Trial:
    servos = [load_servo(joint.servo) for joint in robot.tree.joints if joint.servo is not None]
    return Trial(
        robot=robot,
        gait=Gait(stand_time=STAND),
        surface=load_surface(SURFACE),
        servos=tuple(servos),
        engine=EngineSettings(solver_iterations=ITERATIONS),
        horizon=Horizon(cycles=1.0),
        spread=Spread(friction=0.0, servo_gain=0.0, tilt=0.0, position=0.0, terrain=0.0),
        seed=0,
        names=Names(robot="flow", gait="flow", surface=SURFACE),
        robot_code=plugin("robot", "flow"),
        gait_code=plugin("gait", "flow"),
    )
