"""Counting trials: what a cell, a surface and a variant score, each with its n.

A trial is stable when the robot did not fall; strictly stable when it also covered half of the
commanded distance. A cell is stable when at least half of its seeds are. The stability percentage
of a surface is the share of its cells that are stable, and efficiency its mean over the surfaces,
[EROS2018]. A cell in which most seeds fall before the first step says nothing of the gait: it does
not stand, and is counted as not stable.

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import compress
from typing import Literal

import numpy as np
import pandas as pd

from gaitlab.statistics import (
    STABLE_SHARE,
    Interval,
    efficiency,
    stability_percent,
    stable_cell,
    wilson,
)

Score = Literal["stable", "stable_strict"]
SCORED = ("DONE", "INFEASIBLE")  # states of a trial that count in a cell
DRAWS = 4000  # of the efficiency; the interval's ends settle to about one percent
LEVEL = 0.95


@dataclass(frozen=True, kw_only=True)
class ScoredCell:
    """Trials that differ only by seed.

    Attributes:
        stable: For each scored seed whether the robot stayed up.
        strict: The same, strictly.
        infeasible: Seeds whose steps are out of reach; scored as not stable.
        failed: Seeds whose simulation failed; not scored.
        missing: Seeds not simulated yet; not scored.
        standing: Seeds that fell before their first step; scored as not stable.
    """

    stable: tuple[bool, ...]
    strict: tuple[bool, ...]
    infeasible: int
    failed: int
    missing: int
    standing: int = 0

    @property
    def n(self) -> int:
        """Scored seeds."""
        return len(self.stable)

    @property
    def planned(self) -> int:
        """All seeds."""
        return self.n + self.failed + self.missing

    @property
    def feasible(self) -> bool:
        """False when no seed could take the steps."""
        return self.infeasible < self.n or self.n == 0

    @property
    def stands(self) -> bool:
        """False when more than half of the scored seeds fell before their first step."""
        return 2 * self.standing <= self.n

    def outcomes(self, score: Score) -> tuple[bool, ...]:
        """Outcome of each scored seed."""
        return self.stable if score == "stable" else self.strict

    def count(self, score: Score = "stable") -> int:
        """Seeds that stayed up."""
        return sum(self.outcomes(score))

    def share(self, score: Score = "stable") -> float:
        """Share of scored seeds that stayed up, NaN without any."""
        return self.count(score) / self.n if self.n else float("nan")

    def verdict(self, score: Score = "stable") -> bool | None:
        """Whether the cell is stable; None when nothing is scored or the robot does not stand."""
        return stable_cell(self.share(score)) if self.n and self.stands else None

    def interval(self, score: Score = "stable") -> Interval:
        """Wilson interval of the share."""
        return wilson(self.count(score), self.n)

    def doubtful(self, score: Score = "stable") -> bool:
        """Whether the interval of the share that the verdict rests on holds one half.

        Of a cell that does not stand that is the share of falls before the first step.
        """
        if not self.n or not self.feasible:
            return False
        bounds = self.interval(score) if self.stands else wilson(self.standing, self.n)
        return bounds.low < STABLE_SHARE < bounds.high


EMPTY = ScoredCell(stable=(), strict=(), infeasible=0, failed=0, missing=0)


def cell_of(trials: pd.DataFrame) -> ScoredCell:
    """The cell that these trials make up."""
    states = trials["state"].tolist()
    scored = [state in SCORED for state in states]
    return ScoredCell(
        stable=tuple(compress(truth(trials["stable"]).tolist(), scored)),
        strict=tuple(compress(truth(trials["stable_strict"]).tolist(), scored)),
        infeasible=states.count("INFEASIBLE"),
        failed=states.count("FAILED"),
        missing=states.count("MISSING"),
        standing=fell_standing(trials),
    )


def fell_standing(trials: pd.DataFrame) -> int:
    """Trials that fell before their first step; none in a store from before that was measured."""
    return int(truth(trials["fell_standing"]).sum()) if "fell_standing" in trials else 0


def truth(values: pd.Series) -> np.ndarray:
    """Where a column of flags with gaps says yes; a trial that was not simulated says nothing."""
    return np.array([isinstance(v, (bool, np.bool_)) and bool(v) for v in values], dtype=bool)


def surface_percent(cells: Iterable[ScoredCell], score: Score = "stable") -> float:
    """Share of cells that are stable, in percent; cells without a scored seed left out."""
    known = [bool(cell.verdict(score)) for cell in cells if cell.n]
    return stability_percent(known) if known else float("nan")


def mean_percent(by_surface: Sequence[Sequence[ScoredCell]], score: Score = "stable") -> float:
    """Efficiency: mean of the surfaces' percentages; surfaces without a score left out."""
    percents = [surface_percent(cells, score) for cells in by_surface]
    known = [percent for percent in percents if not np.isnan(percent)]
    return efficiency(known) if known else float("nan")


def efficiency_draws(
    by_surface: Sequence[Sequence[ScoredCell]], score: Score = "stable", stream: int = 0
) -> np.ndarray:
    """Plausible efficiencies given the seeds that were seen, in percent. Shape (draws,).

    The cells are fixed by the design and only their seeds are random. Each cell's true share is
    drawn from its Jeffreys posterior Beta(k + 1/2, n - k + 1/2) and the cell counted again; drawing
    the seeds themselves again would call 3 of 3 certain. Infeasible cells are certain.
    Different streams are independent, the same stream always draws alike.
    """
    generator = np.random.default_rng([20180622, stream])
    percents = [_surface_draws(cells, score, generator) for cells in by_surface]
    known = [draws for draws in percents if draws is not None]
    return 100.0 * np.mean(known, axis=0) if known else np.full(DRAWS, np.nan)


def _surface_draws(
    cells: Sequence[ScoredCell], score: Score, generator: np.random.Generator
) -> np.ndarray | None:
    known = [cell for cell in cells if cell.n]
    if not known:
        return None
    k = np.array([cell.count(score) for cell in known])
    n = np.array([cell.n for cell in known])
    shares = generator.beta(k + 0.5, n - k + 0.5, (DRAWS, len(known)))
    possible = np.array([cell.feasible for cell in known])
    return np.mean((shares >= STABLE_SHARE) & possible, axis=1)


def interval_of(draws: np.ndarray) -> Interval:
    """Percentile interval of draws."""
    tail = 50.0 * (1.0 - LEVEL)
    low, high = np.percentile(draws, [tail, 100.0 - tail])
    return Interval(float(low), float(high))
