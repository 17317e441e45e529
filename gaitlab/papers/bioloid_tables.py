"""Tables 1 to 10 of the Bioloid paper as arrays, and what its equations give for them.

Lengths in cm and angles in degrees here, as printed; rows are the five poses, in print order.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

from functools import cache
from typing import Literal, TypedDict

import numpy as np

from gaitlab.kinematics.planar_leg import AnkleLaw, Coupling, LegAngles, ankle_position, leg_angles
from gaitlab.papers.printed import rows
from gaitlab.robots.bioloid import BioloidLeg

Side = Literal["right", "left"]
SIDES: tuple[Side, Side] = ("right", "left")
ROBOTS = (1, 2)
POSES = ("Upright", "Lift left", "Step left", "Lift right", "Step right")
ANGLES, AXES = ("α", "β", "γ", "θ", "ω"), ("X", "Y", "Z")
ALPHA, BETA, GAMMA, THETA, OMEGA = range(5)
LIFT_LEFT, STEP_LEFT, LIFT_RIGHT, STEP_RIGHT = range(1, 5)

CALCULATED = {"right": 3, "left": 4}  # number of the table by leg
MEASURED = {(1, "right"): 7, (1, "left"): 8, (2, "right"): 9, (2, "left"): 10}
POSITIONS = {1: 5, 2: 6}
GRID = 0.293  # degrees, step in which RoboPlus shows an angle

_LEG = BioloidLeg()


class Lengths(TypedDict):
    """Thigh and shank, in [m]."""

    thigh: float
    shank: float


LENGTHS: Lengths = {"thigh": _LEG.thigh, "shank": _LEG.shank}


@cache
def _numbers(table: int) -> np.ndarray:
    """All numbers of a table, columns as printed. Shape (rows, columns)."""
    found = []
    for row in rows(f"bioloid_table{table}"):
        cells = (v for k, v in row.items() if k not in ("Position", "row_inferred", "note"))
        found.append([float(cell) for cell in cells])
    return np.array(found)


def targets(side: Side) -> np.ndarray:
    """Table 2: x, y, z from hip to ankle, in cm. Shape (5, 3)."""
    return _numbers(2)[:, _half(side)]


def calculated(side: Side) -> np.ndarray:
    """Tables 3 and 4: angles as printed. Shape (5, 5)."""
    return _numbers(CALCULATED[side])


def positions(robot: int, side: Side) -> np.ndarray:
    """Tables 5 and 6: measured x, y, z, in cm. Shape (5, 3)."""
    return _numbers(POSITIONS[robot])[:, _half(side)]


def measured(robot: int, side: Side) -> np.ndarray:
    """Tables 7 to 10: measured angles. Shape (5, 5)."""
    return _numbers(MEASURED[robot, side])


def _half(side: Side) -> slice:
    return slice(0, 3) if side == "right" else slice(3, 6)


def recomputed(
    side: Side,
    coupling: Coupling = "planar",
    ankle_law: AnkleLaw = "published",
    lean: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Angles of Table 2's targets by the corrected equations. Shape (5, 5)."""
    angles = leg_angles(
        targets(side) / 100.0,
        coupling=coupling,
        ankle_law=ankle_law,
        lean=np.radians(lean),
        **LENGTHS,
    )
    return np.degrees(np.stack(angles, axis=-1))


def lean_of(angles: np.ndarray) -> np.ndarray:
    """Lean of the torso over the sole that angles mean, in degrees. Shape (...)."""
    return angles[..., ALPHA] + angles[..., GAMMA] - angles[..., BETA]


def common_lean() -> np.ndarray:
    """Lean that the robots measured: the mean in upright, and over all other poses. Shape (5,)."""
    found = np.stack([lean_of(measured(r, s)) for r in ROBOTS for s in SIDES])
    walking = found[:, 1:].mean()
    return np.array([found[:, 0].mean(), *[walking] * 4])


def level_positions(robot: int, side: Side) -> np.ndarray:
    """Ankle of the measured angles, turned by the measured lean into the level frame, in cm.

    Y and X mix because the torso leans; the position tables were measured in the level frame.
    Shape (5, 3).
    """
    angles = measured(robot, side)
    legs = LegAngles(*np.radians(angles).T)
    x, y, _ = 100.0 * ankle_position(legs, **LENGTHS).T
    z = 100.0 * ankle_position(legs, coupling="spatial", **LENGTHS)[:, 2]
    lean = np.radians(lean_of(angles))
    return np.stack(
        [x * np.cos(lean) - y * np.sin(lean), x * np.sin(lean) + y * np.cos(lean), z], axis=-1
    )


def off_grid(angle: float) -> float | None:
    """Nearest angle that the servo can report, if the printed one is none. In degrees."""
    nearest = float(round(angle / GRID) * GRID)
    return None if abs(nearest - angle) < 0.02 else nearest


def mean_error(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Mean absolute error of both robots over the poses. Shapes (2, 5, k), (5, k) to (k,)."""
    return np.asarray(np.abs(found - wanted).mean(axis=(0, 1)))


def corrected_calculated(side: Side) -> np.ndarray:
    """Tables 3 and 4 without their two misprints, by equations (5), (6) and (9). Shape (5, 5)."""
    table = calculated(side).copy()
    if side == "right":
        table[LIFT_LEFT, OMEGA] = table[LIFT_LEFT, THETA]
    else:
        table[LIFT_RIGHT, BETA] = calculated("right")[LIFT_LEFT, BETA]
    return table


def corrected_positions(side: Side) -> np.ndarray:
    """Tables 5 and 6 of a leg without the two misplaced points. Shape (2, 5, 3)."""
    both = np.stack([positions(robot, side) for robot in ROBOTS])
    if side == "right":
        both[0, STEP_RIGHT, 2] /= 10.0  # 2.0 for 0.2
    else:
        both[1, STEP_LEFT, 0] *= 10.0  # 0.1 for 1.0
    return both


def averages(side: Side, corrected: bool) -> np.ndarray:
    """Mean errors of the abstract: X, Y, Z in cm, then the five angles in degrees. Shape (8,)."""
    raw = np.stack([positions(robot, side) for robot in ROBOTS])
    angles = np.stack([measured(robot, side) for robot in ROBOTS])
    wanted = corrected_calculated(side) if corrected else calculated(side)
    found = corrected_positions(side) if corrected else raw
    return np.concatenate([mean_error(found, targets(side)), mean_error(angles, wanted)])


def stated(side: Side) -> np.ndarray:
    """The same as the abstract states them. Shape (8,)."""
    table = rows("bioloid_abstract_averages")
    found = [row["Printed in abstract"] for row in table if row["Quantity"].startswith(side)]
    return np.array(found, dtype=float)


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
    right, left = (lean_of(recomputed(side)) for side in SIDES)
    return float(np.abs(right - left).max())


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
