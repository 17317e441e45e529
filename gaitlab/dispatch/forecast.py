"""How much longer a run takes: what is left by its planned length, at the pace seen so far."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TypeAlias

Kind: TypeAlias = tuple[str, ...]  # trials of one kind fall alike: the same robot on one ground

PRIOR_TRIALS = 2.0  # of the mean length; what a kind counts as having seen of the common pace


@dataclass(frozen=True, kw_only=True)
class _Running:
    kind: Kind
    planned: float
    start: float


def _zeros() -> dict[Kind, float]:
    return defaultdict(float)


@dataclass
class Forecast:
    """Wall time left, learned from the trials that have ended.

    A trial is planned to last its whole horizon, and a fall ends it early; so what counts is the
    wall time that a planned second has cost so far, apart for each kind of trial: on tall grass a
    robot may be down in a second, on the carpet it walks to the end. A kind of which little is
    known yet is taken to be much like the others.

    Attributes:
        workers: Trials that run side by side.
    """

    workers: int
    _waiting: dict[Kind, float] = field(default_factory=_zeros)  # s planned, not started
    _planned: dict[Kind, float] = field(default_factory=_zeros)  # s planned of those that ended
    _spent: dict[Kind, float] = field(default_factory=_zeros)  # s of wall time of those that ended
    _running: dict[str, _Running] = field(default_factory=dict)
    _ended: int = 0

    def expect(self, kind: Kind, planned: float) -> None:
        """A trial of this kind is to run, for so long if nothing stops it, in [s]."""
        self._waiting[kind] += planned

    def start(self, trial_id: str, kind: Kind, planned: float, now: float) -> None:
        """A trial that was expected has started at an instant `now`, in [s]."""
        self._waiting[kind] -= planned
        self._running[trial_id] = _Running(kind=kind, planned=planned, start=now)

    def end(self, trial_id: str, now: float, spent: float | None = None) -> None:
        """It has ended; `spent` is its own time in [s] if known, without the worker's start."""
        trial = self._running.pop(trial_id)
        since = now - trial.start
        self._planned[trial.kind] += trial.planned
        self._spent[trial.kind] += since if spent is None else min(spent, since)
        self._ended += 1

    def time_left(self, now: float) -> float | None:
        """Wall time until the last trial ends, in [s]; None before the first has ended."""
        if not self._ended:
            return None
        waiting = sum(self._pace(kind) * planned for kind, planned in self._waiting.items())
        running = [self._rest(trial, now) for trial in self._running.values()]
        shared = (max(0.0, waiting) + sum(running)) / max(1, self.workers)
        return max(shared, *running, 0.0)

    def _pace(self, kind: Kind) -> float:
        """Wall time of a planned second, drawn to that of all kinds while little is known."""
        planned, spent = sum(self._planned.values()), sum(self._spent.values())
        prior = PRIOR_TRIALS * planned / self._ended
        if not planned + prior:
            return 0.0
        common = spent / planned if planned else 0.0
        return (self._spent[kind] + prior * common) / (self._planned[kind] + prior)

    def _rest(self, trial: _Running, now: float) -> float:
        return max(0.0, self._pace(trial.kind) * trial.planned - (now - trial.start))
