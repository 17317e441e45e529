"""What the Bioloid paper's tables tell of its soles: their angle, and the frame of its positions.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.planar_leg import AnkleLaw
from gaitlab.papers._bioloid_tables import (
    AXES,
    GAMMA,
    POSES,
    ROBOTS,
    SIDES,
    averages,
    common_lean,
    level_positions,
    mean_error,
    measured,
    positions,
    recomputed,
)
from gaitlab.papers.page import Table


def gamma_errors() -> tuple[float, float]:
    """Mean error of the measured ankle pitch against eq. (7) and against level soles, degrees."""
    return _gamma_error("published"), _gamma_error("flat")


def _gamma_error(law: AnkleLaw) -> float:
    errors = [
        mean_error(
            np.stack([measured(robot, side) for robot in ROBOTS]),
            recomputed(side, ankle_law=law, lean=common_lean()),
        )
        for side in SIDES
    ]
    return float(np.mean(errors, axis=0)[GAMMA])


def sole_angle() -> float:
    """Largest angle between the soles under the published ankle law, in degrees."""
    right, left = (recomputed(side) for side in SIDES)
    lean = [a[:, 0] + a[:, 2] - a[:, 1] for a in (right, left)]
    return float(np.abs(lean[0] - lean[1]).max())


def offsets() -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of measured less computed X, Y, Z, in cm. Shape (3,) each."""
    off = np.concatenate(
        [
            positions(robot, side) - level_positions(robot, side)
            for robot in ROBOTS
            for side in SIDES
        ]
    )
    return off.mean(axis=0), off.std(axis=0)


def ankle_table() -> Table:
    """Lean of the torso over each sole: published law, level soles, measured."""
    table = []
    for i, pose in enumerate(POSES):
        law = [float(_lean(recomputed(side))[i]) for side in SIDES]
        found = [float(_lean(measured(r, side))[i]) for r in ROBOTS for side in SIDES]
        table.append([pose, *(f"{x:.2f}" for x in (*law, law[0] - law[1], *found))])
    header = ["lean [degrees]", "eq. (7) right", "eq. (7) left", "soles apart"]
    header += [f"robot {r} {side}" for r in ROBOTS for side in SIDES]
    text = (
        "Lean of the torso over the sole, α + γ − β. Both legs carry one torso, so a pose stands "
        "on level soles only if both leans are equal; the measured ones nearly are."
    )
    return Table(title="What the ankle law does to the soles", text=text, header=header, rows=table)


def _lean(angles: np.ndarray) -> np.ndarray:
    return np.asarray(angles[:, 0] + angles[:, 2] - angles[:, 1])


def position_table() -> Table:
    """How far the measured positions are from Table 2, and from the turned measured angles."""
    shift, spread = offsets()
    raw = [averages(side, False)[:3].mean() for side in SIDES]
    rows_ = [
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
    return Table(title="Positions are a mix-up of frames", text=text, header=header, rows=rows_)
