"""Trials for tests of everything that keeps them: records and logs that nobody simulated."""

from __future__ import annotations

import hashlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import columns
from gaitlab.store import TrialRecord

JOINTS = ("left_knee", "right_knee")


def trial_id(number: int) -> str:
    return hashlib.sha256(str(number).encode()).hexdigest()[:32]


def header(joints: tuple[str, ...] = JOINTS) -> LogHeader:
    """A header with a different number in every field, whatever fields there are."""
    special = {"joints": joints}
    values = {}
    for number, (name, hint) in enumerate(LogHeader.__annotations__.items(), start=1):
        default = tuple(number + 0.1 * k for k in range(len(joints)))
        plain = default if "tuple" in hint else number + 1 / 3
        values[name] = special.get(name, plain if hint != "int" else number)
    return LogHeader(**values)


def log(ticks: int = 40, seed: int = 0, joints: tuple[str, ...] = JOINTS) -> TrialLog:
    """Smooth columns with noise in every bit, NaN and both infinities among them."""
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 0.002 * ticks, ticks)
    arrays: dict[str, np.ndarray] = {}
    for column in columns(joints):
        wave = np.sin(9.0 * time + random.uniform(0.0, 6.0)) + 1e-4 * random.normal(size=ticks)
        arrays[column.name] = (wave > 0.0 if column.dtype == "bool" else wave).astype(column.dtype)
    if ticks > 3:
        arrays["zmp_x"][:3] = np.nan, np.inf, -np.inf
    return TrialLog(header=header(joints), arrays=arrays)


def record(number: int, state: str = "DONE", **metrics: object) -> TrialRecord:
    done = {"stable": number % 2 == 0, "fell": number % 2 == 1, "distance": 0.1}
    names = {"robot": "eros", "gait": "eros", "surface": "grass_50mm"}
    return TrialRecord(
        trial_id=trial_id(number),
        state=state,  # type: ignore[arg-type]
        reason="" if state == "DONE" else f"{state}: left_leg at tick 7",
        trial={"names": names, "seed": number, "gait": {"step_height": 0.03}},
        metrics=metrics or (done if state == "DONE" else {}),
        provenance={"gaitlab_version": "0.1.0", "host": "lab", "wall_time": 1.5},
    )


def planned(numbers: range, **values: object) -> list[SimpleNamespace]:
    """Planned trials as far as a list of trials looks at them."""
    return [
        SimpleNamespace(
            trial=SimpleNamespace(id=trial_id(number), seed=number),
            values={"surface": "grass_50mm", "gait.step_height": 0.01 * number, **values},
            cell_index=number,
        )
        for number in numbers
    ]


def experiment(name: str = "sweep") -> SimpleNamespace:
    path = Path(f"{name}.yaml")
    return SimpleNamespace(
        name=name, listed_as=name, path=path, text=f"name: {name}\n", digest="d" * 64
    )
