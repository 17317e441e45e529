"""Efficiency without and with an optimisation: the gain with its interval, and the paper's own.

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from gaitlab.experiment.reference import ReferenceTable
from gaitlab.papers.printed import eros_tables, forward_counted
from gaitlab.papers.reproduction.answers import Answer, Judged
from gaitlab.report.matching import Matched
from gaitlab.report.scores import (
    DRAWS,
    ScoredCell,
    cell_of,
    efficiency_draws,
    interval_of,
    mean_percent,
    truth,
)
from gaitlab.report.words import plural
from gaitlab.statistics import STABLE_SHARE, Interval, efficiency

# Stable backward rows of Table 7 that the percentages stated in the text imply, by pedestal: with
# them, and only with them, 10 rows a pedestal give 10, 10, 30 and 80 % as they do for Table 8. The
# printed backward block is that of Table 8.
IMPLIED_BACKWARD: Mapping[str, int] = {
    "grass_50mm": 0,
    "grass_30mm": 0,
    "grass_10mm": 0,
    "carpet_4mm": 2,
}


class Claim(NamedTuple):
    """Efficiencies that one way of counting gives the paper, in percent."""

    name: str
    without: float
    with_: float


class Simulated(NamedTuple):
    """Efficiencies here, in percent, the gain in points, with their intervals."""

    without: float
    without_interval: Interval
    with_: float
    with_interval: Interval
    gain: float
    gain_interval: Interval
    paired: bool


class Differing(NamedTuple):
    """Cells with another verdict than the printed one, and what they add to the gain.

    Attributes:
        table: Printed table that they are of.
        direction: Their rows'.
        stable: Whether they are stable though printed unstable, or not though printed stable.
        n: How many.
        points: Percentage points of efficiency; negative where they make the gain smaller.
    """

    table: ReferenceTable
    direction: str
    stable: bool
    n: int
    points: float

    @property
    def text(self) -> str:
        """What they are: `Table 7 forward, stable though printed unstable (6 cells)`."""
        here, printed = ("stable", "unstable") if self.stable else ("not stable", "stable")
        what = f"{here} though printed {printed}"
        return f"{self.table.title} {self.direction}, {what} ({plural(self.n, 'cell')})"


def differing(cells: Sequence[Judged]) -> list[Differing]:
    """What makes the gain another one than the printed, the largest loss first.

    Every ground of a table weighs the same, as in the paper. Their points add up to the gain here
    less the printed one, over the same cells.
    """
    before, _ = eros_tables()
    counts = Counter((cell.table.name, cell.place.surface) for cell in cells)
    grounds = Counter(table for table, _ in counts)
    groups: dict[tuple[str, str, bool], list[Judged]] = {}
    for cell in cells:
        if not cell.agrees():
            key = (cell.table.name, cell.place.direction, not cell.printed)
            groups.setdefault(key, []).append(cell)
    found = []
    for (name, direction, stable), group in groups.items():
        weights = (100.0 / (grounds[name] * counts[name, cell.place.surface]) for cell in group)
        points = sum(weights) * (1.0 if stable == (name != before.name) else -1.0)
        found.append(Differing(group[0].table, direction, stable, len(group), points))
    return sorted(found, key=lambda each: each.points)


def claims() -> list[Claim]:
    """The paper's efficiencies as stated, counted over all printed cells, forward, and implied."""
    before, after = eros_tables()
    rows = {
        ground: len([k for k in before.cells if k.surface == ground]) for ground in before.stated
    }
    counts = {g: sum(_verdicts(before, g)) + IMPLIED_BACKWARD[g] for g in before.stated}
    implied = efficiency([100.0 * counts[ground] / rows[ground] for ground in before.stated])
    return [
        Claim("stated in the text", _stated(before), _stated(after)),
        Claim("counted, all 10 rows", before.counted_mean, after.counted_mean),
        Claim("counted, 7 forward rows", _forward(before), _forward(after)),
        Claim("counted, with the backward rows that the text implies", implied,
              after.counted_mean),
    ]  # fmt: skip


def _stated(table: ReferenceTable) -> float:
    return float(table.content.stated_mean or 0.0)


def _forward(table: ReferenceTable) -> float:
    return efficiency(list(forward_counted(table).values()))


def _verdicts(table: ReferenceTable, ground: str) -> list[bool]:
    places = table.cells.items()
    return [v for k, v in places if k.surface == ground and k.direction == "forward"]


def simulated(before: Answer, after: Answer, runs: Matched) -> Simulated:
    """Efficiencies of two answers, and the gain; where one lacks runs, over those that both have.

    Args:
        before: Without the optimisation.
        after: With it.
        runs: Runs of both, `before` first; paired if they share seeds.
    """
    first, second = before.columns, after.columns
    if runs.unshared or any(
        len(runs.first) < sum(c.n for s in side for c in s) for side in (first, second)
    ):
        first, second = (_columns(side) for side in (runs.first, runs.second))
    paired = runs.paired
    draws = (
        gain_draws(runs)
        if paired
        else efficiency_draws(second, stream=1) - efficiency_draws(first, stream=0)
    )
    return Simulated(
        without=mean_percent(first),
        without_interval=_interval(efficiency_draws(first)),
        with_=mean_percent(second),
        with_interval=_interval(efficiency_draws(second, stream=1)),
        gain=mean_percent(second) - mean_percent(first),
        gain_interval=_interval(draws),
        paired=paired,
    )


def _columns(runs: pd.DataFrame) -> list[list[ScoredCell]]:
    """Cells of the runs on each ground."""
    grounds = (ground for _, ground in runs.groupby("surface", sort=False))
    return [[cell_of(cell) for _, cell in ground.groupby("cell")] for ground in grounds]


def _interval(draws: np.ndarray) -> Interval:
    """Interval of draws, to a millionth: half a percent is rounded like the mean beside it."""
    low, high = interval_of(draws)
    return Interval(round(low, 6), round(high, 6))


def gain_draws(runs: Matched) -> np.ndarray:
    """Plausible gains in efficiency given the pairs of runs that were seen. Shape (draws,).

    As `efficiency_draws`, but both shares of a cell are drawn together: the four outcomes of a pair
    have a Dirichlet posterior with 1/4 each before any run, so that each share alone has the
    Jeffreys posterior of a single one. Cells out of reach of one side are certainly unstable there.
    """
    generator = np.random.default_rng([20180622, 7])
    grounds = runs.first["surface"].to_numpy()
    cells = runs.first["cell"].to_numpy()
    by_ground = [
        np.mean(
            [_cell_draws(runs, cells == cell, generator) for cell in np.unique(cells[chosen])],
            axis=0,
        )
        for chosen in (grounds == ground for ground in dict.fromkeys(grounds.tolist()))
    ]
    return 100.0 * np.mean(by_ground, axis=0) if by_ground else np.full(DRAWS, np.nan)


def _cell_draws(runs: Matched, chosen: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Gain of one cell: 1, 0 or -1 in each draw. Shape (draws,)."""
    before, after = (truth(side["stable"])[chosen] for side in (runs.first, runs.second))
    counts = [np.sum((before == b) & (after == a)) for b, a in OUTCOMES]
    shares = generator.dirichlet(np.array(counts) + 0.25, DRAWS)
    within = [
        bool((side["state"][chosen] != "INFEASIBLE").any()) for side in (runs.first, runs.second)
    ]
    first = (shares[:, 2] + shares[:, 3] >= STABLE_SHARE) & within[0]
    second = (shares[:, 1] + shares[:, 3] >= STABLE_SHARE) & within[1]
    return second.astype(float) - first.astype(float)


OUTCOMES = ((False, False), (False, True), (True, False), (True, True))  # of a pair
