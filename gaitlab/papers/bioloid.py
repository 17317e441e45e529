"""Audit of the Bioloid paper: Tables 1 to 10 and the abstract beside what its equations give.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gaitlab.papers import _bioloid_walks as walks
from gaitlab.papers._bioloid_errata import errata, knee_load
from gaitlab.papers._bioloid_soles import (
    ankle_table,
    gamma_errors,
    offsets,
    position_table,
    sole_angle,
)
from gaitlab.papers._bioloid_tables import (
    ANGLES,
    AXES,
    CALCULATED,
    MEASURED,
    POSES,
    POSITIONS,
    ROBOTS,
    SIDES,
    Side,
    averages,
    calculated,
    common_lean,
    level_positions,
    measured,
    off_grid,
    positions,
    recomputed,
    stated,
)
from gaitlab.papers.page import Comparison, Page, Row
from gaitlab.papers.printed import rows
from gaitlab.parameters import parameters
from gaitlab.robots.bioloid import Robot

ROUNDED = 0.005  # degrees, half a digit of the printed ones
TOLERANCE = 0.02  # degrees; what is further off is a misprint and no rounding
PAPER = (
    "B. Setiyono, Rifal and M. Munadi, *Implementation of Invers Kinematics for Movement Legs "
    "Design on Humanoid Robot*, Diponegoro University, Semarang."
)


def audit(store: Path = Path("data")) -> Page:
    """The page; tables of simulated walks are filled from the store."""
    return Page(
        title="The Bioloid dance robot: legs and five-pose gait",
        paper=PAPER,
        summary=_summary(store),
        comparisons=list(_comparisons()),
        errata=errata(),
        assumptions=list(_assumptions()),
        tables=[ankle_table(), position_table(), knee_load(), *walks.tables(store)],
    )


def _summary(store: Path) -> str:
    off = np.concatenate([(recomputed(s) - calculated(s)).ravel() for s in SIDES])
    misprints = int(np.sum(np.abs(off) > TOLERANCE))
    agree = int(np.sum(np.abs(off) <= ROUNDED))
    published, flat = gamma_errors()
    shift, spread = offsets()
    return (
        f"Of the {off.size} angles of Tables 3 and 4, {agree} equal ours to the printed digits, "
        f"{off.size - agree - misprints} are off in the last digits by at most {TOLERANCE} degrees "
        f"and {misprints} are misprints. The ankle law, equation (7), leaves the soles of a step "
        f"{sole_angle():.1f} degrees out of parallel; the measured ankles do not follow it (mean "
        f"error {published:.2f} degrees) but the law of level soles ({flat:.2f} degrees), so most "
        "of the ankle error in the abstract is an error of the formula. The position error of X is "
        "a mix-up of frames: turned by the measured lean, the measured angles put the ankle within "
        f"{shift[0]:.2f} ± {spread[0]:.2f} cm of the measured X, and {shift[1]:.2f} ± "
        f"{spread[1]:.2f} cm from the measured Y, a constant: another reference point. "
        f"{_copies()} {walks.verdict(store)} The sign of z, the sign of the stance ankle's roll, "
        "the time from pose to pose, masses and sole cannot be decided from the paper."
    )


def _copies() -> str:
    """How far the two robots are apart in the static tables."""
    apart = [np.abs(measured(1, s) - measured(2, s)).mean(axis=0) for s in SIDES]
    low, high = np.min(apart), np.max(apart)
    return (
        f"The angles of robot 1 and robot 2 differ by {low:.2f} to {high:.2f} degrees in the mean, "
        "so the static tables hold no sign of the servo delays that are said to make robot 2 fall."
    )


def _comparisons() -> Iterator[Comparison]:
    yield _specification()
    yield from (_calculated_table(side) for side in SIDES)
    yield from (_positions_table(robot) for robot in ROBOTS)
    yield from (_measured_table(robot, side) for robot in ROBOTS for side in SIDES)
    yield _abstract()


def _specification() -> Comparison:
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
        Row(label=f"{label} [{unit}]", printed=float(text.split()[0]), ours=value, note=note)
        for label, unit, text, value, note in zip(labels, units, texts, ours, notes, strict=True)
    ]
    return Comparison(title="Table 1: the robot", unit="-", digits=1, rows=found)


def _calculated_table(side: Side) -> Comparison:
    ours, printed = recomputed(side), calculated(side)
    found = [
        Row(
            label=f"{pose}, {angle}",
            printed=float(printed[i, j]),
            ours=float(ours[i, j]),
            note=_verdict(float(ours[i, j] - printed[i, j])),
        )
        for i, pose in enumerate(POSES)
        for j, angle in enumerate(ANGLES)
    ]
    title = f"Table {CALCULATED[side]}: calculated angles of the {side} leg"
    return Comparison(title=title, unit="degrees", digits=2, rows=found)


def _verdict(difference: float) -> str:
    if abs(difference) <= ROUNDED:
        return ""
    return "rounding" if abs(difference) <= TOLERANCE else "**misprint**"


def _positions_table(robot: int) -> Comparison:
    found = [
        Row(
            label=f"{pose}, {side} {axis}",
            printed=float(positions(robot, side)[i, j]),
            ours=float(level_positions(robot, side)[i, j]),
            note=_position_note(robot, side, i, j),
        )
        for i, pose in enumerate(POSES)
        for side in SIDES
        for j, axis in enumerate(AXES)
    ]
    title = (
        f"Table {POSITIONS[robot]}: positions of robot {robot}, ours from its measured angles in "
        "the level frame"
    )
    return Comparison(title=title, unit="cm", digits=2, rows=found)


def _position_note(robot: int, side: Side, pose: int, axis: int) -> str:
    misplaced = {(1, "right", 4, 2): "0.2", (2, "left", 2, 0): "1.0"}
    meant = misplaced.get((robot, side, pose, axis))
    return "" if meant is None else f"**misprint**, {meant} by the mean that the abstract states"


def _measured_table(robot: int, side: Side) -> Comparison:
    printed, ours = measured(robot, side), recomputed(side, "planar", "flat", common_lean())
    found = [
        Row(
            label=f"{pose}, {angle}",
            printed=float(printed[i, j]),
            ours=float(ours[i, j]),
            note=_measured_note(i, j, float(printed[i, j]), float(ours[i, j])),
        )
        for i, pose in enumerate(POSES)
        for j, angle in enumerate(ANGLES)
    ]
    title = (
        f"Table {MEASURED[robot, side]}: measured angles of robot {robot}, {side} leg; ours of "
        "level soles under the common lean"
    )
    return Comparison(title=title, unit="degrees", digits=2, rows=found)


def _measured_note(pose: int, angle: int, printed: float, ours: float) -> str:
    nearest = off_grid(printed)
    if nearest is not None:
        return f"misprint: the servo's grid has {nearest:.2f}"
    if ANGLES[angle] == "ω" and POSES[pose].startswith("Lift") and printed * ours < 0.0:
        return "stance leg: rolled against equation (9)"
    return ""


def _abstract() -> Comparison:
    found = []
    for side in SIDES:
        values = zip(stated(side), averages(side, False), averages(side, True), strict=True)
        names = (*(f"{axis} [cm]" for axis in AXES), *(f"{angle} [degrees]" for angle in ANGLES))
        for name, (printed, raw, mended) in zip(names, values, strict=True):
            note = "" if abs(raw - printed) < 0.01 else _average_note(printed, mended)
            row = Row(label=f"{side} {name}", printed=float(printed), ours=float(raw), note=note)
            found.append(row)
    title = "Abstract: mean errors, ours from Tables 2 to 10 as printed"
    return Comparison(title=title, unit="-", digits=2, rows=found)


def _average_note(printed: float, mended: float) -> str:
    if abs(mended - printed) < 0.01:
        return f"{mended:.2f} once the misprints of the tables are mended"
    return f"does not follow from the tables; {mended:.2f} with their misprints mended"


def _assumptions() -> Iterator[tuple[str, str]]:
    from gaitlab.gaits.bioloid import Gait

    for cls in (Robot, Gait):
        for item in parameters(cls):
            if item.source.startswith(("assumption", "reconstruction")):
                shown = f"{item.default:.4g}" if isinstance(item.default, float) else item.default
                unit = "" if item.unit == "-" else f" {item.unit}"
                yield f"{item.name}: {item.doc}", f"{shown}{unit}; {item.source}"
    yield "directions of the servos", "right pitch servos turned over, all others alike"
    yield "dance", "an original choreography of this project, `motions/bioloid_dance.yaml`"
