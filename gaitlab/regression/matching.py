"""Tonight's walks beside the baseline's: same cell, and the same seed where both have it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gaitlab.metrics import counts_falls
from gaitlab.regression.baseline import Baseline, Walk
from gaitlab.statistics import Count


@dataclass(frozen=True, kw_only=True)
class MatchedCell:
    """The walks of one cell.

    Attributes:
        surface: Its ground.
        before: Of the baseline; if paired, walk k has the seed of tonight's walk k.
        tonight: Of tonight.
    """

    surface: str
    before: tuple[Walk, ...]
    tonight: tuple[Walk, ...]


@dataclass(frozen=True, kw_only=True)
class Matched:
    """All walks that can be compared.

    Attributes:
        paired: Whether they are matched by seed as well.
        cells: Cells that both have.
        unshared: Cells of the baseline that tonight lacks, and the other way round.
    """

    paired: bool
    cells: tuple[MatchedCell, ...]
    unshared: int

    @property
    def n(self) -> int:
        """Pairs; without pairs the walks of the smaller side."""
        return sum(min(len(cell.before), len(cell.tonight)) for cell in self.cells)

    @cached_property
    def surfaces(self) -> list[str]:
        """Grounds, in the order of the plan."""
        return list(dict.fromkeys(cell.surface for cell in self.cells))

    def on(self, surface: str) -> Matched:
        """The cells of one ground."""
        return replace(self, cells=tuple(c for c in self.cells if c.surface == surface))

    def pairs(self) -> Iterator[tuple[Walk, Walk]]:
        """Tonight's walk and the baseline's with the same cell and seed."""
        for cell in self.cells:
            yield from zip(cell.tonight, cell.before, strict=True)

    def counts(self) -> list[tuple[Count, Count]]:
        """Stable walks of each cell, tonight and before."""
        return [(_count(cell.tonight), _count(cell.before)) for cell in self.cells]

    def seeds(self, metric: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Seeds of the values that `values` gives, in step with them."""
        return [(tonight[1], before[1]) for tonight, before in self._sides(metric)]

    def values(self, metric: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Tonight's and the baseline's values of each cell that has any; paired ones in step."""
        return [(tonight[0], before[0]) for tonight, before in self._sides(metric)]

    def seed_changes(self, metric: str) -> np.ndarray:
        """Sum over the cells of each seed's differences, the independent numbers. Shape (seeds,).

        Of pairs only. A share counts every walk alike. A metric's differences are divided by
        their root mean square in the cell, so that a cell in which walks scatter much does not
        drown the others; it is the same whichever side is called tonight.
        """
        gaps = [tonight - before for tonight, before in self.values(metric)]
        if metric != "stable":
            gaps = [gap / (np.sqrt(np.mean(gap**2)) or 1.0) for gap in gaps]
        return by_seed(gaps, [seeds for seeds, _ in self.seeds(metric)])

    def seed_counts(self, metric: str) -> tuple[int, int]:
        """Seeds with a value, tonight and before."""
        sides = zip(*self.seeds(metric), strict=True) if self.seeds(metric) else ((), ())
        tonight, before = (len(np.unique(np.concatenate([*side, []]))) for side in sides)
        return tonight, before

    def _sides(self, metric: str) -> list[tuple[Side, Side]]:
        found = [_sides(cell, metric, self.paired) for cell in self.cells]
        return [
            (tonight, before) for tonight, before in found if len(tonight[0]) and len(before[0])
        ]


Side = tuple[np.ndarray, np.ndarray]  # values of a cell and their seeds


def by_seed(values: list[np.ndarray], seeds: list[np.ndarray]) -> np.ndarray:
    """Sum of each seed's values over all cells, in the order of the seeds. Shape (seeds,)."""
    if not values:
        return np.empty(0)
    _, place = np.unique(np.concatenate(seeds), return_inverse=True)
    return np.bincount(place, weights=np.concatenate(values))


def matched(before: Baseline, tonight: Baseline) -> Matched:
    """Walks in cells that both have; by seed if any cell shares one."""
    shared = [place for place in tonight.cells if place in before.cells]
    unshared = len(before.cells.keys() ^ tonight.cells.keys())
    pairs = [_by_seed(before.cells[place], tonight.cells[place]) for place in shared]
    paired = any(cell.tonight for cell in pairs)
    whole = [_whole(before.cells[place], tonight.cells[place]) for place in shared]
    cells = tuple(cell for cell in (pairs if paired else whole) if cell.tonight)
    return Matched(paired=paired, cells=cells, unshared=unshared)


def _whole(before: list[Walk], tonight: list[Walk]) -> MatchedCell:
    surface = str(tonight[0].cell.get("surface"))
    return MatchedCell(surface=surface, before=tuple(before), tonight=tuple(tonight))


def _by_seed(before: list[Walk], tonight: list[Walk]) -> MatchedCell:
    seeds = {walk.seed: walk for walk in before}
    common = tuple(walk for walk in tonight if walk.seed in seeds)
    surface = str(tonight[0].cell.get("surface"))
    partners = tuple(seeds[walk.seed] for walk in common)
    return MatchedCell(surface=surface, before=partners, tonight=common)


def _count(walks: tuple[Walk, ...]) -> Count:
    return Count(sum(walk.stable for walk in walks), len(walks))


def _sides(cell: MatchedCell, metric: str, paired: bool) -> tuple[Side, Side]:
    tonight, before = (_fair(walks, metric) for walks in (cell.tonight, cell.before))
    there = [np.isfinite(values) for values in (tonight, before)]
    if paired:
        there = [there[0] & there[1]] * 2
    seeds = [np.array([w.seed for w in walks]) for walks in (cell.tonight, cell.before)]
    return (tonight[there[0]], seeds[0][there[0]]), (before[there[1]], seeds[1][there[1]])


def _fair(walks: tuple[Walk, ...], metric: str) -> np.ndarray:
    """A metric of the walks that it is fair for, NaN elsewhere. Shape (walks,)."""
    if metric == "stable":
        return np.array([float(walk.stable) for walk in walks])
    always = counts_falls(metric)
    given = (walk.metrics.get(metric) if always or walk.walked else None for walk in walks)
    return np.array([np.nan if value is None else float(value) for value in given])
