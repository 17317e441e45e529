"""How the robot moves in one telling cell: balance, foot paths and joints of its shown seeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gaitlab.picture.figure_style import save
from gaitlab.report.figures.balance import OUTSIDE, Column, balance_figure
from gaitlab.report.figures.foot_paths import CYCLES, foot_figure
from gaitlab.report.figures.joint_loads import joint_figure
from gaitlab.report.markdown import escape, image, section
from gaitlab.report.results import Results
from gaitlab.report.telling import Walk, telling_cell, walks_of
from gaitlab.report.variants import Value
from gaitlab.report.walks import BESIDE_WALKS, walks_table
from gaitlab.report.words import place_text

LINES = 11  # seeds drawn thin beside the shown one


def motion(results: Results, folder: Path) -> str:
    """The section with its figures written into the folder; empty if nothing was simulated."""
    place = telling_cell(results)
    walks = walks_of(results, *place) if place else []
    if place is None or not walks:
        return ""
    printed = walks_table(results)
    beside = f"{BESIDE_WALKS}\n\n{printed}" if printed else ""
    return section(
        "A closer look at one cell",
        _introduction(results, *place),
        _balance(results, walks, folder),
        _feet(walks, folder),
        _joints(walks, folder),
        beside,
    )


def _introduction(results: Results, row: Value, column: Value) -> str:
    where = escape(place_text(results, row, column))
    if len(results.variants) > 1:
        why = "the cell in which the variants' stable shares differ most"
    else:
        why = "the cell whose stable share is nearest to one half"
    return (
        f"On {where}: {why} (the first of equals). The shown seed is the one of median distance "
        "in its cell."
    )


def _balance(results: Results, walks: Sequence[Walk], folder: Path) -> str:
    columns = [
        Column(walk=walk, others=[results.log(name) for name in walk.others[:LINES]])
        for walk in walks
    ]
    save(balance_figure(columns), folder, "balance")
    picture = image("Trunk pitch and roll, ZMP and loaded feet against time", "balance.png")
    return f"{picture}\n\n{BALANCE}"


BALANCE = f"""\
Pitch is positive leaning forward, roll leaning right; both leave the picture in a fall. Dashed
lines are the median pitch of the walk ± the seed's pitch amplitude. The ZMP is seen along and
across the first heading over the extent of the loaded soles, and red where it lies more than
{1000 * OUTSIDE:.0f} mm outside the support polygon. The shading behind is what the gait
commands, the bars at the foot of the picture are the soles that carry load."""


def _feet(walks: Sequence[Walk], folder: Path) -> str:
    save(foot_figure(walks), folder, "feet")
    picture = image("Paths of heel, toe and ankle over the ground", "feet.png")
    sunk = any(walk.log.header.pile_height > 0.0 for walk in walks)
    depth = " What is drawn below the top of the pile has sunk into it." if sunk else ""
    return (
        f"{picture}\n\nThe sagittal plane over {CYCLES:.0f} gait cycles, up to the fall or in the "
        f"middle of the walk; heights are stretched.{depth}"
    )


def _joints(walks: Sequence[Walk], folder: Path) -> str:
    walk = max(walks, key=lambda walk: walk.falls)
    figure = joint_figure(walk)
    if figure is None:
        return ""
    save(figure, folder, "joints")
    picture = image("Position, velocity and torque of the most loaded joints", "joints.png")
    who = f"*{escape(walk.label)}*, seed {walk.seed}" if walk.label else f"seed {walk.seed}"
    return (
        f"{picture}\n\nThe three joints that come nearest to their torque limit, {who}, over the "
        "same time. Limits of position are the robot's, those of velocity and torque the "
        "servo's at its supply voltage."
    )
