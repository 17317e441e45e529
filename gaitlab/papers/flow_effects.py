"""What the mistakes of the FLoW paper amount to; `printed/flow.yaml` names these functions.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import degrees

import numpy as np

from gaitlab.papers.as_printed import (
    flow_joints,
    head_miss,
    miss,
    pointing_error,
    printed_cosine,
    printed_tip_error,
    roll_error,
    shoulder_sensitivity,
)
from gaitlab.papers.page import Numbers
from gaitlab.robots.flow import Robot

STANDING = np.array([0.0, 0.0, -0.51])  # m, sole from the hip: 0.45 m from hip to ankle
STEPPING = np.array([0.10, 0.03, -0.46])  # m, sole from the hip, a foot ahead and aside


def eyes() -> Numbers:
    """Error of the eyes within the head's range, in mm."""
    return {"off": 1e3 * head_miss(Robot().head_of())}


def tilt() -> Numbers:
    """Error of the head's tilt when looking aside, in degrees."""
    return {"off": degrees(pointing_error(Robot().head_of()))}


def _tip(equation: int) -> Numbers:
    """Error of the arm's tip with one equation as printed, in mm."""
    error = 1e3 * np.linalg.norm(printed_tip_error(Robot().arm_of("left"), (equation,)), axis=-1)
    return {"mean": error.mean(), "most": error.max()}


def _leg(equation: int) -> Numbers:
    """Error of a foot ahead and aside with one equation as printed."""
    return {"miss": miss(flow_joints, Robot().leg_of("left"), STEPPING, (equation,))}


_Effect = Callable[[], Numbers]
tip_12: _Effect = partial(_tip, 12)
tip_13: _Effect = partial(_tip, 13)
tip_14: _Effect = partial(_tip, 14)
leg_30: _Effect = partial(_leg, 30)
leg_32: _Effect = partial(_leg, 32)
leg_35: _Effect = partial(_leg, 35)
leg_36: _Effect = partial(_leg, 36)
leg_37: _Effect = partial(_leg, 37)
leg_38: _Effect = partial(_leg, 38)


def shoulder() -> Numbers:
    """Turn of q2 for 0.1 mm of Px near q1 = 90 degrees, in degrees."""
    return {"turn": degrees(shoulder_sensitivity(Robot().arm_of("left")))}


def hand() -> Numbers:
    """Mean error of q5, in degrees."""
    return {"turn": degrees(roll_error())}


def cosines() -> Numbers:
    """What (31) takes the arc cosine of, standing and stepping."""
    leg = Robot().leg_of("left")
    return {"cosines": ", ".join(f"{printed_cosine(leg, s):.2f}" for s in (STANDING, STEPPING))}


def folded() -> Numbers:
    """A leg with a long shank, deeply folded, where the arc sine of (34) picks the wrong angle."""
    robot = Robot()
    leg = robot.leg_of("left")
    geometry = type(robot.leg)(thigh=0.20, shank=0.26)
    long = type(leg)(geometry=geometry, ankle_height=leg.ankle_height, side="left")
    return {"miss": miss(flow_joints, long, np.array([0.0, 0.0, -0.12 - leg.ankle_height]), (34,))}


def offsets() -> Numbers:
    """What is never taken off a target, in mm."""
    leg = Robot().leg_of("left")
    return {"hip": 1e3 * float(np.hypot(leg.hip[1], leg.hip[2])), "ankle": 1e3 * leg.ankle_height}
