"""Which runs of two variants belong together: same cell, and the same seed where both have it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from gaitlab.metrics import counts_falls
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Variant
from gaitlab.statistics import Count

SCORED = ("DONE", "INFEASIBLE")  # out of reach counts as not stable


@dataclass(frozen=True, kw_only=True, eq=False)
class Matched:
    """The runs of two variants in the cells that both have.

    Attributes:
        paired: Whether row k of both tables has the same cell and seed; else only the cells agree.
        first: Runs of the first variant, with their cell's number under `cell`.
        second: Runs of the second variant.
        unshared: Cells that only one of them has.
    """

    paired: bool
    first: pd.DataFrame
    second: pd.DataFrame
    unshared: int

    @property
    def n(self) -> int:
        """Pairs; without pairs the runs of the smaller side."""
        return min(len(self.first), len(self.second))

    @cached_property
    def cells(self) -> int:
        """Cells that both have."""
        return int(self.first["cell"].nunique())

    def only(self, column: str, value: object) -> Matched:
        """The part in which a column has a value that both variants share."""
        sides = (side[side[column] == value] for side in (self.first, self.second))
        first, second = (side.reset_index(drop=True) for side in sides)
        return Matched(paired=self.paired, first=first, second=second, unshared=0)

    def parts(self, columns: Sequence[str]) -> dict[tuple[object, ...], Matched]:
        """The runs by the values of these columns, no more of each than its outcome."""
        kept = list(dict.fromkeys(("cell", "stable", *columns)))
        sides = [
            {key: part.reset_index(drop=True) for key, part in side[kept].groupby(list(columns))}
            for side in (self.first, self.second)
        ]
        return {
            key: Matched(paired=self.paired, first=first, second=sides[1][key], unshared=0)
            for key, first in sides[0].items()
            if key in sides[1]
        }

    def flags(self) -> tuple[np.ndarray, np.ndarray]:
        """Whether each run was stable. Shapes (runs,)."""
        return truth(self.first["stable"]), truth(self.second["stable"])

    def counts(self) -> list[tuple[Count, Count]]:
        """Stable runs of both in each cell."""
        sides = [
            pd.Series(flags).groupby(side["cell"].to_numpy()).agg(["sum", "size"])
            for flags, side in zip(self.flags(), (self.first, self.second), strict=True)
        ]
        both = pd.merge(*sides, left_index=True, right_index=True, suffixes=("_first", "_second"))
        return [(Count(int(a), int(n)), Count(int(b), int(m))) for a, n, b, m in both.to_numpy()]

    def differences(self, metric: str) -> np.ndarray:
        """Second less first of the pairs in which both have the metric. Shape (pairs,)."""
        found = _numbers(self.second, metric) - _numbers(self.first, metric)
        return found[np.isfinite(found)]

    def base(self, metric: str) -> float:
        """Mean of the first variant over the same pairs."""
        first, second = _numbers(self.first, metric), _numbers(self.second, metric)
        return float(np.mean(first[np.isfinite(second - first)]))

    def seeds(self, metric: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Seeds of the values that `strata` gives, in step with them."""
        sides = [_by_cell(side, metric, seeds=True) for side in (self.second, self.first)]
        return [(sides[0][cell], sides[1][cell]) for cell in sides[0] if cell in sides[1]]

    def strata(self, metric: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Second and first values of the metric in each cell where both have any."""
        sides = [_by_cell(side, metric) for side in (self.second, self.first)]
        return [(sides[0][cell], sides[1][cell]) for cell in sides[0] if cell in sides[1]]


def matched(results: Results, first: Variant, second: Variant) -> Matched:
    """The runs of two variants that can be compared; paired by seed if any seed is shared."""
    return _matched([_scored(results.of(v)) for v in (first, second)], places(results))


def common(results: Results) -> Results:
    """The runs that all variants with any have in common, cell by cell and seed by seed.

    Where they share no seed at all, as where each has its own, the runs in common cells.
    """
    scored = _scored(results.trials)
    for keys in ([*places(results), "seed"], places(results)):
        place = list(map(tuple, scored[keys].to_numpy(object)))
        of = [
            set(group)
            for _, group in pd.Series(place, dtype=object).groupby(scored["variant"].to_numpy())
        ]
        shared = set[tuple[object, ...]]().union(*of[:1]).intersection(*of)
        if shared:
            break
    return replace(results, trials=scored[[one in shared for one in place]])


def matched_grounds(results: Results, first: str, second: str) -> Matched:
    """The runs on two grounds, paired as those of variants; a cell is the same walk on both."""
    keys = ["variant", *(key for key in places(results) if key != "surface")]
    trials = results.trials
    return _matched([_scored(trials[trials["surface"] == name]) for name in (first, second)], keys)


def _matched(sides: Sequence[pd.DataFrame], keys: Sequence[str]) -> Matched:
    cells = [set(map(tuple, side[list(keys)].to_numpy(object))) for side in sides]
    shared = {place: number for number, place in enumerate(sorted(cells[0] & cells[1], key=repr))}
    unshared = len(cells[0] ^ cells[1])
    sides = [_numbered(side, keys, shared) for side in sides]
    pairs = sides[0][["cell", "seed"]].merge(sides[1][["cell", "seed"]]).drop_duplicates()
    if len(pairs):
        sides = [pairs.merge(side.drop_duplicates(["cell", "seed"])) for side in sides]
    return Matched(paired=bool(len(pairs)), first=sides[0], second=sides[1], unshared=unshared)


def places(results: Results) -> list[str]:
    """Columns that say which cell a trial belongs to, within a variant."""
    apart = {path for variant in results.variants for path in variant.values}
    fixed = list(dict.fromkeys((results.rows, results.columns, "surface")))
    varied = (
        str(name)
        for name in results.trials.columns
        if ("." in str(name) or name == "robot") and name not in apart and name not in fixed
    )
    return [*fixed, *(name for name in varied if _varies(results, name))]


def _varies(results: Results, name: str) -> bool:
    groups: Iterable[int] = results.trials.groupby("variant")[name].nunique(dropna=False)
    return any(count > 1 for count in groups)


def _scored(trials: pd.DataFrame) -> pd.DataFrame:
    return trials[trials["state"].isin(SCORED)]


def _numbered(
    side: pd.DataFrame, keys: Sequence[str], shared: dict[tuple[object, ...], int]
) -> pd.DataFrame:
    """The runs in shared cells, each with the number of its cell."""
    numbers = [shared.get(tuple(place), -1) for place in side[list(keys)].to_numpy(object)]
    found = side.assign(cell=numbers)
    return found[found["cell"] >= 0].sort_values(["cell", "seed"], ignore_index=True)


def _numbers(side: pd.DataFrame, metric: str) -> np.ndarray:
    """A metric of the runs it is fair for, NaN elsewhere. Shape (runs,)."""
    if metric == "stable":
        return truth(side["stable"]).astype(float)
    found = pd.to_numeric(side[metric], errors="coerce").to_numpy(float, na_value=np.nan)
    fair = np.ones(len(side), bool) if counts_falls(metric) else truth(side["stable_strict"])
    return np.where(np.isfinite(found) & fair, found, np.nan)


def _by_cell(side: pd.DataFrame, metric: str, *, seeds: bool = False) -> dict[int, np.ndarray]:
    known = np.isfinite(_numbers(side, metric))
    given = side["seed"].to_numpy(float) if seeds else _numbers(side, metric)
    values = pd.Series(given[known], index=side["cell"].to_numpy()[known])
    return {int(str(cell)): group.to_numpy() for cell, group in values.groupby(level=0)}
