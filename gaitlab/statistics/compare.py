"""Whether two treatments differ: the one pairing of runs by seed, the one test, the one verdict.

A seed draws the servos, the friction and the ground of a run, and draws them alike in every cell.
The runs of one seed therefore share their luck, and the seed is the independent unit, not the run.
Pairs of equal cell and seed are summed over each seed and tested by random signs of these sums, as
[Winkler2014] does with blocks that are exchanged as a whole. In a single cell, where each seed has
one pair, that is the exact test of McNemar; over several cells McNemar's test and signed ranks
would count the same luck once a cell and call it a difference far too often. Where no seed is
shared, ranks within cells are compared and whole seeds shuffled between the sides.

Intervals take whole seeds too: Student's of a ratio over clusters, [Cochran1977]. That of a share
is never narrower than the interval of independent pairs or runs, since few seeds that happen to
agree prove nothing, as [KornGraubard1998] hold it.

References:
    Cochran1977: Cochran, Sampling Techniques, 3rd edition, 1977, section 6.3.
    Efron1979: Efron, Bootstrap methods: another look at the jackknife, Annals of Statistics, 1979.
    Holm1979: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
        Statistics, 1979.
    KornGraubard1998: Korn and Graubard, Confidence intervals for proportions with small expected
        number of positive counts estimated from survey data, Survey Methodology, 1998.
    Tarone1990: Tarone, A modified Bonferroni method for discrete data, Biometrics, 1990.
    Winkler2014: Winkler et al., Permutation inference for the general linear model, NeuroImage,
        2014.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from math import ceil, comb, inf, nan, sqrt
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from gaitlab.statistics.clusters import Stratum, clustered_rank_sum, sign_flip
from gaitlab.statistics.power import values_for_mean
from gaitlab.statistics.proportions import (
    Alternative,
    Count,
    Interval,
    difference_of_proportions,
    paired_difference,
)

LEVEL = 0.05  # two-sided, for all contrasts that are judged together
MOST_SEEDS = 1000  # a cell; beyond it nobody waits
CONFIDENCE = 0.95
UNKNOWN = Interval(nan, nan)
RESAMPLES = 2000  # of seeds; the ends of a 95 % interval settle to some 3 % of its width

Verdict: TypeAlias = Literal["better", "worse", "higher", "lower", "cannot tell", "no data"]
Direction: TypeAlias = Literal["higher", "lower", "neither"]  # what is better
Key: TypeAlias = tuple[Hashable, int]  # cell and seed of a run


class Match(NamedTuple):
    """Which runs of two treatments belong together.

    Attributes:
        paired: Whether place k of both sides has the same cell and seed; else only cells agree.
        rows: Positions of these runs among those given, of the first and of the second side.
        cells: Number of the cell of each of these runs, from 0 in the order of the first side.
        unshared: Cells that only one side has.
    """

    paired: bool
    rows: tuple[np.ndarray, np.ndarray]
    cells: tuple[np.ndarray, np.ndarray]
    unshared: int


def match(first: Sequence[Key], second: Sequence[Key]) -> Match:
    """Runs of two treatments in the cells that both have; by seed as soon as they share one.

    Of runs with equal cell and seed on one side the first is paired.

    Args:
        first: Cell and seed of each run of the first treatment.
        second: The same of the second.
    """
    there = {cell for cell, _ in second}
    shared = dict.fromkeys(cell for cell, _ in first if cell in there)
    numbers = {cell: number for number, cell in enumerate(shared)}
    unshared = len({cell for cell, _ in first} ^ there)
    sides = [
        sorted(
            (numbers[cell], seed, row) for row, (cell, seed) in enumerate(side) if cell in numbers
        )
        for side in (first, second)
    ]
    known = [{(cell, seed): row for cell, seed, row in reversed(side)} for side in sides]
    pairs = sorted(known[0].keys() & known[1].keys())
    if pairs:
        sides = [[(*pair, rows[pair]) for pair in pairs] for rows in known]
    columns = [np.array(side, dtype=int).reshape(-1, 3).T for side in sides]
    return Match(
        paired=bool(pairs),
        rows=(columns[0][2], columns[1][2]),
        cells=(columns[0][0], columns[1][0]),
        unshared=unshared,
    )


class Side(NamedTuple):
    """One quantity of the runs of one treatment.

    Attributes:
        values: Of each run. Shape (n,).
        cells: Number of its cell. Shape (n,).
        seeds: Its seed. Shape (n,).
    """

    values: np.ndarray
    cells: np.ndarray
    seeds: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """One quantity of two treatments, where it is defined; see `runs_of`.

    Attributes:
        first: Of the first treatment.
        second: Of the second; in pairs value k is of the cell and seed of the first one's.
        paired: Whether they are pairs; else both have values in each cell.
        outcomes: Whether the values are 1 for a success and 0 for none.
    """

    first: Side
    second: Side
    paired: bool
    outcomes: bool

    @property
    def n(self) -> int:
        """Pairs; without pairs the runs of the smaller side of each cell."""
        sizes = [np.unique(side.cells, return_counts=True)[1] for side in (self.first, self.second)]
        return int(np.minimum(*sizes).sum())

    @property
    def seeds(self) -> tuple[int, int]:
        """Independent units of both sides."""
        return len(np.unique(self.first.seeds)), len(np.unique(self.second.seeds))

    @property
    def means(self) -> tuple[float, float]:
        """Of both sides: over the pairs, or over cells of equal weight."""
        if self.paired:
            return float(np.mean(self.first.values)), float(np.mean(self.second.values))
        first, second = (
            float(np.mean([np.mean(side.values[side.cells == cell]) for cell in self._cells]))
            for side in (self.first, self.second)
        )
        return first, second

    @property
    def strata(self) -> list[Stratum]:
        """Second and first values of each cell."""
        return self._by_cell("values")

    @property
    def labels(self) -> list[Stratum]:
        """Seeds of the values that `strata` gives."""
        return self._by_cell("seeds")

    @property
    def seed_changes(self) -> np.ndarray:
        """Sum over the cells of each seed's changes, second less first. Shape (seeds,).

        Of pairs only. An outcome counts alike wherever it is. A quantity's changes are divided by
        their root mean square in the cell, so that a cell in which runs scatter much does not
        drown the others; that is the same whichever side is called the first.
        """
        changes, cells = self.second.values - self.first.values, self.first.cells
        if not self.outcomes:
            sizes = np.sqrt(_sums(changes**2, cells) / np.maximum(_sums(None, cells), 1.0))
            changes = changes / np.where(sizes > 0.0, sizes, 1.0)[_places(cells)]
        return _sums(changes, self.first.seeds)

    @property
    def least(self) -> float:
        """Smallest two-sided p-value that these runs could give, whichever side won."""
        if self.paired:
            return 2.0 * 0.5 ** int(np.count_nonzero(self.seed_changes))
        first, second = self.seeds
        return 2 / comb(first + second, first)

    def p_value(self, alternative: Alternative = "two-sided") -> float:
        """Chance of a change as large if there was none; `less` asks if the second is smaller."""
        if not len(self.first.values):
            return 1.0
        if self.paired:
            return sign_flip(self.seed_changes, alternative)
        return clustered_rank_sum(self.strata, self.labels, alternative)

    @property
    def interval(self) -> Interval:
        """95 % interval of the change of the mean, second less first."""
        from scipy.special import stdtrit

        gap, (_, variance, freedom) = self.means[1] - self.means[0], self._scatter()
        reach = float(stdtrit(freedom, 0.5 + CONFIDENCE / 2.0)) * sqrt(variance) if freedom else inf
        found = Interval(gap - reach, gap + reach)
        if not self.outcomes:
            return found
        alone = self._independent(gap)
        return Interval(max(min(found.low, alone.low), -1.0), min(max(found.high, alone.high), 1.0))

    @property
    def deviation(self) -> float:
        """Standard deviation of what one seed, or one of each side, tells of the change."""
        return sqrt(self._scatter()[0])

    def _independent(self, gap: float) -> Interval:
        """Interval of the change of a share if every pair or run stood for itself."""
        first, second = (side.values > 0.5 for side in (self.first, self.second))
        if self.paired:
            return paired_difference(zip(second.tolist(), first.tolist(), strict=True))
        counts = [Count(int(side.sum()), len(side)) for side in (second, first)]
        pooled = counts[0].successes / counts[0].n - counts[1].successes / counts[1].n
        low, high = difference_of_proportions(counts[0], counts[1])
        return Interval(gap + low - pooled, gap + high - pooled)

    def _scatter(self) -> tuple[float, float, int]:
        """Variance of a seed and of the mean, from whole seeds, and its degrees of freedom."""
        if self.paired:
            changes = self.second.values - self.first.values
            parts = [((changes - changes.mean()) / len(changes), self.first.seeds)]
        else:
            parts = [(self._about_cells(side), side.seeds) for side in (self.first, self.second)]
        sizes = [len(np.unique(seeds)) for _, seeds in parts]
        if min(sizes) < 2:
            return inf, inf, 0
        means = [
            k / (k - 1.0) * float(np.sum(_sums(rests, seeds) ** 2))
            for k, (rests, seeds) in zip(sizes, parts, strict=True)
        ]
        single = sum(k * mean for k, mean in zip(sizes, means, strict=True))
        return single, sum(means), min(sizes) - 1

    def _about_cells(self, side: Side) -> np.ndarray:
        """Share of each value in the mean over the cells, about the mean of its cell."""
        place = _places(side.cells)
        sizes = _sums(None, side.cells)
        means = _sums(side.values, side.cells) / sizes
        return (side.values - means[place]) / (sizes[place] * len(sizes))

    @property
    def _cells(self) -> list[int]:
        return [int(cell) for cell in np.unique(self.first.cells)]

    def _by_cell(self, what: Literal["values", "seeds"]) -> list[Stratum]:
        first, second = (
            [getattr(side, what)[side.cells == cell] for cell in self._cells]
            for side in (self.first, self.second)
        )
        return list(zip(second, first, strict=True))


def runs_of(first: Side, second: Side, *, paired: bool, outcomes: bool = False) -> Runs:
    """One quantity of matched runs: a value that is NaN leaves with its partner or its cell."""
    there = [np.isfinite(side.values) for side in (first, second)]
    if paired:
        there = [there[0] & there[1]] * 2
    else:
        both = np.intersect1d(first.cells[there[0]], second.cells[there[1]])
        there = [
            known & np.isin(side.cells, both)
            for known, side in zip(there, (first, second), strict=True)
        ]
    chosen = [
        Side(*(column[known] for column in side))
        for side, known in zip((first, second), there, strict=True)
    ]
    return Runs(first=chosen[0], second=chosen[1], paired=paired, outcomes=outcomes)


def _places(labels: np.ndarray) -> np.ndarray:
    """Place of each label among the different ones, which are sorted."""
    return np.unique(labels, return_inverse=True)[1]


def _sums(values: np.ndarray | None, labels: np.ndarray) -> np.ndarray:
    """Sum of the values of each label, in their order; how many there are without values."""
    return np.bincount(_places(labels), weights=np.ones(len(labels)) if values is None else values)


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """Second treatment against the first, in one quantity.

    Attributes:
        quantity: `stable`, or the name of a metric.
        direction: Which of its values are better.
        first: Share or mean of the first treatment over the runs compared.
        second: The same of the second.
        interval: 95 % interval of the difference.
        n: Pairs, or without pairs the runs of the smaller side.
        seeds: Independent units among them, of the smaller side.
        paired: Whether they are pairs.
        p_value: Two-sided, of this quantity alone.
        least: Smallest p-value that could have come out.
        deviation: Standard deviation of what one seed tells of the difference.
        verdict: What can be said, all contrasts of `judged` together.
        needed: If nothing can, seeds a cell that would tell a difference of this size among as
            many contrasts, with 80 % power; infinite if no number would.
    """

    quantity: str
    direction: Direction
    first: float = nan
    second: float = nan
    interval: Interval = UNKNOWN
    n: int = 0
    seeds: int = 0
    paired: bool = False
    p_value: float = 1.0
    least: float = 1.0
    deviation: float = inf
    verdict: Verdict = "no data"
    needed: float = inf

    @property
    def difference(self) -> float:
        """Second less first."""
        return self.second - self.first

    @property
    def advice(self) -> str:
        """How many seeds would tell, in words; empty if it is told, or if no number would."""
        if self.verdict != "cannot tell" or self.needed == inf:
            return ""
        count = f"more than {MOST_SEEDS}" if self.needed > MOST_SEEDS else f"some {self.needed:.0f}"
        return f"{count} seeds a cell would tell a difference of this size"


def contrast(quantity: str, runs: Runs, direction: Direction) -> Contrast:
    """Differences of one quantity; `judged` gives the verdict."""
    if not len(runs.first.values):
        return Contrast(quantity=quantity, direction=direction)
    first, second = runs.means
    return Contrast(
        quantity=quantity,
        direction=direction,
        first=first,
        second=second,
        interval=runs.interval,
        n=runs.n,
        seeds=min(runs.seeds),
        paired=runs.paired,
        p_value=runs.p_value(),
        least=runs.least,
        deviation=runs.deviation,
    )


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values corrected for their number, [Holm1979], in the order given.

    Calling those below a level significant is wrong about any true null hypothesis with at most
    that chance, however the tests depend on each other.
    """
    order = np.argsort(p_values, kind="stable")
    raw = np.asarray(p_values, dtype=float)[order] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(raw), 1.0)
    return [float(value) for value in adjusted]


def judged(contrasts: Sequence[Contrast]) -> list[Contrast]:
    """Contrasts with their verdicts, all of one family.

    Of twenty families without any difference at most one names one. A contrast that could not have
    told anything, whichever side won, is no test of the family, [Tarone1990].
    """
    able = [item.n > 0 and item.least < LEVEL for item in contrasts]
    tested = [item.p_value for item, asked in zip(contrasts, able, strict=True) if asked]
    adjusted = iter(holm(tested))
    level = LEVEL / max(sum(item.n > 0 for item in contrasts), 1)
    return [
        _judged(item, next(adjusted) if asked else 1.0, level)
        for item, asked in zip(contrasts, able, strict=True)
    ]


def _judged(item: Contrast, adjusted: float, level: float) -> Contrast:
    if not item.n:
        return item
    if adjusted < LEVEL and not item.interval.low <= 0.0 <= item.interval.high:
        return replace(item, verdict=_side(item.direction, item.difference > 0.0))
    return replace(item, verdict="cannot tell", needed=_needed(item, level))


def _side(direction: Direction, up: bool) -> Verdict:
    if direction == "neither":
        return "higher" if up else "lower"
    return "better" if up == (direction == "higher") else "worse"


def _needed(item: Contrast, level: float) -> float:
    """Seeds a cell; more than there are, for these have not told."""
    if not item.difference or item.deviation == inf:
        return inf
    fewest = next(k for k in range(1, 64) if _least(k, item.paired) < level)
    enough = values_for_mean(item.deviation, item.difference, level)
    return float(max(ceil(enough), fewest, item.seeds + 1))


def _least(seeds: int, paired: bool) -> float:
    return 2.0 * 0.5**seeds if paired else 2 / comb(2 * seeds, seeds)


def seed_interval(seeds: Sequence[int], value: Callable[[Sequence[int]], float]) -> Interval:
    """95 % interval of a value of whole seeds when these are drawn again, [Efron1979].

    For what is no mean, the worst of all seeds for instance. Always the same draws.

    Raises:
        ValueError: If there are no seeds.
    """
    if not seeds:
        raise ValueError("no seeds have no value; give at least one")
    draws = np.random.default_rng(0).choice(np.array(seeds), size=(RESAMPLES, len(seeds)))
    values = [value([int(seed) for seed in draw]) for draw in draws]
    # A value can be infinitely bad, and nothing lies halfway to infinity.
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(values, [tail, 1.0 - tail], method="inverted_cdf")
    return Interval(float(low), float(high))


def verdict_of(lead: Interval) -> Verdict:
    """What an interval of a lead says, where above 0 is better."""
    return "better" if lead.low > 0.0 else "worse" if lead.high < 0.0 else "cannot tell"
