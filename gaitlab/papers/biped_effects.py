"""What [Siswoyo2008] prints, evaluated: its boundary angles, and what its mistakes amount to.

`printed/biped.yaml` names the functions of the mistakes.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees

import numpy as np

from gaitlab.gaits.biped import Gait
from gaitlab.kinematics.belt_leg import ankle_position, stride_angles
from gaitlab.kinematics.blend import blended_segment
from gaitlab.papers.page import Numbers, PrintedNumber, PrintedTable
from gaitlab.papers.printed import rows
from gaitlab.robots.biped import Robot
from gaitlab.servos.files import load_servo

WALK = Gait(full_strides=1, stand_time=0.0)  # the figures' walk; lengths and times are assumptions
PRINTED = replace(WALK, ending="printed", lift="printed")
_THETA = "asin(S/(2l))"
_LIFT = "acos((sqrt((2l)^2-(S/2)^2)-h)/(2l))"
_EXACT = "acos(cos(th/2)-h/(2l))"


def printed_angles(gait: Gait) -> dict[str, float]:
    """Every expression that the paper prints or needs, in [rad]."""
    lengths = gait.step_length, gait.step_height, gait.segment
    exact, printed = stride_angles(*lengths), stride_angles(*lengths, lift="printed")
    theta, thigh, shank = exact.touchdown, exact.ending_thigh, exact.ending_shank
    return {
        **{"0": 0.0, "0 and 0": 0.0, _THETA: theta, f"-{_THETA}": -theta},
        **{_LIFT: printed.lift, _EXACT: exact.lift, "phi_1,1=+psi, phi_1,2=-psi": exact.lift},
        **{"-(asin((S/2)/P)-acos(P/2l))": thigh, "-(A-B)": thigh},
        **{"-(asin((S/2)/P)+acos(P/2l))": shank, "-(A+B)": shank},
    }


def boundary_angles() -> PrintedTable:
    """The printed boundary conditions at the assumed lengths."""
    angles = printed_angles(WALK)
    table = []
    for row in rows("biped_boundary_conditions"):
        printed, ours = (angles.get(row[key]) for key in ("printed_value", "corrected_value"))
        table.append(
            PrintedNumber(
                label=f"{row['stride']}, {row['leg']}, {row['joint']} at {row['printed_time']}",
                printed=None if printed is None else degrees(printed),
                ours=None if ours is None else degrees(ours),
                note="" if row["note"].startswith("ok") else row["note"],
            )
        )
    title = (
        f"Boundary angles of the strides (section III.A) for S = {WALK.step_length} m, "
        f"l = {WALK.segment} m, h = {WALK.step_height} m"
    )
    return PrintedTable(title=title, unit="deg", digits=3, rows=table)


def lowest_point(gait: Gait) -> float:
    """Lowest that the trailing foot gets in an ending stride, in [m]; 0 is the floor."""
    start = gait.duration - gait.half_stride
    t = start + np.linspace(0.0, gait.half_stride, 4001)
    ankle = ankle_position(gait.joint_motion(t).position, gait.segment)
    height = ankle[..., 1] - ankle[:, _supporting(gait), None, 1]
    return float(height.min())


def _supporting(gait: Gait) -> int:
    """Leg that supports the ending stride: the one that landed last."""
    return (gait.full_strides + 1) % 2


def lift() -> Numbers:
    """Lift of the foot as printed and as it should be, in mm."""
    half = np.cos(WALK.angles.touchdown / 2.0)
    low = 2.0 * WALK.segment * (half - np.cos(PRINTED.angles.lift))
    return {"low": 1e3 * low, "high": 1e3 * WALK.step_height}


def early_lift() -> Numbers:
    """Lift of the foot when it is lifted at t_f, in mm."""
    return {"early": 2e3 * WALK.segment * (1.0 - np.cos(WALK.angles.lift))}


def straight_leg() -> Numbers:
    """How far ahead of the hips the foot of a straight leg is, in m."""
    return {"ahead": float(ankle_position(np.full(2, PRINTED.angles.lift), WALK.segment)[0])}


def second_interval() -> Numbers:
    """What the relation of the ending stride is off by, in degrees."""
    return {"off": degrees(abs(WALK.angles.ending_thigh + WALK.angles.ending_shank))}


def last_foot() -> Numbers:
    """Height of a foot at the end of the walk, in mm."""
    return {"high": 2e3 * WALK.segment * (1.0 - np.cos(WALK.angles.touchdown))}


def trailing_foot() -> Numbers:
    """How deep the trailing foot digs as printed and as corrected, in mm."""
    return {"printed": -1e3 * lowest_point(PRINTED), "corrected": abs(1e3 * lowest_point(WALK))}


def _first_lift() -> tuple[float, float]:
    """Speed in rad/s and length of the blend in s of the first lift."""
    change, duration = WALK.angles.lift, 0.5 * WALK.half_stride
    speed = WALK.speed_ratio * change / duration
    return speed, duration - change / speed


def first_blend() -> Numbers:
    """Speed that is reached and wanted in rad/s, and jump of the acceleration in rad/s^2."""
    speed, blend = _first_lift()
    return {"reached": 3.0 * speed + 2.0 * speed, "speed": speed, "jump": 12.0 * speed / blend}


def linear_part() -> Numbers:
    """Jump of the position at t_b, in degrees."""
    speed, blend = _first_lift()
    return {"jump": degrees(speed * blend)}


def duration() -> Numbers:
    """Share of its angle that a segment of t_f/2 covers in the time of t_f, in percent."""
    t = 0.5 * WALK.half_stride
    half = blended_segment(np.array([t]), 0.0, 1.0, 2.0 * t, 0.5 / t * 1.3)
    return {"share": 100.0 * float(half.position[0])}


def motor() -> Numbers:
    """Torque at rest in N m and speed without load in rad/s."""
    found = load_servo("biped_motor")
    return {"torque": found.stall_torque, "speed": found.no_load_speed}


def mass() -> Numbers:
    """Mass of the robot, in kg."""
    return {"mass": Robot().tree.mass}
