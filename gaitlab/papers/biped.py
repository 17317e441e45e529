"""The audit of the minimum-actuation biped: printed angles and time law, figures, simulated walks.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitlab.gaits.biped import Gait
from gaitlab.gaits.biped_bent_knee import Gait as BentKnee
from gaitlab.kinematics.belt_leg import ankle_position, segment_angles
from gaitlab.kinematics.point_mass_stance import Effort, StanceEffort, stance_effort
from gaitlab.papers._biped_print import (
    WALK,
    boundary_angles,
    errata,
    lowest_point,
)
from gaitlab.papers._biped_walks import effort_table, gantry_table, verdict, walks
from gaitlab.papers.page import Page, Picture, Table
from gaitlab.parameters import Parameter, parameters
from gaitlab.picture.figure_style import save, vector_figures
from gaitlab.report.strides import Postures, joint_figure, stick_figure
from gaitlab.robots.biped import Robot
from gaitlab.servos.files import load_servo

JOINTS = {f"phi_{leg + 1},{part + 1}": (leg, part) for leg in (0, 1) for part in (0, 1)}
STICKS = 13  # postures a stride in the stick diagram
FRACTIONS = (0.93, 0.90, 0.85)  # of the leg's length, hips over the ankles on bent knees
PAPER = (
    "H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, *Design and Trajectory Planning of Bipedal "
    "Walking Robot with Minimum Sufficient Actuation System*."
)


def audit(store: Path) -> Page:
    """The page; what is simulated is read from a store.

    Args:
        store: Folder of the results of `biped_straight`, `biped_bent_knee` and `biped_gantry`.
    """
    found = walks(store)
    return Page(
        title="The biped of four motors",
        paper=PAPER,
        summary=f"{_AGREES} {verdict(found)} {_STANDS}",
        comparisons=[boundary_angles()],
        errata=errata(),
        assumptions=list(_assumptions()),
        tables=[
            _via_table(),
            _peak_table(),
            _clearance_table(),
            _theory_table(),
            effort_table(found),
            gantry_table(store),
        ],
        pictures=list(_pictures()),
    )


_AGREES = (
    "The paper prints formulas and four plots, no number. The angles of all strides and the time "
    "law hold once the mistakes listed below are mended; position, velocity and acceleration of "
    "every joint are then continuous. The plots (Figs 6 to 9) are lost in the copy at hand and "
    "ours can only be compared by their description."
)
_STANDS = (
    "All walks hang on a gantry that holds the trunk level, in place of the balancing mechanism "
    "that the paper names and does not describe: nothing here says that the robot balances. Its "
    "efficiency against other robots cannot be decided, because the paper measures none."
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


ENDINGS = ("printed", "corrected", "late")


def _changed(ending: str, **lengths: float) -> Gait:
    return replace(WALK, ending=ending, **lengths)  # type: ignore[arg-type]


def _theory_table() -> Table:
    ways = {"straight": _straight_stance(), **{f"hips at {f:.2f}": _bent(f) for f in FRACTIONS}}
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


def _cells(effort: Effort) -> list[str]:
    return [f"{effort.peak:.1f}", f"{effort.work:.2f}", f"{effort.heat:.0f}"]


def _straight_stance() -> StanceEffort:
    t = np.linspace(1.0, 3.0, 4001) * WALK.half_stride
    return _stance(WALK.joint_motion(t).position[:, 1], t[1] - t[0])


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
                yield f"{item.name}: {item.doc}", _default(item)
    motor = load_servo("biped_motor")
    yield (
        "motors",
        f"{motor.stall_torque:g} N m at rest, {motor.no_load_speed:g} rad/s without load",
    )
    yield "masses", f"{Robot().tree.mass:g} kg in all"
    yield "which cruise speeds are possible", "above the mean speed of the segment, up to twice it"
    yield "balance", "a gantry that holds lateral motion, roll, yaw and pitch"


def _default(item: Parameter) -> str:
    number = isinstance(item.default, float)
    shown = f"{item.default:.4g}" if number else str(item.default)
    return shown if item.unit == "-" else f"{shown} {item.unit}"


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
        with vector_figures():
            return save(joint_figure(t, courses, label), folder, name)

    return draw


def _draw_sticks(folder: Path, name: str) -> object:
    ends = np.array([0.0, 1.0, 3.0, 4.0]) * WALK.half_stride
    strides = {
        f"{kind} stride": postures(np.linspace(start, end, STICKS))
        for kind, start, end in zip(("starting", "full", "ending"), ends, ends[1:], strict=False)
    }
    with vector_figures():
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
