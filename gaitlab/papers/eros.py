"""Audit of the EROS paper: chains, gait, tables and experiments.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from gaitlab.experiment.reference import ReferenceCell, ReferenceTable, load_reference
from gaitlab.papers import eros_effects
from gaitlab.papers.page import (
    Page,
    PrintedNumber,
    PrintedTable,
    Table,
    assumptions_of,
    errata_of,
    text_of,
)
from gaitlab.papers.printed import forward_counted, pedestals
from gaitlab.papers.printed import rows as rows_of
from gaitlab.papers.reproduction.sections.pitch import Published, published_settings, walks_of
from gaitlab.papers.walks import not_simulated, trials
from gaitlab.robots.eros import Robot
from gaitlab.statistics import distance_difference, efficiency, stability_percent, stable_cell

WALKED = ("DONE", "INFEASIBLE")  # states that are scored
STEP = "gait.step_length"
TABLES = "eros_frozen"  # the experiments of the reproduction that are shown here
FIGURES = "eros_pitch"
CHAINS = {
    "eros_table2_head": "Table 2, head",
    "eros_table3_right_arm": "Table 3, right arm",
    "eros_table4_left_arm": "Table 4, left arm",
    "eros_table5_right_leg": "Table 5, right leg",
    "eros_table6_left_leg": "Table 6, left leg",
}
STATED_TRUE_BACKWARD = {"1": 0, "2": 0, "3": 0, "4": 2}  # stable cells that would explain Table 7


def audit(store: Path) -> Page:
    """The page; walks are read from a store, and missing ones are named.

    Args:
        store: Folder of the results of `eros_frozen` and `eros_pitch`.
    """
    return Page(
        title=text_of("eros", "title"),
        paper=text_of("eros", "paper"),
        summary=text_of("eros", "summary"),
        comparisons=(facts(), *chains(), *efficiencies(), *experiments(store)),
        tables=(walking_table("eros_table7", store), walking_table("eros_table8", store)),
        errata=errata_of("eros", eros_effects),
        assumptions=assumptions_of("eros", eros_effects),
    )


def facts() -> PrintedTable:
    """Table 1 and the height."""
    joints = [joint.name for joint in Robot().tree.joints]
    arms, legs = ("shoulder", "elbow"), ("hip", "knee", "ankle")
    limbs: Mapping[str, tuple[str, Sequence[str]]] = {
        "Head": ("", ("head",)),
        "Right Arm": ("right", arms),
        "Left Arm": ("left", arms),
        "Right Leg": ("right", legs),
        "Left Leg": ("left", legs),
        "Total": ("", ("",)),
    }
    rows = []
    for row in rows_of("eros_table1_dof"):
        side, parts = limbs[row["joint"]]
        ours = sum(n.startswith(side) and any(part in n for part in parts) for n in joints)
        rows.append(
            PrintedNumber(label=row["joint"], printed=int(row["dof"]), ours=ours, note=row["note"])
        )
    height = float(rows_of("eros_facts")[0]["value"])
    rows.append(PrintedNumber(label="height, cm", printed=height, ours=round(100.0 * _height(), 9)))
    return PrintedTable(title="Table 1: joints, and the height", unit="-", digits=0, rows=rows)


def _height() -> float:
    robot, leg, torso = Robot(), Robot().leg, Robot().torso
    legs = robot.sole.height + leg.shank + leg.thigh + leg.hip_drop
    head = robot.head.neck + robot.head.camera + torso.crown
    return legs + torso.shoulder_height + torso.neck_height + head


def chains() -> list[PrintedTable]:
    """Tables 2 to 6: each joint's turn and the shift that follows it."""
    return [
        PrintedTable(title=title, unit="-", digits=0, rows=list(_chain(name)))
        for name, title in CHAINS.items()
    ]


def _chain(name: str) -> Iterator[PrintedNumber]:
    for row, (turns_about, shift) in zip(rows_of(name), _model(name), strict=False):
        printed = (
            f"{row['rotation_as_printed']}, ({row['trans_x']}, {row['trans_y']}, {row['trans_z']})"
        )
        ours = f"{row['rotation_corrected']}, ({', '.join(f'{1e3 * x:g}' for x in shift)}) mm"
        agrees = row["rotation_corrected"].startswith(f"R_{turns_about}(")
        note = row["note"] if agrees else f"the model turns about {turns_about}"
        yield PrintedNumber(label=row["joint"], printed=printed, ours=ours, note=note)


def _model(name: str) -> list[tuple[str, tuple[float, float, float]]]:
    """Axis of each joint of the model and the shift from it to the next, in the paper's chain."""
    robot = Robot()
    leg, arm, head = robot.leg, robot.arm, robot.head
    side = 1.0 if "left" in name else -1.0
    limb = name.partition("_")[2].partition("_")[2]
    axes = {link.joint.name: str(link.joint.axis) for link in robot.tree.links if link.joint}
    here = (0.0, 0.0, 0.0)
    if limb == "head":
        shifts = [(0.0, 0.0, head.neck), (0.0, 0.0, head.camera)]
        names = ["head_pan", "head_tilt"]
    elif limb.endswith("arm"):
        first = (0.0, side * arm.shoulder_spacing, -arm.shoulder_drop)
        shifts = [first, (0.0, 0.0, -arm.upper_arm), (0.0, 0.0, -arm.forearm)]
        names = ["shoulder_pitch", "shoulder_roll", "elbow"]
    else:
        first = (0.0, side * leg.hip_spacing, -leg.hip_drop)
        last = (0.0, 0.0, -robot.sole.height)
        shifts = [first, here, (0.0, 0.0, -leg.thigh), (0.0, 0.0, -leg.shank), here, last]
        names = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"]
    prefix = "" if limb == "head" else ("left_" if side > 0.0 else "right_")
    return [(axes[prefix + joint], shift) for joint, shift in zip(names, shifts, strict=True)]


def walking_table(name: str, store: Path) -> Table:
    """Table 7 or 8 cell by cell: what is printed, and how many simulated walks were stable."""
    printed, found = load_reference(name), trials(store, TABLES, WALKED)
    cells = _stable_counts(printed, found)
    surfaces = list(printed.stated)
    rows = []
    for number in printed.content.printed:
        here = [ReferenceCell(number, surface) for surface in surfaces]
        shown = [_cell(printed.cells[place], cells.get(place)) for place in here]
        rows.append((here[0].direction, f"{here[0].distance:g}", *shown))
    return Table(
        title=f"{printed.title}: stable walks",
        text=_sentence(printed.cells, cells) if cells else not_simulated("eros", store, TABLES),
        header=("direction", "distance as printed", *surfaces),
        rows=rows,
    )


def _stable_counts(
    printed: ReferenceTable, trials: pd.DataFrame
) -> dict[ReferenceCell, tuple[int, int]]:
    """Stable walks and walks by cell of the printed table, read as travel of the swing foot."""
    if trials.empty:
        return {}
    found: dict[ReferenceCell, tuple[int, int]] = {}
    paths = list(printed.content.variant or {})
    answering = trials[[printed.answers(row) for row in trials[paths].to_dict("records")]]
    for (step, surface), group in answering.groupby([STEP, "surface"]):
        place = printed.place(float(str(step)), str(surface), "foot_travel")
        if place is not None:
            found[place] = (int(group["stable"].fillna(value=False).astype(bool).sum()), len(group))
    return found


def _cell(stable: bool, count: tuple[int, int] | None) -> str:
    word = "stable" if stable else "unstable"
    return word if count is None else f"{word}; {count[0]} of {count[1]}"


def _sentence(
    printed: Mapping[ReferenceCell, bool], cells: Mapping[ReferenceCell, tuple[int, int]]
) -> str:
    ours = {place: stable_cell(count[0] / count[1]) for place, count in cells.items()}
    shared = [place for place in printed if place in ours]
    forward = [place for place in shared if place.direction == "forward"]
    same, ahead = (
        sum(printed[place] == ours[place] for place in places) for places in (shared, forward)
    )
    return (
        f"As printed, and how many walks of `{TABLES}` did not fall, with the distance read as "
        f"travel of the swing foot in cm. A cell is stable if half of its walks are: {same} of "
        f"{len(shared)} cells agree, {ahead} of {len(forward)} forward. Which of them were "
        "predicted, and what a second engine says: `gaitlab report eros_reproduction`."
    )


def efficiencies() -> list[PrintedTable]:
    """Stated percentages beside those counted from the paper's own tables."""
    return [_efficiency(name) for name in ("eros_table7", "eros_table8")]


def _efficiency(name: str) -> PrintedTable:
    printed = load_reference(name)
    forward = forward_counted(printed)
    rows = [
        PrintedNumber(
            label=f"{surface}, all 10 rows", printed=stated, ours=printed.counted[surface]
        )
        for surface, stated in printed.stated.items()
    ]
    rows += [
        PrintedNumber(
            label=f"{surface}, 7 forward rows",
            printed=stated,
            ours=forward_counted(printed)[surface],
        )
        for surface, stated in printed.stated.items()
    ]
    stated_mean = efficiency(list(printed.stated.values()))
    mean = printed.content.stated_mean
    ahead = efficiency(list(forward.values()))
    rows += [
        PrintedNumber(label="efficiency, all 10 rows", printed=mean, ours=printed.counted_mean),
        PrintedNumber(
            label="efficiency, 7 forward rows",
            printed=mean,
            ours=ahead,
        ),
        PrintedNumber(label="efficiency, mean of what is stated", printed=mean, ours=stated_mean),
    ]
    if name == "eros_table7":
        rows += list(_explained())
    title = f"Efficiency of {printed.title}: stated, and counted from the table itself"
    return PrintedTable(title=title, unit="%", digits=1, rows=rows)


def _explained() -> Iterator[PrintedNumber]:
    """What Table 7 counts to if its backward rows are a copy of Table 8's."""
    printed = load_reference("eros_table7")
    for number, surface in pedestals().items():
        cells = [
            v for k, v in printed.cells.items() if k.surface == surface and k.direction == "forward"
        ]
        stable = STATED_TRUE_BACKWARD[number]
        backward = [True] * stable + [False] * (3 - stable)
        yield PrintedNumber(
            label=f"{surface}, {stable} of 3 backward rows stable",
            printed=printed.stated[surface],
            ours=stability_percent(cells + backward),
            note="the backward rows printed are those of Table 8",
        )


def experiments(store: Path) -> list[PrintedTable]:
    """Figures 24, 26 and 28: pitch, distance and what the paper computes from it."""
    walks = rows_of("eros_experiments")
    rows = [
        PrintedNumber(
            label=f"experiment {walk['experiment']}, gain in distance",
            printed=float(walk["difference_of_distance_pct_as_printed"]),
            ours=distance_difference(6.0, float(walk["distance_m"])),
            note="recomputed from the printed distances",
        )
        for walk in walks
        if walk["optimization"] == "without"
    ]
    title = "Figures 24, 26, 28: gain in distance"
    gains = PrintedTable(title=title, unit="%", digits=2, rows=rows)
    lengths = [
        PrintedNumber(
            label=f"experiment {walk['experiment']}, {walk['optimization']}",
            printed=float(walk["distance_m"]),
            ours=float(walk["steps"]) * float(walk["X_mm"]) / 1e3,
            note=f"{walk['steps']} steps of the printed {walk['X_mm']} mm",
        )
        for walk in walks
    ]
    title = "Figures 24, 26, 28: distance, and steps times step"
    distances = PrintedTable(title=title, unit="m", digits=2, rows=lengths)
    return [gains, distances, _pitch(store)]


def _pitch(store: Path) -> PrintedTable:
    """Printed pitch amplitude beside the median of the simulated walks, X read as foot travel."""
    found = trials(store, FIGURES, WALKED)
    one = load_reference("eros_table7").readings["foot_travel"].one
    rows = [
        _amplitude(printed, found if found.empty else walks_of(found, printed, printed.x * one))
        for setting in published_settings().values()
        for printed in setting.values()
    ]
    title = "Figures 24, 26, 28: pitch amplitude on pedestal 1, simulated median where there is one"
    return PrintedTable(title=title, unit="degrees", digits=1, rows=rows)


def _amplitude(printed: Published, trials: pd.DataFrame) -> PrintedNumber:
    """Of the simulated walks those without or with heel strike, as it was printed."""
    notes = [f"fell after {printed.distance} m in print"] if printed.fell else []
    median = None
    if "pitch_amplitude" in trials:
        walked = trials[trials["gait.heel_strike"].ne("none") == printed.optimised]
        angles = pd.to_numeric(walked["pitch_amplitude"], errors="coerce").dropna()
        fell = int(walked["fell"].fillna(value=False).astype(bool).sum())
        notes.append(f"{fell} of {len(walked)} fell, {len(angles)} walked a whole cycle")
        median = float(np.degrees(angles.median())) if len(angles) else None
    return PrintedNumber(
        label=f"{printed.figure}, {'with' if printed.optimised else 'without'}",
        printed=printed.amplitude,
        ours=median,
        note="; ".join(notes),
    )
