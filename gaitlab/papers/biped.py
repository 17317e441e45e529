"""The audit of the minimum-actuation biped: printed angles and time law, figures, simulated walks.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.biped import Gait
from gaitlab.gaits.biped_bent_knee import Gait as BentKnee
from gaitlab.kinematics.belt_leg import (
    MotorEffort,
    StanceEffort,
    ankle_position,
    segment_angles,
    stance_effort,
)
from gaitlab.papers import biped_effects
from gaitlab.papers.biped_effects import WALK, boundary_angles, lowest_point
from gaitlab.papers.page import (
    Page,
    Picture,
    Table,
    assumptions_of,
    default_text,
    errata_of,
    text_of,
)
from gaitlab.papers.walks import not_simulated, share_text, spread_text, trials
from gaitlab.parameters import parameters
from gaitlab.render.figure_style import BLUE, CYCLE, FAINT, INK, ORANGE, new_figure, save, style
from gaitlab.robots.biped import Robot

STRAIGHT, BENT, GANTRY = "biped_straight", "biped_bent_knee", "biped_gantry"
HIPS, RIG = "gait.hip_height", "robot.gantry"
STRAIGHT_LEGS = "straight legs"
ENDED = ("DONE", "INFEASIBLE")
FIGURES = (  # metric, title, factor to the unit shown, digits
    ("energy", "positive work [J]", 1.0, 1),
    ("absolute_work", "work either way [J]", 1.0, 1),
    ("cost_of_transport", "cost of transport [-]", 1.0, 3),
    ("peak_torque", "peak torque [N m]", 1.0, 1),
    ("rms_torque", "RMS torque [N m]", 1.0, 2),
    ("rms_balancing_moment", "RMS gantry moment [N m]", 1.0, 1),
    ("peak_balancing_moment", "peak gantry moment [N m]", 1.0, 1),
    ("distance", "distance [m]", 1.0, 3),
    ("sole_penetration", "stance sole in the floor [mm]", 1e3, 3),
    ("coupling_residual", "gear residual [deg]", float(np.degrees(1.0)), 3),
)
EFFORTS = ("energy", "cost_of_transport", "peak_torque", "rms_torque")
JOINTS = {f"phi_{leg + 1},{part + 1}": (leg, part) for leg in (0, 1) for part in (0, 1)}
STICKS = 13  # postures a stride in the stick diagram
FRACTIONS = (0.93, 0.90, 0.85)  # of the leg's length, hips over the ankles on bent knees
ENDINGS = ("printed", "corrected", "late")


def audit(store: Path) -> Page:
    """The page; what is simulated is read from a store.

    Args:
        store: Folder of the results of `biped_straight`, `biped_bent_knee` and `biped_gantry`.
    """
    found = walks(store)
    return Page(
        title=text_of("biped", "title"),
        paper=text_of("biped", "paper"),
        summary=text_of("biped", "summary", walks=verdict(found)),
        comparisons=[boundary_angles()],
        errata=errata_of("biped", biped_effects),
        assumptions=list(_assumptions()),
        tables=[
            _via_table(),
            _peak_table(),
            _clearance_table(),
            _theory_table(),
            effort_table(found, store),
            gantry_table(store),
        ],
        pictures=list(_pictures()),
    )


def _via_table() -> Table:
    t = np.arange(0.0, WALK.duration + 0.25, 0.5 * WALK.half_stride)
    degrees = np.degrees(WALK.joint_motion(t).position)
    rows = [
        [name, *(f"{value:.2f}" for value in degrees[:, leg, part] + 0.0)]
        for name, (leg, part) in JOINTS.items()
    ]
    times = [f"{moment / WALK.half_stride:g} t_f" for moment in t]
    text = "Joint angles [deg] every half t_f; leg 1 supports in the starting stride."
    return Table(title="Joint positions (Fig. 7)", text=text, header=["", *times], rows=rows)


def _peak_table() -> Table:
    printed = replace(WALK, ending="printed")
    motion = printed.joint_motion(np.linspace(0.0, printed.duration, 8001))
    corrected = WALK.joint_motion(np.linspace(0.0, WALK.duration, 8001))
    bent = _bent_knee_peaks()
    rows = [
        [name, *(f"{_peak(q, joint):.3f}" for q in (*motion[1:], *corrected[1:]))]
        for name, joint in JOINTS.items()
    ]
    text = (
        f"With t_f = {WALK.half_stride:g} s. Walking on bent knees with the hips at 0.90 of the "
        f"leg's length needs {bent[0]:.2f} rad/s and {bent[1]:.2f} rad/s^2 at most."
    )
    header = ["", "speed, printed ending [rad/s]", "acceleration [rad/s^2]"]
    header += ["speed, corrected ending [rad/s]", "acceleration [rad/s^2]"]
    return Table(title="Peaks of speed and acceleration (Figs 8, 9)", text=text, header=header,
                 rows=rows)  # fmt: skip


def _peak(quantity: np.ndarray, joint: tuple[int, int]) -> float:
    return float(np.abs(quantity[:, joint[0], joint[1]]).max())


def _bent_knee_peaks() -> tuple[float, float]:
    """Largest speed and acceleration of a joint over a cycle at full steps."""
    gait = BentKnee(step_length=WALK.step_length, step_height=WALK.step_height)
    t = gait.startup_time + np.linspace(0.0, gait.gait_period, 4001)
    ankle = gait.feet(t).position[..., [0, 2]] + [0.0, WALK.ankle_height]
    speed = np.gradient(segment_angles(ankle, WALK.segment), t, axis=0)
    return float(np.abs(speed).max()), float(np.abs(np.gradient(speed, t, axis=0)[2:-2]).max())


def _clearance_table() -> Table:
    lengths = [(0.20, 0.30, 0.05), (0.20, 0.30, 0.03), (0.15, 0.25, 0.03), (0.30, 0.40, 0.05)]
    rows = []
    for step, segment, height in lengths:
        names = {"step_length": step, "segment": segment, "step_height": height}
        lowest = (lowest_point(_changed(ending, **names)) for ending in ENDINGS)
        rows.append([f"{step} / {segment} / {height}", *(f"{1e3 * z:+.3f}" for z in lowest)])
    return Table(
        title="Lowest point of the trailing foot in the ending stride",
        text="Planned, in [mm]; below 0 the foot digs into the floor.",
        header=["S / l / h [m]", *ENDINGS],
        rows=rows,
    )


def _changed(ending: str, **lengths: float) -> Gait:
    return replace(WALK, ending=ending, **lengths)  # type: ignore[arg-type]


def _theory_table() -> Table:
    t = np.linspace(1.0, 3.0, 4001) * WALK.half_stride
    straight_stance = _stance(WALK.joint_motion(t).position[:, 1], t[1] - t[0])
    ways = {"straight": straight_stance, **{f"hips at {f:.2f}": _bent(f) for f in FRACTIONS}}
    rows = [[name, *_cells(way.belts), *_cells(way.joints)] for name, way in ways.items()]
    text = (
        f"All {Robot().tree.mass:g} kg in the hips, massless legs, no moment at the ankle; "
        "positive work, and the integral of torque squared, which is what heats a motor. Six such "
        "stances are what is simulated below."
    )
    header = ["one stance of 2 t_f"]
    for drive in ("belts", "motors in the joints"):
        header += [f"{drive}: peak [N m]", "work [J]", "heat [N^2 m^2 s]"]
    return Table(title="What one stance should cost", text=text, header=header, rows=rows)


def _cells(effort: MotorEffort) -> list[str]:
    return [f"{effort.peak:.1f}", f"{effort.work:.2f}", f"{effort.heat:.0f}"]


def _bent(fraction: float) -> StanceEffort:
    t = np.linspace(0.0, 2.0, 4001) * WALK.half_stride
    hips = WALK.step_length * np.linspace(-0.5, 0.5, len(t))
    ankle = np.stack([-hips, np.full_like(hips, -2.0 * WALK.segment * fraction)], axis=-1)
    return _stance(segment_angles(ankle, WALK.segment), t[1] - t[0])


def _stance(angles: np.ndarray, dt: float) -> StanceEffort:
    hips = -ankle_position(angles, WALK.segment)
    acceleration = np.gradient(np.gradient(hips, dt, axis=0), dt, axis=0)
    return stance_effort(angles, acceleration, dt, mass=Robot().tree.mass, segment=WALK.segment)


def _assumptions() -> Iterator[tuple[str, str]]:
    for cls in (Gait, Robot):
        for item in parameters(cls):
            if item.source.startswith("assumption"):
                yield f"{item.name}: {item.doc}", default_text(item)
    yield from assumptions_of("biped", biped_effects)


def _pictures() -> Iterator[Picture]:
    yield Picture(
        name="stick_diagram",
        caption="A starting, a full and an ending stride as sticks (as the paper's Fig. 6)",
        draw=_draw_sticks,
    )
    labels = ("position [rad]", "velocity [rad/s]", "acceleration [rad/s^2]")
    for number, label in enumerate(labels):
        name = label.split(" [")[0]
        yield Picture(
            name=f"joint_{name}",
            caption=f"Joint {name} during the walk (as the paper's Fig. {7 + number})",
            draw=_drawing(number, label),
        )


def _drawing(quantity: int, label: str) -> Callable[[Path, str], object]:
    def draw(folder: Path, name: str) -> object:
        t = np.linspace(0.0, WALK.duration, 2001)
        motion = WALK.joint_motion(t)[quantity]
        courses = {joint: motion[:, leg, part] for joint, (leg, part) in JOINTS.items()}
        return save(joint_figure(t, courses, label), folder, name)

    return draw


def _draw_sticks(folder: Path, name: str) -> object:
    ends = np.array([0.0, 1.0, 3.0, 4.0]) * WALK.half_stride
    strides = {
        f"{kind} stride": postures(np.linspace(start, end, STICKS))
        for kind, start, end in zip(("starting", "full", "ending"), ends, ends[1:], strict=False)
    }
    return save(stick_figure(strides), folder, name)


def postures(t: np.ndarray) -> Postures:
    """The figures' walk at the instants t, in [s]; supporting ankles are at 0, at S and at 2 S."""
    angles = WALK.joint_motion(t).position
    ankle = ankle_position(angles, WALK.segment)
    stride = np.clip(np.floor((t / WALK.half_stride + 1.0) / 2.0 + 1e-9), 0, 2).astype(int)
    spot = np.stack([WALK.step_length * stride, np.zeros(len(t))], axis=-1)
    hips = spot - ankle[np.arange(len(t)), stride % 2]
    thigh = angles[..., 0]
    knee = WALK.segment * np.stack([np.sin(thigh), -np.cos(thigh)], axis=-1)
    return Postures(hips, hips[:, None] + knee, hips[:, None] + ankle)


def walks(store: Path) -> dict[str, pd.DataFrame]:
    """Trials of every way of walking by what it is called; empty when none was simulated."""
    straight, bent = (trials(store, name, ENDED) for name in (STRAIGHT, BENT))
    found = {} if straight.empty else {STRAIGHT_LEGS: straight}
    if not bent.empty:
        for height in sorted(bent[HIPS].unique(), reverse=True):
            found[f"bent, hips {height} m up"] = bent[bent[HIPS] == height]
    return found


def effort_table(found: dict[str, pd.DataFrame], store: Path) -> Table:
    """Median and range of every figure, a column a way of walking."""
    text = (
        "The same robot, gantry, floor, speed and footholds; median [smallest, largest] over the "
        "seeds, measured over three cycles after the start-up. From the experiments "
        f"`{STRAIGHT}` and `{BENT}`."
    )
    if not found:
        text = not_simulated("biped", store, STRAIGHT, BENT)
    table = [["n", *(str(len(walk)) for walk in found.values())]]
    table.append(["stayed up", *(share_text(walk["stable"]) for walk in found.values())])
    table += [
        [title, *(spread_text(walk[name], digits, factor) for walk in found.values())]
        for name, title, factor, digits in FIGURES
    ]
    return Table(
        title="Energy and torque beside walking on bent knees",
        text=text,
        header=["", *found],
        rows=table if found else [],
    )


def gantry_table(store: Path) -> Table:
    """How many seeds stay up with and without the gantry, and when the others fall."""
    found, planned = trials(store, GANTRY, ENDED), plan(load_experiment(GANTRY)).size
    text = (
        "Straight legs; seeds that stayed up with a 95 % Wilson interval, median time from the end "
        f"of the starting stride to the fall; {len(found)} of {planned} planned trials are in the "
        "store."
    )
    if found.empty:
        text = not_simulated("biped", store, GANTRY)
    grounds = [] if found.empty else list(dict.fromkeys(found["surface"]))
    table = [] if found.empty else list(_gantry_rows(found, grounds))
    return Table(
        title="With the gantry and without", text=text, header=["gantry", *grounds], rows=table
    )


def _gantry_rows(found: pd.DataFrame, grounds: Sequence[str]) -> Iterator[list[str]]:
    for rig in dict.fromkeys(found[RIG]):
        cells = [found[(found[RIG] == rig) & (found["surface"] == g)] for g in grounds]
        yield [str(rig), *(_standing(cell) for cell in cells)]


def _standing(cell: pd.DataFrame) -> str:
    if cell.empty:
        return "–"
    times = cell["time_to_fall"].astype(float).dropna()
    fallen = f", falls after {times.median():.2f} s" if len(times) else ""
    return share_text(cell["stable"]) + fallen


def verdict(found: dict[str, pd.DataFrame]) -> str:
    """Which way of walking needs less, figure by figure, with n; says so when nothing is there."""
    straight = found.get(STRAIGHT_LEGS)
    bent = {name: walk for name, walk in found.items() if name != STRAIGHT_LEGS}
    if straight is None or not bent:
        return "Whether straight legs cost less than bent ones has not been simulated yet."
    titles = {name: title.split(" [")[0] for name, title, _, _ in FIGURES}
    parts = [f"{titles[name]} {_changes(straight[name], bent, name)}" for name in EFFORTS]
    n = min(len(walk) for walk in found.values())
    heights = ", ".join(name.removeprefix("bent, ") for name in bent)
    return (
        f"Beside bent knees at the same speed and footholds ({heights}; n = {n} each) straight "
        f"legs take, in the median: {'; '.join(parts)}. Ranges that overlap count as no difference."
    )


def _changes(straight: pd.Series, bent: dict[str, pd.DataFrame], name: str) -> str:
    """Change from each bent walk to the straight one, in words."""
    ours, said = straight.astype(float), []
    for walk in bent.values():
        other = walk[name].astype(float)
        apart = ours.max() < other.min() or ours.min() > other.max()
        change = 100.0 * (ours.median() / other.median() - 1.0)
        said.append(f"{change:+.0f} %" if apart else "no difference")
    return ", ".join(said)


class Postures(NamedTuple):
    """Two legs at one instant after another, forward and up.

    Attributes:
        hips: In [m]. Shape (n, 2).
        knees: Of leg 1 and leg 2, in [m]. Shape (n, 2, 2).
        ankles: Likewise. Shape (n, 2, 2).
    """

    hips: np.ndarray
    knees: np.ndarray
    ankles: np.ndarray


def stick_figure(strides: Mapping[str, Postures]) -> Figure:
    """Both legs at one instant after another with the hips' path, one panel a stride."""
    with style():
        figure = new_figure(height=3.6)
        axes = figure.subplots(1, len(strides), sharex=True, sharey=True, squeeze=False)[0]
        for axis, (name, postures) in zip(axes, strides.items(), strict=True):
            _sticks(axis, postures)
            axis.set_title(name)
            axis.set_xlabel("forward [m]")
        axes[0].set_ylabel("height [m]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right center")
    return figure


def _sticks(axis: Axes, postures: Postures) -> None:
    for k, (hips, knees, ankles) in enumerate(zip(*postures, strict=True)):
        for leg, colour in ((0, BLUE), (1, ORANGE)):
            x, z = np.stack([hips, knees[leg], ankles[leg]], axis=-1)
            label = f"leg {leg + 1}" if k == 0 else None
            axis.plot(x, z, color=colour, linewidth=0.9, alpha=0.8, label=label)
    axis.plot(*postures.hips.T, color=INK, linewidth=1.4, label="hips")
    axis.axhline(0.0, color=FAINT, linewidth=1.0, zorder=0)
    axis.set_aspect("equal")


def joint_figure(t: np.ndarray, courses: Mapping[str, np.ndarray], what: str) -> Figure:
    """Courses over time, one panel above the other.

    Args:
        t: Instants, in [s]. Shape (n,).
        courses: Course by its name. Shape (n,) each.
        what: Label of the vertical axes, with its unit.
    """
    with style():
        figure = new_figure(height=1.15 * len(courses) + 0.6)
        axes = figure.subplots(len(courses), sharex=True, squeeze=False)[:, 0]
        for axis, (name, course), colour in zip(axes, courses.items(), CYCLE, strict=False):
            axis.plot(t, course, color=colour, linewidth=1.2)
            axis.axhline(0.0, color=FAINT, linewidth=0.8, zorder=0)
            axis.set_title(name)
        figure.supylabel(what, fontsize=9.0)
        axes[-1].set_xlabel("time [s]")
    return figure
