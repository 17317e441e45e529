"""How far a search is, and who is told."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import fsum
from typing import Literal, Protocol, TypeAlias

from gaitlab.search import Candidate, History

# Why a search has ended: all candidates are told; no improvement for long; the space holds no
# more; another coordinator walks the last ones; somebody pressed Ctrl-C.
Ending: TypeAlias = Literal["complete", "no improvement", "exhausted", "elsewhere", "stopped"]


@dataclass(frozen=True, kw_only=True)
class Tally:
    """A search at an instant.

    Attributes:
        history: What was told.
        total: Candidates to try.
        walking: Candidates of the batch under way.
        alive: Of those, how many were not given up.
        walked: Trials that this run has simulated.
        simulated: Their simulated time, in [s].
        seconds: Wall time of this run, in [s].
        begun: Candidates that were told before this run.
    """

    history: History
    total: int
    walking: int = 0
    alive: int = 0
    walked: int = 0
    simulated: float = 0.0
    seconds: float = 0.0
    begun: int = 0

    @property
    def told(self) -> int:
        """Candidates that were told."""
        return len(self.history.candidates)

    def count(self, state: str) -> int:
        """Candidates that were told in a state."""
        return sum(candidate.state == state for candidate in self.history.candidates)

    @property
    def rate(self) -> float:
        """Simulated seconds per second of wall time."""
        return self.simulated / self.seconds if self.seconds else 0.0

    @property
    def time_left(self) -> float | None:
        """Wall time until the end at the pace of this run, in [s]; None before any was told."""
        done = self.told - self.begun
        return self.seconds / done * max(0, self.total - self.told) if done else None


@dataclass(frozen=True, kw_only=True)
class Searched:
    """A search when it has ended or was stopped.

    Attributes:
        tally: Where it stands.
        ending: Why it ended.
        used_before: Trials of the candidates told in this run that the store held already.
        elsewhere: Coordinators that are walking the rest.
        place: Where the database is.
    """

    tally: Tally
    ending: Ending
    used_before: int
    elsewhere: tuple[str, ...]
    place: str


class Told(Protocol):
    """Who is told of a search."""

    def start(self, tally: Tally) -> None:
        """It is known where the search stands; nothing has walked."""

    def update(self, tally: Tally) -> None:
        """A trial has ended or candidates were told."""

    def message(self, text: str) -> None:
        """Something the user should know now."""

    def finish(self, tally: Tally) -> None:
        """Nothing walks any more."""


class Nobody:
    """Is told nothing."""

    def start(self, tally: Tally) -> None:
        """Nothing."""

    def update(self, tally: Tally) -> None:
        """Nothing."""

    def message(self, text: str) -> None:
        """Nothing."""

    def finish(self, tally: Tally) -> None:
        """Nothing."""


class Careful:
    """Passes on what it can: a terminal that has gone stops no search."""

    def __init__(self, told: Told) -> None:
        self._told = told

    def start(self, tally: Tally) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.start(tally)

    def update(self, tally: Tally) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.update(tally)

    def message(self, text: str) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.message(text)

    def finish(self, tally: Tally) -> None:
        """Pass it on."""
        with suppress(OSError):
            self._told.finish(tally)


def last_improvement(history: History) -> int:
    """Number of the candidate with which the search last got better; -1 before any.

    Better is a candidate of the front; while nothing is allowed, one that misses the constraints
    by less than all before it.
    """
    if history.front:
        return max(candidate.number for candidate in history.front)
    nearest = nearest_misses(history.candidates, 1)
    return nearest[0].number if nearest else -1


def nearest_misses(candidates: Sequence[Candidate], count: int) -> list[Candidate]:
    """Candidates that break the constraints by the least, the nearest first."""
    missed = [candidate for candidate in candidates if not candidate.feasible]
    return sorted(missed, key=lambda c: (missed_by(c), c.number))[:count]


def missed_by(candidate: Candidate) -> float:
    """Sum of what a candidate misses, in sizes of the bounds."""
    return fsum(max(0.0, violation) for violation in candidate.violations)
