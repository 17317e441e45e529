"""Audit of the Bioloid paper: Tables 1 to 10 and the abstract beside what its equations give.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
    ROBOTIS-eManual: e-Manual of the Dynamixel AX-12A, ROBOTIS Co., Ltd.
    Wilson1927: E. B. Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from gaitlab.gaits.bioloid import Gait
from gaitlab.log import GRAVITY
from gaitlab.papers import bioloid_effects
from gaitlab.papers.bioloid_tables import (
    ALPHA,
    ANGLES,
    AXES,
    BETA,
    CALCULATED,
    LENGTHS,
    LIFT_LEFT,
    MEASURED,
    POSES,
    POSITIONS,
    ROBOTS,
    SIDES,
    STEP_LEFT,
    STEP_RIGHT,
    Side,
    averages,
    calculated,
    common_lean,
    gamma_errors,
    lean_of,
    level_positions,
    measured,
    off_grid,
    offsets,
    positions,
    recomputed,
    sole_angle,
    stated,
)
from gaitlab.papers.page import (
    Page,
    PrintedNumber,
    PrintedTable,
    Table,
    assumptions_of,
    default_text,
    errata_of,
    matrix,
    text_of,
)
from gaitlab.papers.printed import rows
from gaitlab.papers.walks import not_simulated, share_text, spread_text, trials
from gaitlab.parameters import parameters
from gaitlab.robots.bioloid import Robot
from gaitlab.servos.files import load_servo

ROUNDED = 0.005  # degrees, half a digit of the printed ones
TOLERANCE = 0.02  # degrees; what is further off is a misprint and no rounding
RATED_SHARE = 0.2  # of stall, up to which ROBOTIS calls an AX-12 stable
ABOVE_KNEE = 2.7  # kg, an assumption: the robot without one shank and foot
MISPLACED = {(1, "right"): (STEP_RIGHT, 2), (2, "left"): (STEP_LEFT, 0)}  # points of Tables 5, 6
WALK, FIVE_POSES, COPIES, DANCE = "bioloid_walk", "bioloid_poses", "bioloid_robots", "bioloid_dance"
LATENCY, SPREAD = "servo.latency", "spread.servo_latency"
TITLES = {LATENCY: "latency [s]", SPREAD: "spread of latency [s]"}
LAWS = ("gait.ankle_law", "gait.coupling", "gait.stance_omega_sign")
FIGURES = (  # metric, title, factor to the unit shown, digits
    ("time_to_fall", "falls at [s]", 1.0, 2),
    ("distance", "distance [m]", 1.0, 3),
    ("heading_drift", "turned by [deg]", float(np.degrees(1.0)), 1),
    ("roll_amplitude", "roll amplitude [deg]", float(np.degrees(1.0)), 1),
)


def audit(store: Path = Path("data")) -> Page:
    """The page; tables of simulated walks are filled from the store."""
    return Page(
        title=text_of("bioloid", "title"),
        paper=text_of("bioloid", "paper"),
        summary=_summary(store),
        comparisons=[_specification(), _abstract()],
        errata=errata_of("bioloid", bioloid_effects),
        assumptions=list(_assumptions()),
        tables=[
            *(_calculated_table(side) for side in SIDES),
            *(_positions_table(robot) for robot in ROBOTS),
            *(_measured_table(robot, side) for robot in ROBOTS for side in SIDES),
            ankle_table(),
            position_table(),
            knee_load(),
            *walk_tables(store),
        ],
    )


def _summary(store: Path) -> str:
    off = np.abs(np.concatenate([(recomputed(s) - calculated(s)).ravel() for s in SIDES]))
    misprints, agree = int(np.sum(off > TOLERANCE)), int(np.sum(off <= ROUNDED))
    copies = [np.abs(measured(1, s) - measured(2, s)).mean(axis=0) for s in SIDES]
    published, flat = gamma_errors()
    shift, spread = offsets()
    return text_of(
        "bioloid",
        "summary",
        angles=off.size,
        agree=agree,
        rounded=off.size - agree - misprints,
        misprints=misprints,
        tolerance=TOLERANCE,
        apart=sole_angle(),
        published=published,
        flat=flat,
        x=shift[0],
        x_spread=spread[0],
        y=shift[1],
        y_spread=spread[1],
        low=np.min(copies),
        high=np.max(copies),
        walks=verdict(store),
    )


def _specification() -> PrintedTable:
    robot = Robot()
    body, sole = robot.upper_body, robot.sole
    above = body.waist_height + body.shoulder_height + body.neck + body.head
    leg = robot.leg.hip_drop + robot.leg.thigh + robot.leg.shank + sole.height
    arms = 2.0 * (body.shoulder_spacing + body.upper_arm + body.forearm)
    ours = (100.0 * (above + leg), 100.0 * arms, None, robot.tree.mass, len(robot.tree.joints))
    units = ("cm", "cm", "cm²", "kg", "-")
    texts = [row["Dimension"] for row in rows("bioloid_table1")]
    notes = [row["note"] for row in rows("bioloid_table1")]
    labels = [row["Description"] for row in rows("bioloid_table1")]
    found = [
        PrintedNumber(
            label=f"{label} [{unit}]", printed=float(text.split()[0]), ours=value, note=note
        )
        for label, unit, text, value, note in zip(labels, units, texts, ours, notes, strict=True)
    ]
    return PrintedTable(title="Table 1: the robot", unit="-", digits=1, rows=found)


def _calculated_table(side: Side) -> Table:
    ours, printed = recomputed(side), calculated(side)
    wrong = np.abs(ours - printed) > TOLERANCE
    return matrix(
        f"Table {CALCULATED[side]}: calculated angles of the {side} leg",
        f"In degrees; in brackets what ours is off. Up to {TOLERANCE} it is rounding; **bold** is "
        "a misprint.",
        ANGLES,
        {pose: (printed[i], ours[i]) for i, pose in enumerate(POSES)},
        lambda pose, j: bool(wrong[POSES.index(pose), j]),
    )


def _positions_table(robot: int) -> Table:
    printed, ours = (
        np.hstack([found(robot, side) for side in SIDES]) for found in (positions, level_positions)
    )
    ((side, (pose, axis)),) = [(s, place) for (r, s), place in MISPLACED.items() if r == robot]
    column = 3 * SIDES.index(side) + axis
    return matrix(
        f"Table {POSITIONS[robot]}: positions of robot {robot}",
        "In cm; in brackets what is off if its measured angles are turned into the level frame. "
        "**Bold** is a misprint by the mean that the abstract states.",
        [f"{side} {axis}" for side in SIDES for axis in AXES],
        {name: (printed[i], ours[i]) for i, name in enumerate(POSES)},
        lambda name, j: (POSES.index(name), j) == (pose, column),
    )


def _measured_table(robot: int, side: Side) -> Table:
    printed, ours = measured(robot, side), recomputed(side, "planar", "flat", common_lean())
    return matrix(
        f"Table {MEASURED[robot, side]}: measured angles of robot {robot}, {side} leg",
        "In degrees; in brackets what is off if the soles are level under the common lean. "
        "**Bold** is a misprint, for the servo cannot report it. In the lifts the ankle of the "
        "stance leg is rolled against equation (9).",
        ANGLES,
        {pose: (printed[i], ours[i]) for i, pose in enumerate(POSES)},
        lambda pose, j: off_grid(float(printed[POSES.index(pose), j])) is not None,
    )


def _abstract() -> PrintedTable:
    found = []
    for side in SIDES:
        values = zip(stated(side), averages(side, False), averages(side, True), strict=True)
        names = (*(f"{axis} [cm]" for axis in AXES), *(f"{angle} [degrees]" for angle in ANGLES))
        for name, (printed, raw, mended) in zip(names, values, strict=True):
            note = "" if abs(raw - printed) < 0.01 else _average_note(printed, mended)
            row = PrintedNumber(
                label=f"{side} {name}", printed=float(printed), ours=float(raw), note=note
            )
            found.append(row)
    title = "Abstract: mean errors, ours from Tables 2 to 10 as printed"
    return PrintedTable(title=title, unit="-", digits=2, rows=found)


def _average_note(printed: float, mended: float) -> str:
    if abs(mended - printed) < 0.01:
        return f"{mended:.2f} once the misprints of the tables are mended"
    return f"does not follow from the tables; {mended:.2f} with their misprints mended"


def _assumptions() -> Iterator[tuple[str, str]]:
    for cls in (Robot, Gait):
        for item in parameters(cls):
            if item.source.startswith(("assumption", "reconstruction")):
                yield f"{item.name}: {item.doc}", f"{default_text(item)}; {item.source}"
    yield from assumptions_of("bioloid")


def ankle_table() -> Table:
    """Lean of the torso over each sole: published law, level soles, measured."""
    table = []
    for i, pose in enumerate(POSES):
        law = [float(lean_of(recomputed(side))[i]) for side in SIDES]
        found = [float(lean_of(measured(r, side))[i]) for r in ROBOTS for side in SIDES]
        table.append([pose, *(f"{x:.2f}" for x in (*law, law[0] - law[1], *found))])
    header = ["lean [degrees]", "eq. (7) right", "eq. (7) left", "soles apart"]
    header += [f"robot {r} {side}" for r in ROBOTS for side in SIDES]
    text = (
        "Lean of the torso over the sole, α + γ − β. Both legs carry one torso, so a pose stands "
        "on level soles only if both leans are equal; the measured ones nearly are."
    )
    return Table(title="What the ankle law does to the soles", text=text, header=header, rows=table)


def position_table() -> Table:
    """How far the measured positions are from Table 2, and from the turned measured angles."""
    shift, spread = offsets()
    raw = [averages(side, False)[:3].mean() for side in SIDES]
    body = [
        [
            axis,
            f"{shift[j]:.2f} ± {spread[j]:.2f}",
            *(f"{averages(s, False)[j]:.2f}" for s in SIDES),
        ]
        for j, axis in enumerate(AXES)
    ]
    text = (
        "Measured less computed from the measured angles in the level frame, mean ± standard "
        "deviation over robots, legs and poses; beside it the mean error against Table 2, whose "
        f"frame leans with the torso (over all axes {raw[0]:.2f} and {raw[1]:.2f} cm)."
    )
    header = ["cm", "in the level frame", "right, against Table 2", "left, against Table 2"]
    return Table(title="Positions are a mix-up of frames", text=text, header=header, rows=body)


def knee_load() -> Table:
    """Static knee torque of a lift against the servo, for the CoM ahead of the ankle.

    The knee lies where level soles put it, ahead of the ankle; what is above it weighs on it.
    """
    servo = load_servo("ax_12")
    lean = np.radians(common_lean()[LIFT_LEFT])
    alpha, beta = np.radians(recomputed("right")[LIFT_LEFT, ALPHA : BETA + 1])
    knee = LENGTHS["shank"] * np.sin(beta - alpha + lean)
    table = []
    for ahead in (0.0, 0.01, 0.02):
        torque = ABOVE_KNEE * GRAVITY * (knee - ahead)
        share = torque / servo.stall_torque
        table.append([f"{100.0 * ahead:.0f}", f"{torque:.2f}", f"{100.0 * share:.0f} %"])
    text = (
        f"{ABOVE_KNEE} kg above a knee {100.0 * knee:.1f} cm ahead of the ankle, as in lift left "
        "with level soles. ROBOTIS calls an AX-12 stable up to "
        f"{100.0 * RATED_SHARE:.0f} % of stall, so the stance knee is overloaded whatever "
        "the timing; the authors propose stronger servos."
    )
    header = ["CoM ahead of the ankle [cm]", "knee torque [N m]", "of stall at 12 V"]
    return Table(title="Load of the stance knee", text=text, header=header, rows=table)


def walk_tables(store: Path) -> list[Table]:
    """One table an experiment."""
    return [
        _walks(store, FIVE_POSES, "The five poses as printed, simulated", LAWS),
        _walks(store, WALK, "Poses found here, simulated", ("surface",)),
        _walks(store, COPIES, "Robot 1 and robot 2: late servos", (LATENCY, SPREAD)),
        _walks(store, DANCE, "The dance", ("gait.tempo", "surface")),
    ]


def _walks(store: Path, experiment: str, title: str, paths: Sequence[str]) -> Table:
    found = trials(store, experiment)
    text = (
        f"`gaitlab run {experiment}`; stayed up with a 95 % Wilson interval [Wilson1927], medians "
        "[smallest, largest] over the seeds. A time of a fall counts from the start of measured "
        "walking; a negative one lies in the steps before."
    )
    if found.empty:
        text = not_simulated("bioloid", store, experiment)
    header = [*(TITLES.get(path, path.split(".")[-1]) for path in paths), "stayed up"]
    header += [title for _, title, _, _ in FIGURES]
    groups = [] if found.empty else list(found.groupby(list(paths), sort=False))
    rows = [
        [
            *map(str, key),
            _up(cell),
            *(spread_text(cell[m], d, f) for m, _, f, d in FIGURES),
        ]
        for key, cell in groups
    ]
    return Table(title=title, text=text, header=header, rows=rows)


def _up(cell: pd.DataFrame) -> str:
    return share_text(~cell["fell"].astype(bool))


def verdict(store: Path) -> str:
    """What the simulation says of the servo delays, with n."""
    found = trials(store, COPIES)
    if found.empty:
        missing = not_simulated("bioloid", store, COPIES)
        return f"Whether late servos make the walk fall: {missing[0].lower()}{missing[1:]}"
    parts = [
        f"{_up(cell)} stayed up with servos {1e3 * latency:.0f} ± {1e3 * spread:.0f} ms late"
        for (latency, spread), cell in found.groupby([LATENCY, SPREAD], sort=False)
    ]
    return (
        f"In simulation {', '.join(parts)}; the delays are ours, the paper gives none, so this "
        "shows what delays of that size do and not what robot 2 suffered from."
    )
