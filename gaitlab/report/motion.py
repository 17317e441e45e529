"""How the robot moves in one telling cell: balance, foot paths and joints of its shown seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from gaitlab.log import TrialLog
from gaitlab.render.kept_figures import draw
from gaitlab.report.falls import fallen
from gaitlab.report.figures.balance import OUTSIDE, WalkPanel, balance_figure
from gaitlab.report.figures.foot_paths import CYCLES, foot_figure
from gaitlab.report.figures.joint_loads import joint_figure, most_loaded, shown_rows
from gaitlab.report.markdown import escape, image
from gaitlab.report.representative import RepresentativeTrial, representative_cell, walks_of
from gaitlab.report.results import Results
from gaitlab.report.variants import Value
from gaitlab.report.words import place_text, surface_text
from gaitlab.simulation.trial import Trial

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES = 5
BEFORE = 1.0  # s, first frame before the fall is established; most falls take less
SEEN = 0.2  # s, time to the fall from which on there is a walk to see
LINES = 11  # seeds drawn thin beside the shown one


def motion_blocks(results: Results, folder: Path) -> list[str]:
    """Pictures and captions, the figures written into the folder; empty if nothing was done."""
    place = representative_cell(results)
    walks = walks_of(results, *place) if place else []
    if place is None or not walks:
        return []
    return [
        *strip_blocks(results, folder),
        _introduction(results, *place),
        _balance(results, walks, folder),
        _feet(walks, folder),
        _joints(walks, folder),
    ]


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


def _balance(results: Results, walks: Sequence[RepresentativeTrial], folder: Path) -> str:
    columns = [
        WalkPanel(walk=walk, others=[results.log(name) for name in walk.others[:LINES]])
        for walk in walks
    ]
    shown = [(_shown(column.walk), column.others) for column in columns]
    draw(folder, "balance", shown, lambda: balance_figure(columns))
    picture = image("Trunk pitch and roll, ZMP and loaded feet against time", "balance.png")
    return f"{picture}\n\n{BALANCE}"


BALANCE = f"""\
Pitch is positive leaning forward, roll leaning right; both leave the picture in a fall. Dashed
lines are the median pitch of the walk ± the seed's pitch amplitude. The ZMP is seen along and
across the first heading over the extent of the loaded soles, and red where it lies more than
{1000 * OUTSIDE:.0f} mm outside the support polygon. The shading behind is what the gait
commands, the bars at the foot of the picture are the soles that carry load."""


def _feet(walks: Sequence[RepresentativeTrial], folder: Path) -> str:
    draw(folder, "feet", list(map(_shown, walks)), lambda: foot_figure(walks))
    picture = image("Paths of heel, toe and ankle over the ground", "feet.png")
    sunk = any(walk.log.header.pile_height > 0.0 for walk in walks)
    depth = " What is drawn below the top of the pile has sunk into it." if sunk else ""
    return (
        f"{picture}\n\nThe sagittal plane over {CYCLES:.0f} gait cycles, up to the fall or in the "
        f"middle of the walk; heights are stretched.{depth}"
    )


def _joints(walks: Sequence[RepresentativeTrial], folder: Path) -> str:
    walk = max(walks, key=lambda walk: walk.falls)
    if not most_loaded(walk, shown_rows(walk.log)):
        return ""
    draw(folder, "joints", _shown(walk), partial(joint_figure, walk))
    picture = image("Position, velocity and torque of the most loaded joints", "joints.png")
    who = f"*{escape(walk.label)}*, seed {walk.seed}" if walk.label else f"seed {walk.seed}"
    return (
        f"{picture}\n\nThe three joints that come nearest to their torque limit, {who}, over the "
        "same time. Limits of position are the robot's, those of velocity and torque the "
        "servo's at its supply voltage."
    )


def _shown(walk: RepresentativeTrial) -> tuple[object, ...]:
    """What a figure of a walk shows of it; its trial by the id, which stands for all of it."""
    return (walk.title, walk.trial.id, walk.log, walk.amplitude)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One trial of the strip."""

    label: str
    seed: int
    name: str
    trial: Trial
    log: TrialLog

    def figure(self, times: np.ndarray) -> Figure:
        """Instants of it, in [s] since walking at full amplitude began."""
        from gaitlab.render.scene import Recorded
        from gaitlab.render.stills import still_figure

        return still_figure(Recorded(self.name, self.trial, self.log), times)


def strip_blocks(results: Results, folder: Path) -> list[str]:
    """Images and caption, the figures written into the folder; empty when nobody fell."""
    shots = _shots(results)
    if not shots:
        return []
    log = shots[0].log
    end = log["time"][-1 if log.fall_index is None else log.fall_index]
    times = np.linspace(max(end - BEFORE, log["time"][0]), end, FRAMES) - log.header.startup_time
    blocks = []
    for name, shot in zip(("fall", "same_seed"), shots, strict=False):
        shown = (shot.name, shot.trial.id, shot.log, times)
        draw(folder, name, shown, partial(shot.figure, times))
        blocks.append(image(f"{shot.label}, seed {shot.seed}, frame by frame", f"{name}.png"))
    return [*blocks, _caption(shots)]


def _shots(results: Results) -> list[Shot]:
    """First fall of the first variant on the highest pile; its cell and seed in the last one."""
    falls = fallen(results.trials)
    if falls.empty:
        return []
    heights = {name: _height(results, falls, name) for name in dict.fromkeys(falls["surface"])}
    order = {variant.label: i for i, variant in enumerate(results.variants)}
    falls = falls[falls["surface"] == max(heights, key=lambda name: heights[name])]
    falls = falls.sort_values("variant", key=lambda labels: labels.map(order), kind="stable")
    late = falls[pd.to_numeric(falls["time_to_fall"]) > SEEN]
    fall = (late if len(late) else falls).iloc[0]
    keys = [results.rows, results.columns, "surface", "seed"]
    same = results.done[(results.done[keys] == fall[keys]).all(axis=1)]
    others = same[same["variant"] != fall["variant"]]
    rows = [fall] if others.empty else [fall, others.iloc[-1]]
    return [_shot(results, row) for row in rows]


def _height(results: Results, falls: pd.DataFrame, surface: str) -> float:
    first = falls[falls["surface"] == surface].iloc[0]
    return float(results.trial(str(first["trial_id"])).surface.height)


def _shot(results: Results, row: pd.Series) -> Shot:
    name = str(row["trial_id"])
    return Shot(
        label=str(row["variant"]),
        seed=int(row["seed"]),
        name=name,
        trial=results.trial(name),
        log=results.log(name),
    )


def _caption(shots: Sequence[Shot]) -> str:
    first, walked = shots[0], shots[0].trial
    text = (
        f"The first fall on the highest pile: *{escape(first.label)}* on "
        f"{escape(surface_text(walked.names.surface))}, seed {first.seed}, "
        f"step length {walked.gait.step_length:.3g} m, the last frame when the fall is "
        "established."
    )
    if len(shots) > 1:
        text += f" Below it the same instants of the same seed with *{escape(shots[1].label)}*."
    return f"{text} Times count from the start of walking at full amplitude; drawn from the log."
