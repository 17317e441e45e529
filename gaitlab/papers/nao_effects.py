"""What the mistakes of the NAO study amount to; `printed/nao.yaml` names these functions.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import asin, degrees, pi

import numpy as np

from gaitlab.gaits.nao import Gait, lateral_profile
from gaitlab.kinematics.fsr import foot_zmp, normalised, sensor_loads
from gaitlab.kinematics.slanted_leg import SlantedLegAngles, geometric_angles
from gaitlab.papers.page import Numbers
from gaitlab.papers.printed import rows
from gaitlab.robots.nao import Robot

FINE = np.linspace(0.0, 1.0, 100_001)  # shares of a step


def straight(robot: Robot) -> float:
    """Height of the hips over the soles on straight legs, where h is 0, in [m]."""
    return robot.leg.thigh + robot.leg.tibia + robot.sole.height


def final(column: str) -> float:
    """Number of Table 6, in [m]."""
    return float(rows("nao_table6")[0][column])


def paper_leg() -> float:
    """L1 + L2 of Table 1, in [m]."""
    return sum(float(row["Values"].split()[0]) for row in rows("nao_table1")[:2])


def final_gait() -> Gait:
    """Table 6 on NAO's own legs, with the period of the shipped experiments, T = 1 s."""
    return Gait(
        step_length=final("Step length (m)") / 2.0,
        hip_height=straight(Robot()) - final("Bending Height (m)"),
        step_height=final("Lifting Height (m)"),
        lateral_sway=final("Frontal Shift (m)"),
        gait_period=2.0,
    )


def fifteen(robot: Robot) -> Iterator[Gait]:
    """The settings of Tables 3, 4 and 5."""
    for number in (3, 4, 5):
        for row in rows(f"nao_table{number}"):
            yield replace(
                final_gait(),
                step_length=float(row["Step length (m)"]) / 2.0,
                hip_height=straight(robot) - float(row["Bending Height (m)"]),
                step_height=float(row["Lifting Height (m)"]),
                lateral_sway=float(row["Frontal Shift (m)"]),
            )


def printed_foot(s: float, lift: float, t: np.ndarray, window: float) -> np.ndarray:
    """Left foot x and z of [Shaari2015] eq. (2.1) with T = 1 and a window of -1 or 1, in [m].

    Shape (n, 2); t counts from the start of the cycle as printed.
    """
    x = 0.5 * s * np.sin(pi * (t - 0.5)) * window
    return np.stack([x, lift * np.sin(pi * (x / s + 0.5)) * window], axis=-1)


def standing(leg: float, h: float) -> SlantedLegAngles:
    """Leg of two equal links when standing h below its length, in [m]."""
    return geometric_angles(np.array([0.0, 0.0, h - leg]), leg / 2.0, leg / 2.0)


def printed_hip_pitch(angles: SlantedLegAngles, opposite: str) -> float:
    """Hip pitch of eq. (2.11) while standing, in [rad], B as an `acos` as printed or an `asin`."""
    inside = float(angles.knee_inside)
    b = asin(np.sin(inside))
    if opposite == "acos":
        b = pi / 2.0 - b
    elif opposite == "asin":
        b = float(angles.thigh_to_line)
    return pi / 2.0 - inside + b


def lateral_arm_error(robot: Robot) -> float:
    """Largest error of eq. (2.15) with one mean rear and front arm a side, in [m]."""
    sensors = robot.sole.sensors(0)
    shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 21)] * 2), axis=-1).reshape(-1, 2)
    corners = np.stack([sensors.min(axis=0), sensors.max(axis=0)])
    loads = sensor_loads(
        np.ones(len(shares)), corners[0] + shares * (corners[1] - corners[0]), sensors
    )
    arm_left, arm_right = sensors[[0, 2], 1].mean(), sensors[[1, 3], 1].mean()
    one_arm = loads[:, [0, 2]].sum(axis=1) * arm_left + loads[:, [1, 3]].sum(axis=1) * arm_right
    return float(np.abs(one_arm - foot_zmp(loads, sensors)[:, 1]).max())


def window() -> Numbers:
    """How far the left foot goes under ground, and back with the sign alone corrected, in mm."""
    gait = final_gait()
    walks = (printed_foot(2.0 * gait.step_length, gait.step_height, 1.0 + FINE, w) for w in (-1, 1))
    printed, flipped = walks
    return {"under": -1e3 * printed[:, 1].min(), "back": 1e3 * (flipped[0, 0] - flipped[-1, 0])}


def sides() -> Numbers:
    """By how much the feet would cross, in mm."""
    return {"crossed": 2e3 * final_gait().step_width}


def hips() -> Numbers:
    """How far the hips run back in the second step, in mm."""
    moved = 0.5 * final_gait().step_length * (np.sin(pi * 1.5) - np.sin(pi * 0.5))
    return {"back": -1e3 * moved}


def shift() -> Numbers:
    """Peak of the printed shift in F, when in T, and how short it falls in mm."""
    printed = lateral_profile("printed", FINE)
    peak = printed.max()
    short = 1e3 * final_gait().lateral_sway * (1.0 - peak)
    return {"peak": peak, "at": FINE[printed.argmax()], "short": short}


def _standing() -> SlantedLegAngles:
    return standing(paper_leg(), final("Bending Height (m)"))


def hip_pitch() -> Numbers:
    """Hip pitch while standing as printed, half corrected and right, in degrees."""
    angles = _standing()
    kinds = ("acos", "asin")
    wrong = {k: round(degrees(printed_hip_pitch(angles, k)), 6) + 0.0 for k in kinds}
    return {**wrong, "right": -degrees(angles.hip_pitch)}


def hip_roll() -> Numbers:
    """Hip roll in mid-step, in degrees."""
    gait = final_gait()
    middle = gait.feet(np.array([gait.startup_time + 0.25 * gait.gait_period])).position[0, 0]
    moved = middle[1] - 0.5 * gait.step_width
    roll = degrees(np.arctan2(moved, paper_leg() - final("Bending Height (m)")))
    return {"printed": -roll, "right": roll}


def knee() -> Numbers:
    """Half the knee's angle while standing, in degrees."""
    return {"half": degrees(_standing().knee_pitch) / 2.0}


def lateral_arm() -> Numbers:
    """Error of one arm for both sensors of a side, in mm."""
    return {"off": 1e3 * lateral_arm_error(Robot())}


def criterion_limits() -> Numbers:
    """Normalised ZMP of two feet loaded inside their soles, and quiet standing's two y in mm."""
    found = float(normalised(np.array(0.05), np.array(-0.02)))
    quiet = [1e3 * Robot().sole.sensors(foot).mean(axis=0)[1] for foot in range(2)]
    return {"found": found, "left": quiet[0], "right": quiet[1]}


def bending() -> Numbers:
    """Height of the hips over the ground by the text, over the ankles by the equations, in mm."""
    low = final("Bending Height (m)")
    return {"low": 1e3 * low, "high": 1e3 * (paper_leg() - low)}
