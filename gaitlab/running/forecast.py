"""How much longer a run takes: what is left by its planned length, at the pace seen so far."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

Kind: TypeAlias = tuple[str, ...]  # from the coarse to the fine: robot, ground, cell

PRIOR_TRIALS = 1.0  # of the mean length; as if a kind had seen so much of the coarser kind's pace
WARM_UP = 0.1  # weight of the first trial of each worker, which loads the engine
FADING = 0.98  # what a trial still weighs when the next of its kind has ended: machines change pace

NOTHING = 1e-6  # s; what rounding leaves of sums that should be zero


@dataclass(frozen=True, kw_only=True)
class _Running:
    kind: Kind
    planned: float
    start: float


@dataclass
class _Seen:
    """Sums over the trials of a kind that have ended, the older ones faded."""

    planned: float = 0.0
    spent: float = 0.0
    weight: float = 0.0

    def add(self, planned: float, spent: float, weight: float) -> None:
        self.planned = FADING * self.planned + weight * planned
        self.spent = FADING * self.spent + weight * spent
        self.weight = FADING * self.weight + weight


@dataclass
class Forecast:
    """Wall time left, learned from the trials that have ended.

    A trial is planned to last its whole horizon, and a fall ends it early; so what counts is the
    wall time that a planned second has cost so far, apart for each kind of trial: on tall grass a
    robot may be down in a second, on the carpet it walks to the end. A kind of which little is
    known yet is taken to be much like the coarser kind that it belongs to.

    Attributes:
        workers: Trials that run side by side.
    """

    workers: int
    _waiting: dict[Kind, float] = field(default_factory=lambda: defaultdict(float))  # s planned
    _seen: dict[Kind, _Seen] = field(default_factory=lambda: defaultdict(_Seen))
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
        spent = since if spent is None else min(spent, since)
        weight = WARM_UP if self._ended < self.workers else 1.0
        for kind in _coarse_to_fine(trial.kind):
            self._seen[kind].add(trial.planned, spent, weight)
        self._ended += 1

    def time_left(self, now: float) -> float | None:
        """Wall time until the last trial ends, in [s]; None while little is known."""
        if self._ended <= self.workers and sum(self._waiting.values()) > NOTHING:
            return None
        waiting = sum(self._pace(kind) * planned for kind, planned in self._waiting.items())
        running = [self._rest(trial, now) for trial in self._running.values()]
        shared = (max(0.0, waiting) + sum(running)) / max(1, self.workers)
        return max(shared, *running, 0.0)

    def _pace(self, kind: Kind) -> float:
        """Wall time of a planned second; the less is known, the nearer to the coarser kind's."""
        pace, everything = 0.0, self._seen[()]
        length = everything.planned / everything.weight if everything.weight else 1.0
        for known in _coarse_to_fine(kind):
            if known and known not in self._seen:
                return pace
            seen, prior = self._seen[known], PRIOR_TRIALS * length if known else 0.0
            total = seen.planned + prior
            pace = (seen.spent + prior * pace) / total if total else 0.0
        return pace

    def _rest(self, trial: _Running, now: float) -> float:
        return max(0.0, self._pace(trial.kind) * trial.planned - (now - trial.start))


def _coarse_to_fine(kind: Kind) -> Iterator[Kind]:
    """All trials, then each part of the kind more."""
    return (kind[:depth] for depth in range(len(kind) + 1))
