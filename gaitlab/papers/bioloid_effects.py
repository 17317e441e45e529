"""What the mistakes of the Bioloid paper amount to; `printed/bioloid.yaml` names these functions.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.planar_leg import LegAngles, ankle_position
from gaitlab.papers.bioloid_tables import (
    ALPHA,
    BETA,
    LENGTHS,
    LIFT_LEFT,
    LIFT_RIGHT,
    OMEGA,
    ROBOTS,
    SIDES,
    STEP_LEFT,
    STEP_RIGHT,
    Side,
    averages,
    calculated,
    common_lean,
    corrected_positions,
    measured,
    off_grid,
    positions,
    recomputed,
    sole_angle,
    stated,
    targets,
)
from gaitlab.papers.page import Numbers


def planar() -> Numbers:
    """How far a planar leg stays short of its target in cm, and its error of beta in degrees."""
    off = [recomputed(side, "spatial") - recomputed(side) for side in SIDES]
    coupling_error = float(np.abs(np.stack(off)[..., ALPHA : BETA + 1]).max())
    return {"short": _short_of(), "beta": coupling_error}


def behind() -> Numbers:
    """Turn of the hip the wrong way for an ankle behind it, in degrees."""
    both = np.concatenate([targets(side)[:, :2] for side in SIDES])
    lean = np.radians(common_lean()[LIFT_LEFT])
    # Ahead of the hips once the torso's lean is taken out, in cm.
    level_x = both[:, 0] * np.cos(lean) - both[:, 1] * np.sin(lean)
    return {"behind": 2.0 * np.degrees(np.arctan2(-level_x.min(), 11.5))}


def _short_of() -> float:
    """Largest distance of a planar leg's ankle from its target, in cm."""
    found = []
    for side in SIDES:
        angles = LegAngles(*np.radians(recomputed(side)).T)
        ankle = 100.0 * ankle_position(angles, coupling="spatial", **LENGTHS)
        found.append(np.linalg.norm(ankle - targets(side), axis=1).max())
    return float(max(found))


def soles_apart() -> Numbers:
    """Largest angle between the soles, in degrees."""
    return {"apart": sole_angle()}


def theta() -> Numbers:
    """Roll of the right hip in lift left as printed and as it should be, in degrees."""
    x, y, z = targets("right")[LIFT_LEFT]
    printed, right = np.degrees([np.arctan(x / y), np.arctan2(z, y)])
    return {"printed": printed, "right": right}


def _calculated(side: Side, pose: int, angle: int) -> dict[str, object]:
    """A calculated angle as printed, by its equation, and how far they are apart, in degrees."""
    printed, right = (float(found(side)[pose, angle]) for found in (calculated, recomputed))
    return {"printed": printed, "right": right, "off": printed - right}


def omega() -> Numbers:
    """Roll of the right ankle in lift left, and what the robots measured, in degrees."""
    found = [measured(robot, "right")[LIFT_LEFT, OMEGA] for robot in ROBOTS]
    told = " and ".join(f"{angle:+.2f}" for angle in found)
    return _calculated("right", LIFT_LEFT, OMEGA) | {"measured": told}


def beta() -> Numbers:
    """Knee of the left leg in lift right, in degrees."""
    return _calculated("left", LIFT_RIGHT, BETA)


def _misplaced(side: Side, robot: int, pose: int, axis: int) -> Numbers:
    """A decimal point in the wrong place, told by the mean that the abstract states, in cm."""
    return {
        "printed": positions(robot, side)[pose, axis],
        "right": corrected_positions(side)[robot - 1, pose, axis],
        "raw": averages(side, False)[axis],
        "mended": averages(side, True)[axis],
    }


def right_z() -> Numbers:
    """Table 5, step right."""
    return _misplaced("right", 1, STEP_RIGHT, 2)


def left_x() -> Numbers:
    """Table 6, step left."""
    return _misplaced("left", 2, STEP_LEFT, 0)


def _grid(robot: int, side: Side) -> Numbers:
    """The one measured angle of a table that the servo cannot report, in degrees."""
    angles = (float(angle) for angle in measured(robot, side).ravel())
    ((printed, grid),) = [(a, near) for a in angles if (near := off_grid(a)) is not None]
    return {"printed": printed, "grid": grid, "off": printed - grid + 0.0}


def grid_7() -> Numbers:
    """Table 7, step left."""
    return _grid(1, "right")


def grid_8() -> Numbers:
    """Table 8, upright."""
    return _grid(1, "left")


def grid_9() -> Numbers:
    """Table 9, step right."""
    return _grid(2, "right")


def _mean(side: Side, column: int) -> Numbers:
    """A mean error of the abstract as stated and from the mended tables."""
    printed, right = stated(side)[column], averages(side, True)[column]
    return {"printed": printed, "right": right, "off": right - printed}


def mean_y() -> Numbers:
    """Of the right leg's Y, in cm."""
    return _mean("right", 1)


def mean_omega() -> Numbers:
    """Of the left leg's omega, in degrees."""
    return _mean("left", 7)
