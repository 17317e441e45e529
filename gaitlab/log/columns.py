"""The columns of a trial's log: their names, units and frames.

One row a tick; row k is the state at the end of tick k, at time (k + 1) dt. World frame unless a
column says otherwise: x forward, y left, z up, z = 0 at the base that the pile stands on. The
world leans with a slope: z is at a right angle to the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

FEET = ("left", "right")
FSRS = ("front_left", "front_right", "rear_left", "rear_right")


class Column(NamedTuple):
    """One column of the log.

    Attributes:
        name: Name in the Parquet file and in SQL.
        unit: SI unit, `-` for counts, flags and ratios.
        doc: What it holds and in which frame.
        dtype: `float32`, `int8`, `int16` or `bool`.
        late: Whether logs that were written before there was this column lack it: NaN in those.
    """

    name: str
    unit: str
    doc: str
    dtype: str = "float32"
    late: bool = False


_BODY = (
    Column("time", "s", "time since the start of the trial"),
    Column("gait_phase", "-", "phase of the gait cycle in [0, 1), NaN during start-up"),
    Column("step_index", "-", "footsteps begun since start-up ended, -1 before", "int16"),
    Column("support", "-", "feet on the ground: 0 none, 1 left, 2 right, 3 both", "int8"),
    Column("fall_cause", "-", "0 upright, 1 tilt, 2 body contact, 3 low trunk", "int8"),
    Column("body_contact", "-", "a link other than a foot touches the base", "bool"),
    Column(
        "feet_gap", "m", "smallest gap of the lower legs, negative where they overlap", late=True
    ),
    *(Column(f"trunk_{a}", "m", "origin of the trunk link frame") for a in "xyz"),
    *(Column(f"trunk_q{a}", "-", "quaternion of the trunk link frame") for a in "xyzw"),
    Column("roll", "rad", "trunk roll, positive leans right"),
    Column("pitch", "rad", "trunk pitch, positive leans forward"),
    Column("yaw", "rad", "trunk yaw, positive turns left"),
    *(Column(f"trunk_v{a}", "m/s", "velocity of the trunk's centre of mass") for a in "xyz"),
    *(Column(f"trunk_w{a}", "rad/s", "angular velocity of the trunk") for a in "xyz"),
    *(Column(f"com_{a}", "m", "centre of mass of the whole robot") for a in "xyz"),
    *(
        Column(f"zmp_{a}", "m", "zero-moment point on the soles' plane; NaN in flight")
        for a in "xy"
    ),
    Column(
        "zmp_margin", "m", "signed distance of the ZMP to the support polygon's edge; NaN in flight"
    ),
)


def _foot_columns(side: str) -> tuple[Column, ...]:
    foot = f"{side}_foot"
    return (
        *(Column(f"{foot}_{a}", "m", "centre of the sole") for a in "xyz"),
        *(Column(f"{foot}_q{a}", "-", "quaternion of the foot link frame") for a in "xyzw"),
        Column(f"{foot}_normal_force", "N", "vertical contact force on the sole, up"),
        *(
            Column(f"{foot}_force_{a}", "N", "horizontal force on the sole, plough included")
            for a in "xy"
        ),
        Column(f"{foot}_sink", "m", "depth of the lowest sole corner below the top of the pile"),
        Column(f"{foot}_plough_force", "N", "horizontal force of the pile on the leading edges"),
        Column(f"{foot}_contact", "-", "the sole carries load", "bool"),
        *(
            Column(f"{foot}_fsr_{p}", "N", f"vertical load on the {p} quarter of the sole")
            for p in FSRS
        ),
    )


def _joint_columns(joint: str) -> tuple[Column, ...]:
    return (
        Column(f"{joint}_target", "rad", "target sent to the servo, or where a coupling wants it"),
        Column(f"{joint}_position", "rad", "joint position"),
        Column(f"{joint}_velocity", "rad/s", "joint velocity"),
        Column(f"{joint}_torque", "N m", "torque of the servo on the joint"),
    )


def columns(joints: Sequence[str]) -> tuple[Column, ...]:
    """The columns of a log of a robot with these joints, in file order."""
    return _columns(tuple(joints))


@lru_cache(maxsize=16)
def _columns(joints: tuple[str, ...]) -> tuple[Column, ...]:
    feet = [column for side in FEET for column in _foot_columns(side)]
    return (*_BODY, *feet, *(column for joint in joints for column in _joint_columns(joint)))
