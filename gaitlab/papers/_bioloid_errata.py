"""What is wrong in print in the Bioloid paper, each with the size of the error it causes.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
    ROBOTIS-eManual: e-Manual of the Dynamixel AX-12A, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gaitlab.kinematics.planar_leg import LegAngles, ankle_position
from gaitlab.log import GRAVITY
from gaitlab.papers._bioloid_tables import (
    ALPHA,
    ANGLES,
    BETA,
    LENGTHS,
    LIFT_LEFT,
    LIFT_RIGHT,
    MEASURED,
    OMEGA,
    POSES,
    ROBOTS,
    SIDES,
    STEP_LEFT,
    STEP_RIGHT,
    Side,
    averages,
    calculated,
    common_lean,
    corrected_positions,
    lean_of,
    measured,
    off_grid,
    positions,
    recomputed,
    stated,
    targets,
)
from gaitlab.papers.page import Erratum, Table
from gaitlab.servos.files import load_servo

RATED_SHARE = 0.2  # of stall, up to which ROBOTIS calls an AX-12 stable
ABOVE_KNEE = 2.7  # kg, an assumption: the robot without one shank and foot


def errata() -> list[Erratum]:
    """All of them, in the order of the paper."""
    return [*_of_equations(), *_of_tables(), *_of_text()]


def _of_equations() -> Iterator[Erratum]:
    yield Erratum(
        where="eq. (1)",
        printed="R = √(x² + y²)",
        correct="R = √(x² + y² + z²), because a leg rolled by θ has to span √(y² + z²)",
        effect=f"ankle up to {_short_of():.2f} cm short of its target, "
        f"β up to {_coupling_error():.2f} degrees off",
    )
    behind = 2.0 * np.degrees(np.arctan2(-_level_x().min(), 11.5))
    yield Erratum(
        where="eq. (2)",
        printed="α₁ = cos⁻¹(y / R)",
        correct="α₁ = atan2(x, y)",
        effect="none in Table 2, where every x > 0; an ankle as far behind the hip as level soles "
        f"of the step pose ask for would turn the hip by {behind:.1f} degrees the wrong way",
    )
    apart = max(
        abs(float(a - b))
        for a, b in zip(*(lean_of(recomputed(side)) for side in SIDES), strict=True)
    )
    yield Erratum(
        where="eq. (7)",
        printed="γ = 180° − α₂ − β₁ (= α₂)",
        correct="γ = β − α + λ with one lean λ for both legs",
        effect=f"soles up to {apart:.2f} degrees out of parallel (step poses)",
    )
    x, y, z = targets("right")[LIFT_LEFT]
    printed, correct = np.degrees([np.arctan(x / y), np.arctan2(z, y)])
    yield Erratum(
        where="eq. (8)",
        printed="θ = tan⁻¹(x / y)",
        correct="θ = atan2(z, y), which Tables 3 and 4 use",
        effect=f"{printed:.2f} instead of {correct:.2f} degrees (right leg, lift left)",
    )


def _level_x() -> np.ndarray:
    """Ankles ahead of the hips once the torso's lean is taken out, in cm. Shape (10,)."""
    both = np.concatenate([targets(side)[:, :2] for side in SIDES])
    lean = np.radians(common_lean()[LIFT_LEFT])
    return np.asarray(both[:, 0] * np.cos(lean) - both[:, 1] * np.sin(lean))


def _short_of() -> float:
    """Largest distance of a planar leg's ankle from its target, in cm."""
    found = []
    for side in SIDES:
        angles = LegAngles(*np.radians(recomputed(side)).T)
        ankle = 100.0 * ankle_position(angles, coupling="spatial", **LENGTHS)
        found.append(np.linalg.norm(ankle - targets(side), axis=1).max())
    return float(max(found))


def _coupling_error() -> float:
    off = [recomputed(side, "spatial") - recomputed(side) for side in SIDES]
    return float(np.abs(np.stack(off)[..., ALPHA : BETA + 1]).max())


def _of_tables() -> Iterator[Erratum]:
    omega = calculated("right")[LIFT_LEFT, OMEGA], recomputed("right")[LIFT_LEFT, OMEGA]
    yield Erratum(
        where="Table 3, lift left, ω",
        printed=f"{omega[0]:+.2f}",
        correct=f"{omega[1]:+.2f} by eq. (9)",
        effect=f"{omega[0] - omega[1]:.2f} degrees; the abstract's mean needs the corrected sign, "
        f"yet the robots measured {_stance_omega('right', LIFT_LEFT)}: what they were sent is open",
    )
    beta = calculated("left")[LIFT_RIGHT, BETA], recomputed("left")[LIFT_RIGHT, BETA]
    yield Erratum(
        where="Table 4, lift right, β",
        printed=f"{beta[0]:.2f}",
        correct=f"{beta[1]:.2f}, two digits changed places",
        effect=f"{beta[0] - beta[1]:.2f} degrees",
    )
    yield _misplaced("Table 5, step right, right Z", "right", 0, STEP_RIGHT, 2)
    yield _misplaced("Table 6, step left, left X", "left", 1, STEP_LEFT, 0)
    for robot in ROBOTS:
        yield from _off_the_grid(robot)


def _misplaced(where: str, side: Side, robot: int, pose: int, axis: int) -> Erratum:
    """A decimal point in the wrong place, told by the mean that the abstract states."""
    raw, mended = averages(side, False)[axis], averages(side, True)[axis]
    return Erratum(
        where=where,
        printed=f"{positions(robot + 1, side)[pose, axis]:.1f} cm",
        correct=f"{corrected_positions(side)[robot, pose, axis]:.1f} cm",
        effect=f"mean error {raw:.2f} instead of {mended:.2f} cm, which the abstract states",
    )


def _stance_omega(side: Side, pose: int) -> str:
    found = [measured(robot, side)[pose, OMEGA] for robot in ROBOTS]
    return " and ".join(f"{angle:+.2f}" for angle in found)


def _off_the_grid(robot: int) -> Iterator[Erratum]:
    for side in SIDES:
        table = measured(robot, side)
        for pose, angle in np.ndindex(table.shape):
            nearest = off_grid(float(table[pose, angle]))
            if nearest is not None:
                yield Erratum(
                    where=f"Table {MEASURED[robot, side]}, {POSES[pose].lower()}, {ANGLES[angle]}",
                    printed=f"{table[pose, angle]:.2f}",
                    correct=f"{nearest:.2f}, on the servo's grid of 0.293 degrees",
                    effect=f"{table[pose, angle] - nearest:.2f} degrees",
                )


def _of_text() -> Iterator[Erratum]:
    right, left = (averages(side, True) for side in SIDES)
    yield Erratum(
        where="abstract, mean error of the right leg's Y",
        printed=f"{stated('right')[1]:.2f} cm",
        correct=f"{right[1]:.2f} cm from Tables 5 and 6",
        effect=f"{right[1] - stated('right')[1]:.2f} cm",
    )
    yield Erratum(
        where="abstract, mean error of the left leg's ω",
        printed=f"{stated('left')[7]:.2f} degrees",
        correct=f"{left[7]:.2f} degrees from Tables 4, 8 and 10",
        effect=f"{left[7] - stated('left')[7]:.2f} degrees",
    )
    yield Erratum(
        where="section 3.1",
        printed="Table 4.1; right foot step, and right foot step",
        correct="Table 2; left foot step and right foot step",
        effect="none on a number",
    )
    yield Erratum(
        where="Table 1, width of the soles",
        printed="12 cm²",
        correct="a width or the area of something else; left out",
        effect="none; the sole is assumed",
    )


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
        f"with level soles. ROBOTIS calls an AX-12 stable up to {RATED_SHARE:.0%} of stall, so the "
        "stance knee is overloaded whatever the timing; the authors propose stronger servos."
    )
    header = ["CoM ahead of the ankle [cm]", "knee torque [N m]", "of stall at 12 V"]
    return Table(title="Load of the stance knee", text=text, header=header, rows=table)
