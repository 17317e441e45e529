"""What the mistakes of the EROS paper amount to; `printed/eros.yaml` names these functions.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from itertools import pairwise
from math import degrees, pi, radians

import numpy as np

from gaitlab.gaits.eros import Gait, deceleration_increments
from gaitlab.kinematics.arm import hand_pose
from gaitlab.kinematics.head import camera_pose
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.papers.as_printed import EROS_EQUATIONS, Miss, eros_joints, miss
from gaitlab.papers.page import Numbers
from gaitlab.papers.printed import eros_tables, rows
from gaitlab.robots.eros import LegGeometry, Robot

STEPPING = np.array([0.040, 0.045, -0.228])  # m, sole from the hip: ahead, aside, crouched
CROUCH = np.array([0.0, 0.0, -0.228])  # m, sole from the hip when standing
UNEQUAL = LegGeometry(thigh=0.110, shank=0.100)  # shows what equal links hide


def left_leg(geometry: LegGeometry | None = None) -> Leg:
    """EROS's left leg, or one of other lengths."""
    robot = Robot()
    return Leg(geometry=geometry or robot.leg, ankle_height=robot.sole.height, side="left")


def left_handed() -> Numbers:
    """Error of the sole when the frame is read as it is printed, in mm."""
    joints = np.array([0.3, 0.2, -0.4, 0.8, -0.4, -0.2])
    turned = joints * [-1.0, -1.0, 1.0, 1.0, 1.0, -1.0]
    leg = left_leg()
    apart = leg.sole_pose(joints)[:3, 3] - leg.sole_pose(turned)[:3, 3]
    return {"off": 1e3 * np.linalg.norm(apart)}


def camera() -> Numbers:
    """Error of the camera over its range, in mm."""
    robot = Robot()
    look = np.random.default_rng(3).uniform([-2.0, -0.5], [2.0, 1.5], size=(2000, 2))
    printed = robot.head.camera * np.sin(look[:, 1]) ** 2
    return {"off": 1e3 * np.abs(printed - camera_pose(robot.head, look)[:, 1, 3]).max()}


def arm_column() -> Numbers:
    """Length of the first column of the printed rotation of the right hand."""
    generator = np.random.default_rng(3)
    generator.uniform([-2.0, -0.5], [2.0, 1.5], size=(2000, 2))  # the looks of `camera`
    arm = generator.uniform([-3.0, -0.2, -2.4], [3.0, 2.0, 0.0], size=(2000, 3))
    pose = hand_pose(Robot().arm, arm, "right")
    c, s = np.cos(arm), np.sin(arm)
    r11 = c[:, 0] * c[:, 2] - c[:, 1] * s[:, 0]
    length = np.sqrt(r11**2 + pose[:, 1, 0] ** 2 + pose[:, 2, 0] ** 2)
    return {"low": length.min(), "high": length.max()}


def left_hand() -> Numbers:
    """Error of the left hand with the right one's row, in mm."""
    return {"off": 2e3 * Robot().arm.shoulder_spacing}


def _miss(equations: Collection[int], sole: np.ndarray = STEPPING) -> Miss:
    """Where the sole lands when these equations of the leg stay as printed."""
    return miss(eros_joints, left_leg(), sole, equations)


def _equation(number: int) -> Numbers:
    return {"miss": _miss({number}), "both": _miss({12, 13})}


_Effect = Callable[[], Numbers]
equation_12: _Effect = partial(_equation, 12)
equation_13: _Effect = partial(_equation, 13)
equation_14: _Effect = partial(_equation, 14)
equation_15: _Effect = partial(_equation, 15)
equation_17: _Effect = partial(_equation, 17)
equation_23: _Effect = partial(_equation, 23)
equation_25: _Effect = partial(_equation, 25)


def heading() -> Numbers:
    """Equation (11) on a foot behind the hip."""
    return {"behind": _miss({11}, STEPPING * [-1.0, 1.0, 1.0])}


def unequal_links() -> Numbers:
    """Equation (22) on a leg whose links differ."""
    return {"unequal": miss(eros_joints, left_leg(UNEQUAL), STEPPING, {22})}


def level_ankle() -> Numbers:
    """Equation (27) while stepping, and the tilt while standing, in degrees."""
    return {"miss": _miss({27}), "standing": degrees(_miss({27}, CROUCH).tilt)}


def all_equations() -> Numbers:
    """All ten equations of the leg as printed."""
    return {"miss": _miss(EROS_EQUATIONS)}


def landing_start() -> Numbers:
    """Where a landing starts by (39) and (43), in drops and in m, for the lift in mm."""
    lift, times = Gait().step_height, abs(1.0 - np.sin(0.0) + 90.0)
    return {"times": times, "away": times * lift, "lift": 1e3 * lift}


def touchdown() -> Numbers:
    """Forward speed of a landing foot against the standing one, before touchdown, in m/s."""
    return {
        "printed": _touchdown(Gait(x_law="printed")),
        "quarter": _touchdown(Gait(x_law="quarter")),
    }


def _touchdown(gait: Gait) -> float:
    t = gait.startup_time + np.arange(0.0, gait.gait_period, gait.control_period)
    feet = gait.feet(t + 1e-6)
    apart = feet.position[:, 1, 0] - feet.position[:, 0, 0]
    landing = int(np.flatnonzero(~feet.swing[:, 1] & np.roll(feet.swing[:, 1], 1))[0])
    return float((apart[landing] - apart[landing - 1]) / gait.control_period)


def lift_of_the_experiments() -> Numbers:
    """Knee angle in degrees and speed in rad/s that a lift of Z, in mm, would ask for."""
    lift = max(float(row["Z_mm"]) for row in rows("eros_experiments")) / 1e3
    raised = eros_joints(left_leg(), CROUCH + np.array([0.0, 0.0, lift]), ())[3]
    gait = Gait(step_height=lift)
    t = gait.startup_time + np.arange(0.0, gait.gait_period, gait.control_period)
    heights = gait.feet(t + 1e-6).position[:, 1, 2]
    knees = [eros_joints(left_leg(), np.array([0.0, 0.0, z]), ())[3] for z in heights]
    speed = np.abs(np.diff(knees)).max() / gait.control_period
    increment = degrees(gait.tick_increment)
    return {"lift": 1e3 * lift, "knee": degrees(raised), "speed": speed, "increment": increment}


def toe() -> Numbers:
    """How far the printed heel strike leaves the toe up with level feet, in degrees."""
    soles = (CROUCH, np.array([0.04, 0.0, -0.228]))
    up = [degrees(-eros_joints(left_leg(), sole, ())[2]) for sole in soles]
    return {"low": min(up), "high": max(up)}


def deceleration() -> Numbers:
    """Mean increment of the three laws on offer, in degrees a tick."""
    increment, areas, gain = 4.0 * pi / 180.0, 5, 0.7
    kinds = ("log_tail", "linear", "log_front")
    laws = {kind: deceleration_increments(kind, increment, areas, gain) for kind in kinds}
    return {kind: degrees(float(found.mean())) for kind, found in laws.items()}


def distances() -> Numbers:
    """Nine of the longest printed steps, in m, and how far the falls lie apart, in mm."""
    walks = [row for row in rows("eros_experiments") if row["optimization"] == "without"]
    falls = sorted(float(row["distance_mm"]) for row in walks)
    longest = max(float(row["X_mm"]) for row in walks)
    apart = ", ".join(f"{b - a:.0f}" for a, b in pairwise(falls))
    return {"step": longest, "nine": 9 * longest / 1e3, "apart": apart}


def reach() -> Numbers:
    """Longest step that both feet reach in the standing crouch, in cm."""
    leg = Robot().leg
    down = -CROUCH[2] - Robot().sole.height
    half = np.sqrt((leg.thigh + leg.shank) ** 2 - down**2)
    return {"reach": 200.0 * half}


def backward_block() -> Numbers:
    """Backward cells that Tables 7 and 8 print alike."""
    plain, best = eros_tables()
    backward = [place for place in plain.cells if place.direction == "backward"]
    same = sum(plain.cells[place] == best.cells[place] for place in backward)
    return {"same": same, "cells": len(backward)}


def gain() -> Numbers:
    """Efficiency of Table 7 and the gain of Table 8 over it, stated and counted, in percent."""
    plain, best = eros_tables()
    stated = [float(table.content.stated_mean or 0.0) for table in (plain, best)]
    return {
        "stated": stated[0],
        "counted": plain.counted_mean,
        "gain": best.counted_mean - plain.counted_mean,
        "stated_gain": stated[1] - stated[0],
    }


def constants() -> Numbers:
    """The gait's own: lift in mm a degree of heel strike, deceleration gain and areas."""
    gait = Gait()
    lift = radians(1e3 * gait.heel_gain)
    return {"lift": lift, "gain": gait.deceleration_gain, "areas": gait.deceleration_areas}
