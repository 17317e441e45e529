"""What is wrong in print in the EROS paper, each mistake with the size of its effect.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from itertools import pairwise
from math import degrees, pi

import numpy as np

from gaitlab.gaits.eros import Gait, deceleration_increments
from gaitlab.papers._eros_kinematics_errata import CROUCH, kinematics_errata, left_leg
from gaitlab.papers._printed_leg import eros_joints
from gaitlab.papers.page import Erratum
from gaitlab.papers.printed import eros_tables
from gaitlab.papers.printed import rows as rows_of
from gaitlab.robots.eros import Robot


def errata() -> tuple[Erratum, ...]:
    """Every mistake, in the paper's order."""
    return (
        *kinematics_errata(),
        *_gait_errata(),
        *_heel_errata(),
        _deceleration(),
        *_result_errata(),
    )


def _gait_errata() -> tuple[Erratum, ...]:
    lift = Gait().step_height
    literal = abs(1.0 - np.sin(0.0) + 90.0)
    speeds = {law: _touchdown_speed(law) for law in ("printed", "quarter")}
    return (
        Erratum(
            where="(39), (43)",
            printed="1 - sin(T) + 90",
            correct="1 - sin(T + 90 degrees) = 1 - cos T",
            effect=(
                f"at T = 0 a landing starts {literal:.0f} times its own drop away: "
                f"{literal * lift:.1f} m for a lift of {1e3 * lift:.0f} mm"
            ),
        ),
        Erratum(
            where="(37), (41) and the text",
            printed="x = 1 - cos T in all four steps; the text calls each a quarter circle",
            correct="cannot be decided: a landing's quarter ellipse needs x = sin T",
            effect=(
                f"speed of the swing foot over the ground at touchdown {speeds['printed']:.2f} m/s "
                f"as printed, {speeds['quarter']:.2f} m/s for the quarter ellipse"
            ),
        ),
        _lift_of_the_experiments(),
    )


def _touchdown_speed(x_law: str) -> float:
    """Forward speed of the landing foot against the standing one, before touchdown, in [m/s]."""
    gait = Gait(x_law="quarter" if x_law == "quarter" else "printed")
    t = gait.startup_time + np.arange(0.0, gait.gait_period, gait.control_period)
    feet = gait.feet(t + 1e-6)
    apart = feet.position[:, 1, 0] - feet.position[:, 0, 0]
    landing = int(np.flatnonzero(~feet.swing[:, 1] & np.roll(feet.swing[:, 1], 1))[0])
    return float((apart[landing] - apart[landing - 1]) / gait.control_period)


def _lift_of_the_experiments() -> Erratum:
    """Knee angle and speed that a lift of Z would ask for."""
    lift = max(float(row["Z_mm"]) for row in rows_of("eros_experiments")) / 1e3
    raised = eros_joints(left_leg(), CROUCH + np.array([0.0, 0.0, lift]), ())[3]
    gait = Gait(step_height=lift)
    t = gait.startup_time + np.arange(0.0, gait.gait_period, gait.control_period)
    heights = gait.feet(t + 1e-6).position[:, 1, 2]
    knees = [eros_joints(left_leg(), np.array([0.0, 0.0, z]), ())[3] for z in heights]
    speed = np.abs(np.diff(knees)).max() / gait.control_period
    return Erratum(
        where="Figs 24 to 28",
        printed=f"Z up to {1e3 * lift:.0f} mm",
        correct="cannot be decided; a lift it cannot be",
        effect=(
            f"a knee of {degrees(raised):.0f} degrees and {speed:.0f} rad/s at "
            f"{degrees(gait.tick_increment):.0f} degrees a tick, beyond the servos assumed"
        ),
    )


def _heel_errata() -> tuple[Erratum, ...]:
    crouch = eros_joints(left_leg(), CROUCH, ())
    stepping = eros_joints(left_leg(), np.array([0.04, 0.0, -0.228]), ())
    left = [degrees(-joints[2]) for joints in (crouch, stepping)]
    return (
        Erratum(
            where="(46), (47)",
            printed="ankle pitch from the knee's angle, which the text defines theta 4 to be",
            correct="cannot be decided; added to the level ankle it does what the text says",
            effect=(
                f"with the feet level it leaves the toe {min(left):.0f} to {max(left):.0f} degrees "
                "up"
            ),
        ),
        Erratum(
            where="(47)",
            printed="the height difference without a prime",
            correct="the difference at the collision",
            effect="at nominal touchdown the right one is 0, so heel strike is off just then",
        ),
    )


def _deceleration() -> Erratum:
    increment, areas, gain = 4.0 * pi / 180.0, 5, 0.7
    means = {
        kind: degrees(float(deceleration_increments(kind, increment, areas, gain).mean()))
        for kind in ("log_tail", "linear", "log_front")
    }
    listed = ", ".join(f"{kind} {mean:.2f}" for kind, mean in means.items())
    return Erratum(
        where="after (48)",
        printed="the equation of T_mn,DC(n) is missing",
        correct="cannot be known; three laws that use its symbols are on offer",
        effect=f"mean increment of 4 degrees a tick, 5 areas, gain 0.7: {listed} degrees a tick",
    )


def _result_errata() -> tuple[Erratum, ...]:
    walks = [row for row in rows_of("eros_experiments") if row["optimization"] == "without"]
    falls = sorted(float(row["distance_mm"]) for row in walks)
    apart = ", ".join(f"{b - a:.0f}" for a, b in pairwise(falls))
    longest = max(float(row["X_mm"]) for row in walks)
    plain, best = eros_tables()
    backward = [
        (plain.cells[place], best.cells[place])
        for place in plain.cells
        if place.direction == "backward"
    ]
    same = sum(a == b for a, b in backward)
    reach = _reach()
    stated = [float(table.content.stated_mean or 0.0) for table in (plain, best)]
    counted = [table.counted_mean for table in (plain, best)]
    return (
        Erratum(
            where="Figs 24 to 28",
            printed="6 m in 9 steps of 8 to 24 mm",
            correct="cannot be decided; the axis may be time",
            effect=(
                f"nine steps of {longest:.0f} mm are {9 * longest / 1e3:.2f} m; the falls lie "
                f"{apart} mm apart whatever the step"
            ),
        ),
        Erratum(
            where="Tables 7, 8",
            printed="distance in cm, in mm in the experiments",
            correct="cannot be decided; here the travel of the swing foot in cm, 2 step lengths",
            effect=f"as step lengths in cm, all above {100.0 * reach:.0f} cm are out of reach",
        ),
        Erratum(
            where="Table 7",
            printed="backward rows",
            correct="probably a copy of Table 8's",
            effect=f"{same} of {len(backward)} backward cells are equal in both tables",
        ),
        Erratum(
            where="text on Table 7",
            printed=f"efficiency {stated[0]:.0f} %",
            correct=f"{counted[0]:.0f} % by the printed table",
            effect=(
                f"the gain is {counted[1] - counted[0]:.0f} points, not {stated[1] - stated[0]:.0f}"
            ),
        ),
        Erratum(
            where="Table 8",
            printed='captioned "without", called Table 5 once',
            correct="with optimisation",
            effect="none, a caption",
        ),
    )


def _reach() -> float:
    """Longest step that both feet reach in the standing crouch, in [m]."""
    leg = Robot().leg
    down = -CROUCH[2] - Robot().sole.height
    half = np.sqrt((leg.thigh + leg.shank) ** 2 - down**2)
    return float(2.0 * half)
