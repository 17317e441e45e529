"""How fast this machine simulates, learned from the trials that it has simulated.

By the processor time that they took: what else the machine did meanwhile says nothing of next time.
Kept for each engine, robot, kind of ground, and open or closed loop in the user's folder for what
can be made again; where nothing can be kept, every run begins with what our machine needed.
"""

from __future__ import annotations

import json
import os
import socket
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from gaitlab.kinematics.caches import cache_folder
from gaitlab.simulation.trial import Trial
from gaitlab.store import Scalar, TrialRecord

Kind: TypeAlias = tuple[
    str, ...
]  # engine, loop, kind of ground, robot: from the coarse to the fine

USUAL = {"bullet": 0.35, "mujoco": 0.05}  # s of one core for a simulated second, see benchmarks
REMEMBERED = 600.0  # s simulated, after which what was learned before weighs less than half
LEAST = 5.0  # s simulated before a kind is believed
LARGEST = 1 << 20  # byte of the file; a longer one is none of ours


@dataclass
class Pace:
    """Time of one core for a simulated second, by kind of trial.

    Attributes:
        path: File in which it is kept; None to keep nothing.
    """

    path: Path | None
    _seen: dict[Kind, list[float]] = field(default_factory=lambda: defaultdict(lambda: [0.0, 0.0]))

    @classmethod
    def here(cls) -> Pace:
        """That of this machine, as far as it is known."""
        folder = cache_folder().path
        pace = cls(folder / f"core-pace-{socket.gethostname()}.json" if folder else None)
        for kind, spent, simulated in _read(pace.path):
            pace._seen[kind] = [spent, simulated]
        return pace

    def of(self, trial: Trial) -> float:
        """Time of a core for a simulated second of such a trial, in [s]."""
        for kind in reversed(list(_coarse_to_fine(trial))):
            spent, simulated = self._seen.get(kind, (0.0, 0.0))
            if simulated >= LEAST:
                return spent / simulated
        return USUAL[trial.engine.name]

    def mean(self, trials: Iterable[tuple[Trial, float]]) -> float:
        """Mean time of a core for trials, each with its simulated time in [s]; in [s]."""
        costs = [seconds * self.of(trial) for trial, seconds in trials]
        return sum(costs) / len(costs) if costs else 0.0

    def learn(self, trial: Trial, record: TrialRecord) -> None:
        """Take account of a trial that has just been simulated here."""
        spent = record.provenance.get("processor_time")
        simulated = _simulated(trial, record.metrics)
        here = record.provenance.get("host") == socket.gethostname()
        if record.state != "DONE" or not here or not isinstance(spent, float) or simulated <= 0.0:
            return
        fading = REMEMBERED / (REMEMBERED + simulated)
        for kind in _coarse_to_fine(trial):
            before = self._seen[kind]
            self._seen[kind] = [fading * before[0] + spent, fading * before[1] + simulated]

    def save(self) -> None:
        """Keep what was learned; silent where it cannot be kept."""
        if self.path is None or not self._seen:
            return
        rows = [[*map(str, kind), *sums] for kind, sums in sorted(self._seen.items())]
        partial = self.path.with_name(f"{self.path.name}.{os.getpid()}")
        with suppress(OSError):
            partial.write_text(json.dumps(rows))
            os.replace(partial, self.path)


def _coarse_to_fine(trial: Trial) -> Iterator[Kind]:
    loop = "closed" if trial.balance is not None else "open"
    kind = (trial.engine.name, loop, trial.surface.type, trial.names.robot)
    return (kind[:depth] for depth in range(1, len(kind) + 1))


def _simulated(trial: Trial, metrics: Mapping[str, Scalar]) -> float:
    time = metrics.get("time_to_fall" if metrics.get("fell") else "walked_time")
    return trial.gait.startup_time + (float(time) if isinstance(time, int | float) else 0.0)


def _read(path: Path | None) -> list[tuple[Kind, float, float]]:
    """What the file says; nothing if it is damaged, for it is only a guess."""
    with suppress(OSError, ValueError, TypeError):
        if path is not None and path.stat().st_size <= LARGEST:
            rows = json.loads(path.read_text())
            return [(tuple(map(str, kind)), float(s), float(t)) for *kind, s, t in rows]
    return []
