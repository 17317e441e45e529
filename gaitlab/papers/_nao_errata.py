"""What is wrong in print in the NAO study, with the size of each error as our equations give it.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, degrees, pi

import numpy as np

from gaitlab.gaits.nao import Gait, lateral_profile
from gaitlab.kinematics.fsr import foot_zmp, normalised, sensor_loads
from gaitlab.kinematics.slanted_leg import LegAngles, geometric_angles
from gaitlab.papers.page import Erratum
from gaitlab.robots.nao import Robot

FINE = np.linspace(0.0, 1.0, 100_001)  # shares of a step


def printed_foot(s: float, lift: float, t: np.ndarray, window: float) -> np.ndarray:
    """Left foot x and z of [Shaari2015] eq. (2.1) with T = 1 and a window of -1 or 1, in [m].

    Shape (n, 2); t counts from the start of the cycle as printed.
    """
    x = 0.5 * s * np.sin(pi * (t - 0.5)) * window
    return np.stack([x, lift * np.sin(pi * (x / s + 0.5)) * window], axis=-1)


def standing(leg: float, h: float) -> LegAngles:
    """Leg of two equal links when standing h below its length, in [m]."""
    return geometric_angles(np.array([0.0, 0.0, h - leg]), leg / 2.0, leg / 2.0)


def printed_hip_pitch(angles: LegAngles, opposite: str) -> float:
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


def errata(gait: Gait, robot: Robot, leg: float, h: float) -> Iterator[Erratum]:
    """Everything wrong in print, equation by equation.

    Args:
        gait: The gait at the paper's final setting.
        robot: NAO.
        leg: L1 + L2 of the paper, in [m].
        h: Bending height of the paper's final setting, in [m].
    """
    yield from _foot_errata(gait)
    yield from _hip_errata(gait)
    yield from _leg_errata(gait, leg, h)
    yield from _sensor_errata(robot)
    yield Erratum(
        where="text, bending height h",
        printed="the constant height between waist and ground",
        correct="how far the hips are lowered from straight legs: PHz = L1 + L2 - h",
        effect=f"hips {1000.0 * h:.0f} mm over the ground instead of over the ankles by "
        f"{1000.0 * (leg - h):.0f} mm",
    )
    yield Erratum(
        where="text of experiments 2 and 3",
        printed="results in Figure 9; the final run in Chart 6",
        correct="Charts 3 and 4; Chart 7",
        effect="wrong reference; there is no Figure 9",
    )


def _foot_errata(gait: Gait) -> Iterator[Erratum]:
    s, lift = 2.0 * gait.step_length, gait.step_height
    second = 1.0 + FINE
    printed = printed_foot(s, lift, second, -1.0)
    flipped = printed_foot(s, lift, second, 1.0)
    yield Erratum(
        where="(2.1) window",
        printed="u(t - 2T) - u(t - T), which is -1 in the second step",
        correct="u(t - T) - u(t - 2T), with tau = t - T in the sine",
        effect=f"the left foot goes {-1000.0 * printed[:, 1].min():.0f} mm under ground; with the "
        f"sign alone corrected it steps {1000.0 * (flipped[0, 0] - flipped[-1, 0]):.0f} mm "
        "backwards",
    )
    yield Erratum(
        where="(2.1), (2.2) y",
        printed="left foot at -w, right foot at +w while it swings",
        correct="+w and -w for y to the left, as PHy has it",
        effect=f"the feet would cross by {2000.0 * gait.step_width:.0f} mm",
    )


def _hip_errata(gait: Gait) -> Iterator[Erratum]:
    printed = lateral_profile("printed", FINE)
    moved = 0.5 * gait.step_length * (np.sin(pi * 1.5) - np.sin(pi * 0.5))
    yield Erratum(
        where="(2.4) x, (2.5)",
        printed="t in the sine of every step, or tau = T - t",
        correct="tau = t - nT in every equation and a sign for the side",
        effect=f"in the second step the hips run back {-1000.0 * moved:.0f} mm",
    )
    yield Erratum(
        where="(2.4) y",
        printed="F sin(pi/2 (sin(pi t/2T) + 1)) sin(pi t/T)",
        correct="unknown; F sin(pi/2 sin(pi tau/T)) and two others that reach F in the middle",
        effect=f"the shift peaks at {printed.max():.3f} F, {FINE[printed.argmax()]:.3f} T into "
        f"the step: {1000.0 * gait.lateral_sway * (1.0 - printed.max()):.0f} mm short",
    )


def _leg_errata(gait: Gait, leg: float, h: float) -> Iterator[Erratum]:
    angles = standing(leg, h)
    right = -degrees(angles.hip_pitch)
    literal, mixed = (
        round(degrees(printed_hip_pitch(angles, kind)), 6) + 0.0 for kind in ("acos", "asin")
    )
    middle = gait.feet(np.array([gait.startup_time + 0.25 * gait.gait_period])).position[0, 0]
    shift = middle[1] - 0.5 * gait.step_width
    roll = degrees(np.arctan2(shift, leg - h))
    yield Erratum(
        where="(2.8) theta B, theta D",
        printed="acos(L1 sin(theta A) / L1)",
        correct="asin(L1 sin(theta A) / Lleft), and Lright for D",
        effect=f"standing hip pitch {literal:.1f} instead of {right:.1f} degrees; with asin in "
        f"(2.8) but (2.11) as printed {mixed:.1f} degrees",
    )
    yield Erratum(
        where="(2.9)",
        printed="theta 1 = atan(yl / zl) with zl < 0",
        correct="NAO's hip roll is atan2(y, -z), ankle roll its negative",
        effect=f"wrong sign in NAO's axes: {-roll:.1f} instead of {roll:.1f} degrees in mid-step",
    )
    yield Erratum(
        where="(2.11) text",
        printed="(2.8) for the left leg, (2.9) for the right",
        correct="the two halves of (2.8)",
        effect="wrong reference",
    )
    yield Erratum(
        where="(2.12)",
        printed="theta 11 = theta 10 - theta 11",
        correct="theta 11 = theta 10 - theta 9",
        effect=f"half the knee, {degrees(angles.knee_pitch) / 2.0:.2f} degrees: right when "
        "standing on equal links, wrong as soon as the foot is ahead",
    )


def _sensor_errata(robot: Robot) -> Iterator[Erratum]:
    example = (0.05, -0.02)
    found = float(normalised(*(np.array(x) for x in example)))
    sensors = np.stack([robot.sole.sensors(foot) for foot in range(2)])
    quiet = sensors.mean(axis=1)[:, 1]
    yield Erratum(
        where="(2.15), first line",
        printed="F3 (y1 - y) - F4 (y2 - y) = 0",
        correct="F3 (y1 - y) - F4 (y2 + y) = 0; the solution below it is right",
        effect="a sign; the printed solution does not follow from it",
    )
    yield Erratum(
        where="(2.15), one arm y2 a foot",
        printed="front and rear sensors at one distance",
        correct="sum of f_i y_i over sum of f_i",
        effect=f"up to {1000.0 * lateral_arm_error(robot):.1f} mm",
    )
    yield Erratum(
        where="(2.17) as a criterion",
        printed="stable if and only if the normalised ZMP lies between -1 and 1",
        correct="the ZMP lies inside the support polygon; the value only says which foot is loaded",
        effect=f"one foot in the air is always 1 or -1; x of {example[0]} and {example[1]} m, both "
        f"inside their soles, give {found:.2f}; quiet standing has y of {1000.0 * quiet[0]:+.1f} "
        f"and {1000.0 * quiet[1]:+.1f} mm, 0 / 0",
    )
