"""Audit of the NAO gait study: its tables, its equations, and its three choices simulated.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import degrees
from pathlib import Path

import numpy as np

from gaitlab.body import Robot as AnyRobot
from gaitlab.gaits.nao import Gait
from gaitlab.kinematics.fsr import foot_zmp, sensor_loads
from gaitlab.kinematics.slanted_leg import geometric_angles
from gaitlab.papers._nao_charts import pictures
from gaitlab.papers._nao_errata import errata
from gaitlab.papers._nao_sweeps import (
    PERIOD,
    Setting,
    criterion,
    settings,
    straight,
    sweeps,
    table,
    verdict,
)
from gaitlab.papers._planned_zmp import planned_zmp
from gaitlab.papers.page import Comparison, Page, Row, Table
from gaitlab.papers.printed import rows
from gaitlab.robots.nao import Robot

DATA = Path("data")
PERIODS = (0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)  # s, T of the planned ZMP
WITHIN = 1e-3  # m, rounding of what is called inside
LIMITED = ("hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")


def audit(store: Path = DATA) -> Page:
    """The page; a store without the sweeps gives a page that says which are missing."""
    robot, gait = Robot(), final_gait()
    found = {sweep.experiment: settings(sweep, store) for sweep in (*sweeps(), PERIOD)}
    leg, h = paper_leg(), final("Bending Height (m)")
    return Page(
        title="NAO: a parameter study of stable walking gaits",
        paper="N. Latif A. Shaari, M. R. B. Razali, M. F. Miskon and I. S. M. Isa, *Parameter "
        "study of stable walking gaits for NAO humanoid robot*. Gait after D. Goswami, walked in "
        "Webots, judged by a normalised ZMP.",
        summary=summary(found),
        comparisons=[_table_1(robot), _table_2(robot), _final_setting(gait)],
        errata=list(errata(gait, robot, leg, h)),
        assumptions=ASSUMPTIONS,
        tables=[
            *(table(sweep, found[sweep.experiment]) for sweep in sweeps()),
            table(PERIOD, found[PERIOD.experiment]),
            _knees(robot),
            _planned(robot, gait),
            _limits(robot),
        ],
        pictures=pictures(store),
    )


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


def summary(found: dict[str, list[Setting]]) -> str:
    """What agrees, what does not and what cannot be decided."""
    choices = "\n".join(f"- {verdict(sweep, found[sweep.experiment])}" for sweep in sweeps())
    return (
        "The paper prints no number of what it saw, only charts without data, no period and no "
        "number of runs. Its sensor positions, its settings and its equations, once corrected, "
        "hold together: all fifteen settings are within NAO's reach and joint limits. Its choices "
        "are judged here by whether the robot walks and by how much the load fluctuates when the "
        "feet exchange roles, over seeds that differ in friction, servo gain and first pose.\n\n"
        f"{criterion([setting for settings in found.values() for setting in settings])}\n\n"
        "## Which of the three choices the simulation supports\n\n"
        "Supported means: walks as often as any other setting, and its load fluctuates less than "
        "every other's, each beyond the 95 % interval of the difference paired by seed. Intervals "
        "are not corrected for their number, which favours the paper.\n\n"
        f"{choices}\n\n"
        f"{_period_sentence(found)}\n\n"
        "It was one factor at a time, and Experiment 1 already walked with the final F and s: "
        "only h was really selected. H was never varied. What Webots, its floor and its time step "
        "would have shown cannot be decided here."
    )


def _period_sentence(found: dict[str, list[Setting]]) -> str:
    periods = found[PERIOD.experiment]
    if not periods:
        return "What the period does has not been simulated yet: `gaitlab run nao_period`."
    counts = ", ".join(f"{s.walked} of {len(s.trials)} at T = {s.value:g} s" for s in periods)
    others = max(_spread(found[sweep.experiment]) for sweep in sweeps())
    more = _spread(periods) > others
    return (
        "The period, which the paper never gives, was swept as well: at the final setting NAO "
        f"walks in {counts}. That is a range of {100.0 * _spread(periods):.0f} % of the trials; "
        f"the three parameters that the paper varies come to {100.0 * others:.0f} % at most"
        + (", so the period decides more than any of them." if more else ".")
    )


def _spread(found: list[Setting]) -> float:
    shares = [setting.share for setting in found]
    return max(shares, default=0.0) - min(shares, default=0.0)


def _table_1(robot: Robot) -> Comparison:
    ours = (robot.leg.tibia, robot.leg.thigh, 2.0 * robot.leg.hip_spacing)
    printed = [(row["Parameter"], float(row["Values"].split()[0])) for row in rows("nao_table1")]
    notes = ("NAO V4's own, used here", "", "distance between the ankles; the leg does not use it")
    return Comparison(
        title="Table 1, lengths of NAO",
        unit="m",
        digits=4,
        rows=[
            Row(label=label, printed=value, ours=own, note=note)
            for (label, value), own, note in zip(printed, ours, notes, strict=True)
        ],
    )


def _table_2(robot: Robot) -> Comparison:
    """A load on one sensor alone has to come back as that sensor's position."""
    lines = []
    for foot in range(2):
        sensors = robot.sole.sensors(foot)
        back = foot_zmp(sensor_loads(np.full(4, 10.0), sensors, sensors), sensors)
        for k, row in enumerate(rows("nao_table2")[4 * foot : 4 * foot + 4]):
            for axis, name in enumerate("XY"):
                value = float(row[f"Position {name} (m) [Ankle Frame]"].split()[0])
                label = f"{row['FSR Name']} {name.lower()}"
                lines.append(Row(label=label, printed=value, ours=float(back[k, axis])))
    return Comparison(
        title="Table 2, force sensors, used as printed: the ZMP of a load on one of them alone",
        unit="m",
        digits=5,
        rows=lines,
    )


def _knees(robot: Robot) -> Table:
    legs = ((paper_leg() / 2.0, paper_leg() / 2.0), (robot.leg.thigh, robot.leg.tibia))
    body = []
    for row in rows("nao_table3"):
        h = float(row["Bending Height (m)"])
        bent = (geometric_angles(np.array([0.0, 0.0, h - sum(leg)]), *leg) for leg in legs)
        knees = (f"{degrees(angles.knee_pitch):.2f}" for angles in bent)
        body.append([f"{1000.0 * h:.0f}", *knees])
    return Table(
        title="What the bending height does to the knee",
        text="Standing. The paper prints no angles.",
        header=["h [mm]", "knee on the paper's links [deg]", "knee on NAO V4's [deg]"],
        rows=body,
    )


def _final_setting(gait: Gait) -> Comparison:
    ours = {
        "Step length (m)": 2.0 * gait.step_length,
        "Bending Height (m)": straight(Robot()) - gait.hip_height,
        "Lifting Height (m)": gait.step_height,
        "Frontal Shift (m)": gait.lateral_sway,
    }
    words = {
        "Step length (m)": "2 step_length",
        "Bending Height (m)": "0.24809 m - hip_height",
        "Lifting Height (m)": "step_height",
        "Frontal Shift (m)": "lateral_sway",
    }
    lines = [
        Row(label=name, printed=final(name), ours=value, note=f"`{words[name]}`")
        for name, value in ours.items()
    ]
    speed = 2.0 * gait.step_length / gait.gait_period
    lines.append(Row(label="Speed (m/s)", printed=None, ours=speed, note="s / 2T with T = 1 s"))
    return Comparison(title="Table 6, the final setting", unit="-", digits=3, rows=lines)


def _planned(robot: AnyRobot, gait: Gait) -> Table:
    """How far out the planned ZMP goes for each period, against the sole's edge."""
    edge = 0.5 * gait.step_width + robot.sole.outward + 0.5 * robot.sole.width
    inside = robot.sole.centre[0] - 0.5 * robot.sole.length
    body = []
    for period in PERIODS:
        zmp = planned_zmp(robot, replace(gait, gait_period=2.0 * period))
        numbers = (zmp.furthest_out, edge - zmp.furthest_out, zmp.hindmost, zmp.foremost)
        body.append([f"{period:g}", *(f"{1000.0 * x:.0f}" for x in numbers)])
    return Table(
        title="The ZMP as planned, for each period",
        text="Point masses at the links' centres of mass follow the commanded joints exactly. y is "
        f"counted from the line midway between the feet, where the outer edge of the sole is at "
        f"{1000.0 * edge:.0f} mm; x from the standing ankle, with the heel at "
        f"{1000.0 * inside:.0f} mm and the toe at {1000.0 * (inside + robot.sole.length):.0f} mm.",
        header=["T [s]", "furthest y [mm]", "margin [mm]", "hindmost x [mm]", "foremost x [mm]"],
        rows=body,
    )


def _limits(robot: Robot) -> Table:
    """The range that each leg joint takes over all settings of Tables 3 to 5."""
    walks = [
        gait.feet(gait.startup_time + np.linspace(0.0, 1.0, 401) * gait.gait_period)
        for gait in fifteen(robot)
    ]
    joints = np.degrees(np.concatenate([robot.joint_targets(feet) for feet in walks]))
    body = []
    for index, joint in enumerate(robot.tree.joints[:6]):
        if joint.name.removeprefix("left_") not in LIMITED:
            continue
        low, high = joints[:, index].min(), joints[:, index].max()
        limits = np.degrees([joint.lower, joint.upper])
        numbers = (low, high, *limits, min(low - limits[0], limits[1] - high))
        body.append([joint.name, *(f"{x:.1f}" for x in numbers)])
    return Table(
        title="Joint ranges over all fifteen settings",
        text="Left leg; the right one mirrors it. The hip yaw-pitch joint stays at 0.",
        header=["joint", "lowest [deg]", "highest [deg]", "limit", "limit", "margin"],
        rows=body,
    )


ASSUMPTIONS = (
    ("period T", "1 s in the three sweeps; swept from 0.6 to 1.5 s in `nao_period`"),
    (
        "lateral profile of (2.4)",
        "`sinsin`, F sin(pi/2 sin(pi tau/T)); `sin`, `foot` and `printed` can be chosen",
    ),
    ("start and stop", "stands for 1 s, then a half step; the walk does not stop"),
    ('"sampling with ten"', "read as ten samples a step; here targets move every 2 ms"),
    ("number of runs", "10 seeds: friction, servo gains, first pose differ a little"),
    ("floor, time step, NAO version", "rigid floor of friction 0.6, 2 ms in Bullet, NAO H25 V4.0"),
    (
        "servos",
        "twice the effort of the published URDF, gain of 120 1/s, 0.33 degrees of backlash; all "
        "in `gaitlab/servos/nao_*.yaml`",
    ),
    ("arms", "held bent at the sides; the head looks ahead"),
    (
        "force sensors",
        "the sole is the published box; its contact force is shared by the four sensors so that "
        "their centre is the centre of pressure, drawn to their edge when it lies beyond",
    ),
    (
        '"fluctuates"',
        "total variation of the load index, read every 10 ms, over twice the exchanges, less one; "
        "the index as printed is also measured, but a division by almost nothing rules it",
    ),
    (
        "inertias",
        "published masses, centres and moments; products of inertia left out; both hips turn by "
        "servos of their own that are commanded alike",
    ),
)
