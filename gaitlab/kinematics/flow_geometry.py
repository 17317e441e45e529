"""FLoW's lengths, all of them assumed: the paper prints symbols and the height alone.

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from dataclasses import dataclass

from gaitlab.kinematics.leg import LegGeometry
from gaitlab.parameters import parameter

_TALL = "assumption: the parts add up to the published 110 cm; equal leg links follow 2 d4 in print"


def metres(default: float, doc: str, low: float = 0.01) -> float:
    """A length in [m] of at least `low`, as a field of a dataclass."""
    value: float = parameter(default, unit="m", low=low, high=2.0, doc=doc, source=_TALL)
    return value


@dataclass(frozen=True, kw_only=True)
class FlowLeg(LegGeometry):
    """Lengths of the leg."""

    hip_spacing: float = metres(0.085, "dy, pelvis centre plane to the hip", low=0.0)
    hip_drop: float = metres(0.060, "dz1, pelvis origin down to the hip", low=0.0)
    thigh: float = metres(0.230, "l1, hip to knee")
    shank: float = metres(0.230, "l2, knee to ankle")


@dataclass(frozen=True, kw_only=True)
class FlowArm:
    """Lengths of the arm."""

    spacing: float = metres(0.160, "body centre plane to the shoulder", low=0.0)
    rise: float = metres(0.0, "d1, arm base up to the shoulder's centre", low=0.0)
    upper_arm: float = metres(0.190, "d3, shoulder to elbow")
    forearm: float = metres(0.210, "d5, elbow to the tip; with a wrist, the hand is part of it")
    hand: float = metres(0.060, "d7, wrist to the tip, for an arm of 6 or 7 joints")


@dataclass(frozen=True, kw_only=True)
class FlowTorso:
    """Lengths above the pelvis origin."""

    waist_height: float = metres(0.060, "pelvis origin to the waist")
    shoulder_height: float = metres(0.250, "waist to the shoulder line")
    neck_height: float = metres(0.040, "shoulder line to the neck base", low=0.0)
    neck: float = metres(0.050, "d, neck base to the tilt axis", low=0.0)
    eyes: float = metres(0.070, "a, tilt axis to the eyes")
    crown: float = metres(0.050, "eyes to the top of the head", low=0.0)
