"""Logs written by formula: a robot that glides, rocks, steps and falls as a test tells it to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil
from typing import TypeAlias

import numpy as np

from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import FEET, FSRS, columns
from gaitlab.log.fall import (
    BODY_CONTACT_TIME,
    HEIGHT_RATIO,
    TILT_TIME,
    UPRIGHT_LIMIT,
)

Course: TypeAlias = Callable[[np.ndarray], np.ndarray] | float
"""A column as a function of the time walked, in [s] since the start-up's end, or a constant."""

HEADER = LogHeader(
    joints=("left_knee", "right_knee", "left_hip_roll", "right_hip_roll"),
    dt=0.005,
    mass=2.0,
    standing_height=0.3,
    startup_time=1.0,
    gait_period=0.8,
    step_length=0.04,
    horizon_time=60.0,
    pile_height=0.03,
    sole_length=0.1,
    sole_width=0.06,
    torque_limits=(2.5, 2.5, 2.5, 2.5),
    fsr_positions=(0.03, 0.02, 0.03, -0.02, -0.02, 0.02, -0.02, -0.02) * 2,
    first_step_time=1.0,
)
DUTY = 0.6  # share of the gait period that a foot carries load


def header(**changes: object) -> LogHeader:
    """The usual header with some fields changed."""
    return replace(HEADER, **changes)


def walk(
    head: LogHeader = HEADER,
    *,
    cycles: float = 6.0,
    speed: float | None = None,
    heading: float = 0.0,
    **courses: Course,
) -> TrialLog:
    """A walk at constant speed along a heading in [rad]; `courses` replace columns by name.

    The robot stands still during the start-up. A course of the feet or joints goes by the name of
    its column; the trunk's quaternion follows from roll, pitch and yaw, the fall from all of them.
    """
    rows = round((head.startup_time + cycles * head.gait_period) / head.dt)
    time = head.dt * np.arange(1, rows + 1)
    walked = time - head.startup_time
    pace = np.maximum(walked, 0.0) * (head.commanded_speed if speed is None else speed)
    arrays = {column.name: np.zeros(rows) for column in columns(head.joints)}
    arrays |= _clock(head, time) | _steps(head, walked)
    arrays |= {"trunk_x": pace * np.cos(heading), "trunk_y": pace * np.sin(heading)}
    arrays |= {"trunk_z": np.full(rows, head.standing_height), "yaw": np.full(rows, heading)}
    arrays["feet_gap"] = 0.03 - 0.1 * np.abs(pace / (1.0 + np.abs(pace)))  # nearer the further
    arrays |= {
        name: np.broadcast_to(_values(course, walked), rows) for name, course in courses.items()
    }
    return _finished(head, arrays, posed=any(name.startswith("trunk_q") for name in courses))


def fall(direction: str = "forward", *, at: float = 3.0, **courses: Course) -> TrialLog:
    """A walk that begins to topple some time after the start-up, in [s], at 3 rad/s."""
    axis, sign = {
        "forward": ("pitch", 1.0),
        "backward": ("pitch", -1.0),
        "left": ("roll", -1.0),
        "right": ("roll", 1.0),
    }[direction]
    toppling = {axis: lambda walked: sign * 3.0 * np.maximum(walked - at, 0.0)}
    return walk(**(toppling | courses))


def mirrored(log: TrialLog) -> TrialLog:
    """The same walk seen in a mirror: left and right, and all that turns with them, swapped."""
    arrays = {}
    for column in columns(log.header.joints):
        name = column.name
        sign = -1.0 if _odd(name) else 1.0
        arrays[_other_side(name)] = sign * log[name]
    support = log["support"]
    arrays["support"] = np.choose(support, [0, 2, 1, 3])
    return TrialLog(header=log.header, arrays=arrays)


def sine(amplitude: float, period: float = HEADER.gait_period, offset: float = 0.0) -> Course:
    """A sine over the time walked."""
    return lambda walked: offset + amplitude * np.sin(2.0 * np.pi * walked / period)


def _values(course: Course, walked: np.ndarray) -> np.ndarray:
    return np.asarray(course(walked) if callable(course) else course)


def _clock(head: LogHeader, time: np.ndarray) -> dict[str, np.ndarray]:
    # The last row of a cycle belongs to it, as in a log.
    turns = (time - head.startup_time - 0.5 * head.dt) / head.gait_period
    walking = turns >= 0.0
    return {
        "time": time,
        "gait_phase": np.where(walking, turns % 1.0, np.nan),
        "step_index": np.where(walking, np.floor(2.0 * turns), -1.0),
    }


def _steps(head: LogHeader, walked: np.ndarray) -> dict[str, np.ndarray]:
    """Feet that carry the weight in turns, on level soles, and lift 20 mm over the pile."""
    arrays = {}
    for foot, side in enumerate(FEET):
        phase = (walked / head.gait_period + 0.5 * foot) % 1.0
        loaded = (phase < DUTY) | (walked < 0.0)
        lift = np.sin(np.pi * np.clip((phase - DUTY) / (1.0 - DUTY), 0.0, 1.0))
        name = f"{side}_foot_"
        force = np.where(loaded, 0.5 * head.weight, 0.0)
        arrays[f"{name}contact"] = loaded
        arrays[f"{name}normal_force"] = force
        arrays[f"{name}sink"] = np.where(loaded, 0.01, -0.02 * lift)
        arrays |= {f"{name}fsr_{fsr}": force / 4.0 for fsr in FSRS}
    loads = np.stack([arrays[f"{side}_foot_contact"] for side in FEET])
    return arrays | {"support": loads[0] + 2 * loads[1], "zmp_margin": 0.02 + 0.0 * walked}


def _finished(head: LogHeader, arrays: dict[str, np.ndarray], posed: bool) -> TrialLog:
    if not posed:
        arrays |= {f"trunk_q{a}": q for a, q in zip("xyzw", _quaternion(arrays), strict=True)}
    for side in FEET:
        if not np.any([arrays[f"{side}_foot_q{axis}"] for axis in "xyzw"]):
            arrays[f"{side}_foot_qw"] = np.ones(len(arrays["time"]))
    upright = np.cos(arrays["roll"]) * np.cos(arrays["pitch"])
    arrays["fall_cause"] = fall_causes(
        upright, arrays["body_contact"], arrays["trunk_z"], head.dt, head.standing_height
    )
    fallen = np.flatnonzero(arrays["fall_cause"])
    end = fallen[0] + 1 if len(fallen) else None
    return TrialLog(header=head, arrays={name: array[:end] for name, array in arrays.items()})


def _quaternion(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll) as xyzw. Shape (4, n)."""
    (cr, sr), (cp, sp), (cy, sy) = (
        (np.cos(arrays[name] / 2.0), np.sin(arrays[name] / 2.0))
        for name in ("roll", "pitch", "yaw")
    )
    x, y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    z, w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    return np.stack([x, y, z, w])


def _other_side(name: str) -> str:
    swap = {"left": "right", "right": "left"}
    return "_".join(swap.get(word, word) for word in name.split("_"))


def _odd(name: str) -> bool:
    """Whether a column changes sign in a mirror across the plane y = 0."""
    if name in ("roll", "yaw", "trunk_wx", "trunk_wz"):
        return True
    if name.endswith(("_qx", "_qz", "_y", "_vy")):
        return True
    return "_roll_" in name


def _held(condition: np.ndarray, ticks: int) -> np.ndarray:
    """Whether a condition has held for so many ticks, this one included. Shape (n,)."""
    index = np.arange(len(condition))
    last_break = np.maximum.accumulate(np.where(condition, -1, index))
    return index - last_break >= ticks


def fall_causes(
    upright: np.ndarray,
    body_contact: np.ndarray,
    trunk_height: np.ndarray,
    dt: float,
    standing_height: float,
) -> np.ndarray:
    """What `ended` says of a fall at each tick, for all ticks at once.

    Args:
        upright: Cosine of the trunk's tilt. Shape (n,).
        body_contact: Whether a link other than a foot touches the ground. Shape (n,).
        trunk_height: Height of the trunk link frame, in [m]. Shape (n,).
        dt: Time step, in [s].
        standing_height: Height of the trunk link frame when standing still, in [m].

    Returns:
        Cause code, 0 before the fall. Shape (n,), int8.
    """
    tilted = _held(np.less(upright, UPRIGHT_LIMIT), ceil(TILT_TIME / dt - 1e-6))
    touching = _held(np.asarray(body_contact, dtype=bool), ceil(BODY_CONTACT_TIME / dt - 1e-6))
    low = np.less(trunk_height, HEIGHT_RATIO * standing_height)
    causes = np.select([tilted, touching, low], [1, 2, 3], 0)
    fallen = np.flatnonzero(causes)
    if len(fallen):
        causes[fallen[0] :] = causes[fallen[0]]
    return causes.astype(np.int8)
