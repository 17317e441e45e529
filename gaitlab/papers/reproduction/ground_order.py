"""In which order a gait's longest steps put the grounds: ours beside a paper's.

The limit of a ground is the longest printed distance up to which every forward row is stable.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

from gaitlab.papers.reproduction.answers import Judged

NOWHERE = -1  # printed distance of a ground on which not even the first row is stable


class Limits(NamedTuple):
    """Longest stable printed distance of each ground; `NOWHERE` where none is."""

    paper: Mapping[str, float]
    ours: Mapping[str, float]


class Ordered(NamedTuple):
    """Pairs of grounds that the paper tells apart, and how we order them."""

    right: int
    tied: int
    wrong: int

    @property
    def pairs(self) -> int:
        """All of them."""
        return self.right + self.tied + self.wrong


def limits(cells: Sequence[Judged]) -> Limits:
    """Limit of each ground over the forward rows, in the order of the cells."""
    forward = [cell for cell in cells if cell.place.direction == "forward"]
    grounds = dict.fromkeys(cell.place.surface for cell in forward)
    sides = [
        {g: _limit([c for c in forward if c.place.surface == g], side) for g in grounds}
        for side in ("paper", "ours")
    ]
    return Limits(*sides)


def _limit(cells: Sequence[Judged], side: str) -> float:
    found: float = NOWHERE
    for cell in sorted(cells, key=lambda cell: cell.place.distance):
        if not (cell.printed if side == "paper" else cell.ours.verdict()):
            break
        found = cell.place.distance
    return found


def ordered(found: Limits) -> Ordered:
    """How many of the pairs that the paper tells apart stand in its order here."""
    right = tied = wrong = 0
    for one, other in combinations(found.paper, 2):
        paper = found.paper[one] - found.paper[other]
        ours = found.ours[one] - found.ours[other]
        if paper:
            right, tied = right + (paper * ours > 0), tied + (ours == 0)
            wrong += paper * ours < 0
    return Ordered(right, tied, wrong)


def ranking(distances: Mapping[str, float]) -> list[list[str]]:
    """Grounds from the longest limit to the shortest, those of one limit together."""
    ranks = sorted(set(distances.values()), reverse=True)
    return [[ground for ground, value in distances.items() if value == rank] for rank in ranks]
