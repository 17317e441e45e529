"""Tonight's walks beside the baseline's: same cell, and the same seed where both have it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gaitlab.metrics import lookup
from gaitlab.regression.baseline import Baseline, Walk
from gaitlab.statistics import Runs, Side, match, runs_of


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
class MatchedWalks:
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

    def on(self, surface: str) -> MatchedWalks:
        """The cells of one ground; all of them for no name."""
        chosen = (cell for cell in self.cells if surface in ("", cell.surface))
        return replace(self, cells=tuple(chosen))

    def runs(self, quantity: str) -> Runs:
        """`stable` or a metric of the walks that it is fair for, tonight's as the second."""
        before, tonight = (
            _side([getattr(cell, side) for cell in self.cells], quantity)
            for side in ("before", "tonight")
        )
        return runs_of(before, tonight, paired=self.paired, outcomes=quantity == "stable")


def matched(before: Baseline, tonight: Baseline) -> MatchedWalks:
    """Walks in cells that both have; by seed if any cell shares one."""
    sides = tonight.walks, before.walks
    found = match(*([(walk.place, walk.seed) for walk in side] for side in sides))
    cells: dict[int, tuple[list[Walk], list[Walk]]] = {}
    for side in (0, 1):
        for row, cell in zip(found.rows[side].tolist(), found.cells[side].tolist(), strict=True):
            cells.setdefault(cell, ([], []))[side].append(sides[side][row])
    return MatchedWalks(
        paired=found.paired,
        cells=tuple(
            MatchedCell(
                surface=str(now[0].cell.get("surface")), before=tuple(then), tonight=tuple(now)
            )
            for now, then in cells.values()
        ),
        unshared=found.unshared,
    )


def _side(cells: list[tuple[Walk, ...]], quantity: str) -> Side:
    """A quantity of every walk, NaN where it is not fair to compare it."""
    walks = [(number, walk) for number, cell in enumerate(cells) for walk in cell]
    numbers = [np.nan if (value := _fair(w, quantity)) is None else value for _, w in walks]
    return Side(
        values=np.array(numbers, dtype=float),
        cells=np.array([number for number, _ in walks], dtype=int),
        seeds=np.array([walk.seed for _, walk in walks], dtype=int),
    )


def _fair(walk: Walk, quantity: str) -> float | None:
    if quantity == "stable":
        return float(walk.stable)
    value = walk.metrics.get(quantity) if lookup(quantity).counts_falls or walk.walked else None
    return None if value is None else float(value)
