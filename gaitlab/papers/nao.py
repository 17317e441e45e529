"""Audit of the NAO gait study: its tables, its equations, and its three choices simulated.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, Parameter study of stable walking gaits for NAO
        humanoid robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from math import degrees
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gaitlab.gaits.nao import Gait
from gaitlab.kinematics.fsr import foot_zmp, sensor_loads
from gaitlab.kinematics.slanted_leg import geometric_angles
from gaitlab.log import GRAVITY
from gaitlab.model import Robot as AnyRobot
from gaitlab.model.gait import Gait as AnyGait
from gaitlab.papers import nao_effects
from gaitlab.papers.nao_charts import pictures
from gaitlab.papers.nao_effects import fifteen, final, final_gait, paper_leg, straight
from gaitlab.papers.nao_sweeps import (
    PERIOD,
    VERDICTS,
    Setting,
    Walked,
    criterion,
    doubts,
    sweeps,
    table,
    verdict,
    walked,
)
from gaitlab.papers.page import (
    Page,
    PrintedNumber,
    PrintedTable,
    Table,
    assumptions_of,
    errata_of,
    text_of,
)
from gaitlab.papers.printed import rows
from gaitlab.papers.walks import not_simulated
from gaitlab.report.markdown import table as markdown_table
from gaitlab.robots.nao import Robot

DATA = Path("data")
PERIODS = (0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)  # s, T of the planned ZMP
WITHIN = 1e-3  # m, rounding of what is called inside
LIMITED = ("hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")


def audit(store: Path = DATA) -> Page:
    """The page; a store without the sweeps gives a page that says which are missing."""
    robot, gait = Robot(), final_gait()
    found = walked(store)
    return Page(
        title=text_of("nao", "title"),
        paper=text_of("nao", "paper"),
        summary=summary(found, store),
        comparisons=[_table_1(robot), _table_2(robot), _final_setting(gait)],
        errata=errata_of("nao", nao_effects),
        assumptions=assumptions_of("nao"),
        tables=[
            *(table(sweep, one) for sweep in (*sweeps(), PERIOD) for one in found if one[sweep]),
            _knees(robot),
            _planned(robot, gait),
            _limits(robot),
        ],
        pictures=pictures(store),
    )


def summary(found: Sequence[Walked], store: Path) -> str:
    """What agrees, what does not and what cannot be decided."""
    verdicts, missing = list[list[str]](), list[str]()
    for sweep, one in product(sweeps(), found):
        if row := verdict(sweep, one):
            verdicts.append(row)
        else:
            lacking = not_simulated("nao", store, one.run(sweep))
            missing.append(f"- {sweep.title}, {one.engine}: {lacking}")
    everything = [setting for one in found for its in one.sweeps.values() for setting in its]
    blocks = [
        text_of("nao", "summary"),
        criterion(everything),
        "## Which of the three choices the simulation supports",
        markdown_table(VERDICTS, verdicts, "llc") if verdicts else "",
        "\n".join(missing),
        "Supported means: walks as often as any other setting, and its load fluctuates less than "
        "every other's, in pairs of equal seed. The comparisons of all three choices in both "
        f"engines are one family (Holm). {doubts(found)}",
        *(_period_sentence(one, store) for one in found),
    ]
    return "\n\n".join(block for block in blocks if block)


def _period_sentence(one: Walked, store: Path) -> str:
    periods = one[PERIOD]
    if not periods:
        missing = not_simulated("nao", store, one.run(PERIOD))
        return f"**The period, {one.engine}**: {missing}"
    counts = ", ".join(f"{s.walked} of {len(s.trials)} at T = {s.value:g} s" for s in periods)
    others = max(_spread(one[sweep]) for sweep in sweeps())
    more = _spread(periods) > others
    return (
        f"**The period, {one.engine}**, which the paper never gives: at the final setting NAO "
        f"walks in {counts}. That is a range of {100.0 * _spread(periods):.0f} % of the trials; "
        f"the three parameters that the paper varies come to {100.0 * others:.0f} % at most"
        + (", so the period decides more than any of them." if more else ".")
    )


def _spread(found: list[Setting]) -> float:
    shares = [setting.share for setting in found]
    return max(shares, default=0.0) - min(shares, default=0.0)


def _table_1(robot: Robot) -> PrintedTable:
    ours = (robot.leg.tibia, robot.leg.thigh, 2.0 * robot.leg.hip_spacing)
    printed = [(row["Parameter"], float(row["Values"].split()[0])) for row in rows("nao_table1")]
    notes = ("NAO V4's own, used here", "", "distance between the ankles; the leg does not use it")
    return PrintedTable(
        title="Table 1, lengths of NAO",
        unit="m",
        digits=4,
        rows=[
            PrintedNumber(label=label, printed=value, ours=own, note=note)
            for (label, value), own, note in zip(printed, ours, notes, strict=True)
        ],
    )


def _table_2(robot: Robot) -> PrintedTable:
    """A load on one sensor alone has to come back as that sensor's position."""
    lines = []
    for foot in range(2):
        sensors = robot.sole.sensors(foot)
        back = foot_zmp(sensor_loads(np.full(4, 10.0), sensors, sensors), sensors)
        for k, row in enumerate(rows("nao_table2")[4 * foot : 4 * foot + 4]):
            for axis, name in enumerate("XY"):
                value = float(row[f"Position {name} (m) [Ankle Frame]"].split()[0])
                label = f"{row['FSR Name']} {name.lower()}"
                lines.append(PrintedNumber(label=label, printed=value, ours=float(back[k, axis])))
    return PrintedTable(
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


def _final_setting(gait: Gait) -> PrintedTable:
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
        PrintedNumber(label=name, printed=final(name), ours=value, note=f"`{words[name]}`")
        for name, value in ours.items()
    ]
    speed = 2.0 * gait.step_length / gait.gait_period
    lines.append(
        PrintedNumber(label="Speed (m/s)", printed=None, ours=speed, note="s / 2T with T = 1 s")
    )
    return PrintedTable(title="Table 6, the final setting", unit="-", digits=3, rows=lines)


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


class PlannedZmp(NamedTuple):
    """A planned step on the left foot, from the middle between the feet and its ankle, in [m].

    Attributes:
        furthest_out: Largest y of the ZMP, from the line midway between the feet.
        hindmost: Smallest x of the ZMP from the standing ankle.
        foremost: Largest x of it.
        com_out: Largest y of the centre of mass.
    """

    furthest_out: float
    hindmost: float
    foremost: float
    com_out: float


def planned_zmp(robot: AnyRobot, gait: AnyGait, samples: int = 200) -> PlannedZmp:
    """ZMP of the first full-amplitude step, from central differences; derived here.

    Args:
        robot: The robot.
        gait: A gait whose phase 0 starts a step on the left foot.
        samples: Instants a step.
    """
    dt = gait.gait_period / 2.0 / samples
    t = gait.startup_time + gait.gait_period + np.arange(-1, samples + 2) * dt
    feet = gait.feet(t)
    # The standing foot jumps to the other side at an exchange: count from the left sole, which
    # is the standing one in the step and the one that has just landed or lifts around it.
    left = _left_sole(feet.position[:, 0], feet.swing[:, 0])
    trunk = np.array([0.0, 0.0, robot.hip_offset()]) - left
    joints = robot.joint_targets(feet)
    poses = robot.tree.poses(trunk, np.tile(np.eye(3), (len(t), 1, 1)), joints)
    zmp = _zmp(robot, poses.position, poses.rotation, dt)
    half = 0.5 * abs(feet.position[0, 0, 1] - feet.position[0, 1, 1])
    out = robot.tree.centre_of_mass(poses)[1:-1, 1] + half
    return PlannedZmp(
        float(zmp[:, 1].max() + half),
        float(zmp[:, 0].min()),
        float(zmp[:, 0].max()),
        float(out.max()),
    )


def _left_sole(position: np.ndarray, swing: np.ndarray) -> np.ndarray:
    """Left sole seen from the hips, held to the ground in the instants when it swings."""
    standing = position.copy()
    standing[swing, 2] = position[~swing, 2][0]
    return standing


def _zmp(robot: AnyRobot, position: np.ndarray, rotation: np.ndarray, dt: float) -> np.ndarray:
    """ZMP on the ground of the links as point masses, in [m]. Shape (n - 2, 2)."""
    mass = np.array([link.mass for link in robot.tree.links])[:, None]
    centre = np.array([link.centre for link in robot.tree.links])
    at = position + np.einsum("nlij,lj->nli", rotation, centre)
    acceleration = (at[2:] - 2.0 * at[1:-1] + at[:-2]) / dt**2
    now, lift = at[1:-1], acceleration[..., 2:] + GRAVITY
    moment = (mass * (lift * now[..., :2] - now[..., 2:] * acceleration[..., :2])).sum(axis=1)
    total: np.ndarray = moment / (mass * lift).sum(axis=1)
    return total
