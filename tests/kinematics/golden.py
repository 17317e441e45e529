"""Reference vectors of the EROS equations, made independently of this package."""

import json
from pathlib import Path
from typing import Any

from gaitlab.kinematics.arm import ArmLengths
from gaitlab.kinematics.head import HeadLengths
from gaitlab.kinematics.six_joint_leg import Leg, LegLengths

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "eros.json").read_text())
SIDES = {1: "left", -1: "right"}


def cases(group: str) -> list[Any]:
    return [case for case in GOLDEN[group] if isinstance(case, dict)]


def head(case: dict[str, Any]) -> HeadLengths:
    lengths = GOLDEN["geometry"][case["geometry"]]["head"]
    return HeadLengths(neck=lengths["d1"], camera=lengths["d2"])


def arm(case: dict[str, Any]) -> ArmLengths:
    lengths = GOLDEN["geometry"][case["geometry"]]["arm"]
    return ArmLengths(
        shoulder_spacing=lengths["dy"],
        shoulder_drop=lengths["dz1"],
        upper_arm=lengths["dz2"],
        forearm=lengths["dz3"],
    )


def leg(case: dict[str, Any]) -> Leg:
    lengths = GOLDEN["geometry"][case["geometry"]]["leg"]
    geometry = LegLengths(
        hip_spacing=lengths["dy"],
        hip_drop=lengths["dz1"],
        thigh=lengths["l1"],
        shank=lengths["l2"],
    )
    return Leg(
        geometry=geometry,
        ankle_height=lengths["dz6"],
        side=SIDES[case["sy"]],
        yaw_axis={"A": "trunk", "B": "hip"}[case["model"]],
    )
