"""Nights that nobody simulated: walks whose outcome is drawn, in memory or committed to a store."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitlab.regression.baseline import KEPT, Baseline, Walk
from gaitlab.running.provenance import code_digest
from gaitlab.simulation.trial import PHYSICS_VERSION
from gaitlab.store import Store, TrialRecord
from tests import recorded

FILE = Path(__file__).parent / "edge.yaml"
SURFACES = ("grass_30mm", "carpet_4mm")
STEPS = (0.02, 0.06)


def measures(rng: np.random.Generator, share: float, pitch: float) -> dict[str, Any]:
    """Metrics of a walk that stays up with this chance and rocks by this much, in [rad]."""
    up = bool(rng.random() < share)
    numbers = {name: 1.0 + 0.1 * rng.normal() for name in KEPT[2:]}
    numbers |= {"pitch_amplitude": pitch + 0.01 * rng.normal(), "distance": 0.4 * (1 + up)}
    return {"stable": up, "stable_strict": up, "fell": not up, **numbers}


def night(
    draw: int, *, share: float = 0.75, pitch: float = 0.1, seeds: range = range(12)
) -> Baseline:
    """A whole night of four cells; the same draw gives the same walks."""
    rng = np.random.default_rng(draw)
    walks = [
        Walk(
            cell={"gait.step_length": step, "surface": surface},
            seed=seed,
            trial_id=recorded.trial_id(zlib.crc32(f"{step} {surface} {seed}".encode())),
            state="DONE",
            metrics={k: v for k, v in measures(rng, share, pitch).items() if k in KEPT},
            log_digest=f"{draw} {step} {surface} {seed}",
        )
        for step in STEPS
        for surface in SURFACES
        for seed in seeds
    ]
    return Baseline(
        experiment="edge",
        digest="d" * 64,
        physics_version=PHYSICS_VERSION,
        basis={"gait": "0" * 16},
        provenance={"code": (code_digest(),)},
        walks=tuple(walks),
    )


def walker(draw: int, *, share: float = 0.75, fail: int = 0) -> Callable[..., TrialRecord]:
    """A stand-in for the simulation that commits drawn walks; the first `fail` of them fail."""
    left = [fail]

    def walk(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
        number = int(trial_id[:8], 16) + draw
        state = "FAILED" if left[0] > 0 else "DONE"
        left[0] -= 1
        metrics = measures(np.random.default_rng(number), share, 0.1) if state == "DONE" else {}
        record = replace(
            recorded.record(number, state),
            trial_id=trial_id,
            trial=trial,
            metrics=metrics,
            provenance={"code": code_digest(), "platform": "made up"},
        )
        Store(store).commit(record, recorded.log(seed=number) if state == "DONE" else None)
        return record

    return walk
