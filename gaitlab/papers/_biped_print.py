"""What [Siswoyo2008] prints, evaluated: its boundary angles, and each mistake with its size.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import degrees

import numpy as np

from gaitlab.gaits.biped import Gait
from gaitlab.kinematics.belt_leg import ankle_position, stride_angles
from gaitlab.kinematics.blend import blended_segment
from gaitlab.papers.page import Comparison, Erratum, Row
from gaitlab.papers.printed import rows

WALK = Gait(full_strides=1, stand_time=0.0)  # the figures' walk; lengths and times are assumptions
PRINTED = replace(WALK, ending="printed", lift="printed")
_THETA = "asin(S/(2l))"
_LIFT = "acos((sqrt((2l)^2-(S/2)^2)-h)/(2l))"
_EXACT = "acos(cos(th/2)-h/(2l))"


def printed_angles(gait: Gait) -> dict[str, float]:
    """Every expression that the paper prints or needs, in [rad]."""
    lengths = gait.step_length, gait.step_height, gait.segment
    exact, printed = stride_angles(*lengths), stride_angles(*lengths, lift="printed")
    theta, thigh, shank = exact.touchdown, exact.ending_thigh, exact.ending_shank
    return {
        **{"0": 0.0, "0 and 0": 0.0, _THETA: theta, f"-{_THETA}": -theta},
        **{_LIFT: printed.lift, _EXACT: exact.lift, "phi_1,1=+psi, phi_1,2=-psi": exact.lift},
        **{"-(asin((S/2)/P)-acos(P/2l))": thigh, "-(A-B)": thigh},
        **{"-(asin((S/2)/P)+acos(P/2l))": shank, "-(A+B)": shank},
    }


def boundary_angles() -> Comparison:
    """The printed boundary conditions at the assumed lengths."""
    angles = printed_angles(WALK)
    table = []
    for row in rows("biped_boundary_conditions"):
        printed, ours = (angles.get(row[key]) for key in ("printed_value", "corrected_value"))
        table.append(
            Row(
                label=f"{row['stride']}, {row['leg']}, {row['joint']} at {row['printed_time']}",
                printed=None if printed is None else degrees(printed),
                ours=None if ours is None else degrees(ours),
                note="" if row["note"].startswith("ok") else row["note"],
            )
        )
    title = (
        f"Boundary angles of the strides (section III.A) for S = {WALK.step_length} m, "
        f"l = {WALK.segment} m, h = {WALK.step_height} m"
    )
    return Comparison(title=title, unit="deg", digits=3, rows=table)


def lowest_point(gait: Gait) -> float:
    """Lowest that the trailing foot gets in an ending stride, in [m]; 0 is the floor."""
    start = gait.duration - gait.half_stride
    t = start + np.linspace(0.0, gait.half_stride, 4001)
    ankle = ankle_position(gait.joint_motion(t).position, gait.segment)
    height = ankle[..., 1] - ankle[:, _supporting(gait), None, 1]
    return float(height.min())


def _supporting(gait: Gait) -> int:
    """Leg that supports the ending stride: the one that landed last."""
    return (gait.full_strides + 1) % 2


def errata() -> list[Erratum]:
    """Every mistake that was found, in the order of the paper."""
    return [*_strides(), *_time_law()]


def _strides() -> Iterator[Erratum]:
    length, angles = WALK.segment, WALK.angles
    low = 2.0 * length * (np.cos(angles.touchdown / 2.0) - np.cos(PRINTED.angles.lift))
    yield Erratum(
        where="III.A, lift angle of the starting and the full stride",
        printed="hips sqrt((2l)^2 - (S/2)^2) over the ankle",
        correct="2l cos(theta/2), as P already has it",
        effect=f"the foot is lifted by {1e3 * low:.2f} mm instead of {1e3 * WALK.step_height:.2f}",
    )
    early = 2.0 * length * (1.0 - np.cos(angles.lift))
    yield Erratum(
        where="III.A.2, swing leg, first interval",
        printed="lifted at t_f",
        correct="lifted at 3 t_f/2, as the text and the next interval say",
        effect=f"at t_f the hips stand over the foot, the lift is {1e3 * early:.1f} mm",
    )
    ahead = float(ankle_position(np.full(2, PRINTED.angles.lift), length)[0])
    yield Erratum(
        where="III.A.2, swing leg at 3 t_f/2",
        printed="phi_11 = phi_12 = psi",
        correct="phi_11 = -phi_12 = psi",
        effect=f"a straight leg with the foot {ahead:.3f} m ahead of the hips",
    )
    difference = degrees(abs(angles.ending_thigh + angles.ending_shank))
    yield Erratum(
        where="III.A.3, swing leg, second interval",
        printed="phi_21 = -phi_22",
        correct="no such relation; the two start at -(A - B) and -(A + B)",
        effect=f"off by {difference:.2f} degrees at t_f/2",
    )
    floating = 2.0 * length * (1.0 - np.cos(angles.touchdown))
    yield Erratum(
        where="III.A.3, swing leg at t_f",
        printed="phi_21 = -phi_22 = asin(S/2l)",
        correct="both 0",
        effect=f"the walk ends with a foot {1e3 * floating:.1f} mm in the air",
    )
    yield Erratum(
        where="III.A.3, ending stride as a whole",
        printed="one time law for all joints, lift at t_f/2",
        correct="support cruises at 1.2, swing at 2.0 times its mean speed, or lift at 0.8 t_f",
        effect=f"the trailing foot digs {-1e3 * lowest_point(PRINTED):.2f} mm into the floor; "
        f"corrected {abs(1e3 * lowest_point(WALK)):.2f} mm",
    )


def _time_law() -> Iterator[Erratum]:
    change, duration = WALK.angles.lift, 0.5 * WALK.half_stride
    speed = WALK.speed_ratio * change / duration
    blend = duration - change / speed
    reached = 3.0 * speed + 2.0 * speed
    jump = 6.0 * speed / blend + 6.0 * speed / blend
    yield Erratum(
        where="III.B, position in the first blend",
        printed="+1/2 (w/t_b^3) t^4",
        correct="-1/2 (w/t_b^3) t^4",
        effect=f"in the first lift the joint reaches {reached:.2f} rad/s where {speed:.2f} are "
        f"wanted, and its acceleration jumps by {jump:.1f} rad/s^2",
    )
    yield Erratum(
        where="III.B, position in the linear part",
        printed="phi_A + w t",
        correct="phi_A + w (t - t_b)",
        effect=f"in the first lift a jump of {degrees(speed * blend):.2f} degrees at t_b",
    )
    half = blended_segment(np.array([duration]), 0.0, 1.0, 2.0 * duration, 0.5 / duration * 1.3)
    yield Erratum(
        where="III.B, duration in all formulas",
        printed="t_f",
        correct="that of the segment: t_f/2, t_f or 3 t_f/2",
        effect=f"a segment of t_f/2 covers {100.0 * float(half.position[0]):.0f} % of its angle",
    )
    yield Erratum(
        where="III.B, derivation of t_b",
        printed="+ w t_b in the last line but one",
        correct="- w t_b",
        effect="none: the printed t_b is right",
    )
    yield Erratum(
        where="Fig. 5, caption",
        printed="parabolic blends",
        correct="quartic blends, as the text derives",
        effect="none",
    )
