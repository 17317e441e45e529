"""The Bioloid's lengths: two links of the leg are published, the rest is assumed.

References:
    Setiyono: Setiyono, Rifal and Munadi, Implementation of Invers Kinematics for Movement Legs
        Design on Humanoid Robot, Diponegoro University, Semarang.
"""

from __future__ import annotations

from dataclasses import dataclass

from gaitlab.kinematics.leg import LegGeometry
from gaitlab.parameters import parameter

TALL = "assumption: the parts add up to the published 40 cm"
_SPACE = "assumption: room of two AX-12 beside each other"
_SPAN = "assumption: the arms add up to the published span of 55 cm"


def metres(default: float, high: float, doc: str, source: str) -> float:
    """A length in [m] of at least 5 mm, as a field of a dataclass."""
    value: float = parameter(default, unit="m", low=0.005, high=high, doc=doc, source=source)
    return value


@dataclass(frozen=True, kw_only=True)
class BioloidLeg(LegGeometry):
    """Lengths of a leg."""

    hip_spacing: float = metres(0.0385, 0.3, "trunk centre plane to the hip", _SPACE)
    hip_drop: float = metres(0.030, 0.3, "trunk link frame down to the hip", _SPACE)
    thigh: float = metres(0.075, 0.5, "L1, hip to knee", "published: 7.5 cm")
    shank: float = metres(0.075, 0.5, "L2, knee to ankle", "published: 7.5 cm")


@dataclass(frozen=True, kw_only=True)
class UpperBody:
    """Lengths above the hips."""

    waist_height: float = metres(0.020, 0.2, "trunk link frame to the waist axes", TALL)
    shoulder_height: float = metres(0.080, 0.5, "waist to the shoulder axis", TALL)
    shoulder_spacing: float = metres(0.070, 0.3, "centre plane to the arm", _SPAN)
    upper_arm: float = metres(0.090, 0.5, "shoulder to the elbow", _SPAN)
    forearm: float = metres(0.115, 0.5, "elbow to the fingertips", _SPAN)
    neck: float = metres(0.035, 0.2, "shoulder axis to the head's tilt axis", TALL)
    head: float = metres(0.055, 0.3, "tilt axis to the crown", TALL)
