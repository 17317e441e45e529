"""Which runs of a page belong together: cells of variants and of grounds, paired by seed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from gaitlab.metrics import lookup
from gaitlab.report.results import Results
from gaitlab.report.scores import SCORED, truth
from gaitlab.report.variants import Variant
from gaitlab.statistics import Contrast, Key, Runs, Side, contrast, match, runs_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Matched:
    """The runs of two variants, or on two grounds, in the cells that both have.

    Attributes:
        paired: Whether row k of both tables has the same cell and seed; else only the cells agree.
        first: Runs of the first, with their cell's number under `cell`.
        second: Runs of the second.
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
        """The part in which a column has a value that both share."""
        first, second = (
            side[side[column] == value].reset_index(drop=True) for side in (self.first, self.second)
        )
        return replace(self, first=first, second=second, unshared=0)

    def runs(self, quantity: str) -> Runs:
        """`stable` or a metric, of the runs that it is fair for."""
        sides = [
            Side(
                values=_numbers(side, quantity),
                cells=side["cell"].to_numpy(int),
                seeds=side["seed"].to_numpy(int),
            )
            for side in (self.first, self.second)
        ]
        return runs_of(*sides, paired=self.paired, outcomes=quantity == "stable")

    def contrast(self, quantity: str) -> Contrast:
        """How the second differs from the first in `stable` or a metric; not judged yet."""
        if quantity == "stable":
            return contrast(quantity, self.runs(quantity), "higher")
        if not all(quantity in side.columns for side in (self.first, self.second)):
            return Contrast(quantity=quantity, direction=lookup(quantity).better)
        return contrast(quantity, self.runs(quantity), lookup(quantity).better)


def matched(results: Results, first: Variant, second: Variant) -> Matched:
    """The runs of two variants that can be compared; paired by seed if any seed is shared."""
    return _matched([results.of(v) for v in (first, second)], places(results))


def matched_grounds(results: Results, first: str, second: str) -> Matched:
    """The runs on two grounds, paired as those of variants; a cell is the same walk on both."""
    keys = ["variant", *(key for key in places(results) if key != "surface")]
    return matched_by(results.trials, "surface", (first, second), keys)


def matched_by(
    trials: pd.DataFrame, column: str, values: tuple[object, object], keys: Sequence[str]
) -> Matched:
    """The runs with one value of a column and those with another, in cells told apart by `keys`."""
    return _matched([trials[trials[column] == value] for value in values], keys)


def _matched(sides: Sequence[pd.DataFrame], keys: Sequence[str]) -> Matched:
    first, second = (side[side["state"].isin(SCORED)] for side in sides)
    found = match(_keys(first, keys), _keys(second, keys))
    first, second = (
        side.iloc[rows].assign(cell=cells).reset_index(drop=True)
        for side, rows, cells in zip((first, second), found.rows, found.cells, strict=True)
    )
    return Matched(paired=found.paired, first=first, second=second, unshared=found.unshared)


def common(results: Results) -> Results:
    """The runs that all variants with any have in common, cell by cell and seed by seed.

    Where they share no seed at all, as where each has its own, the runs in common cells.
    """
    scored = results.trials[results.trials["state"].isin(SCORED)]
    keys = _keys(scored, places(results))
    labels = scored["variant"].to_numpy()
    shared: set[object] = set()
    for place in (keys, [cell for cell, _ in keys]):
        groups: dict[str, set[object]] = {}
        for label, key in zip(labels, place, strict=True):
            groups.setdefault(label, set()).add(key)
        shared = set.intersection(*groups.values()) if groups else set()
        if shared:
            break
    return replace(results, trials=scored[[key in shared for key in place]])


def _keys(side: pd.DataFrame, keys: Sequence[str]) -> list[Key]:
    """Cell and seed of each run; a value that a run lacks is None."""
    values = side[list(keys)].astype(object)
    cells = values.where(values.notna(), None).itertuples(index=False, name=None)
    return list(zip(cells, side["seed"].astype(int), strict=True))


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


def _numbers(side: pd.DataFrame, quantity: str) -> np.ndarray:
    """A quantity of the runs it is fair for, NaN elsewhere. Shape (runs,)."""
    if quantity == "stable":
        return truth(side["stable"]).astype(float)
    found = pd.to_numeric(side[quantity], errors="coerce").to_numpy(float, na_value=np.nan)
    fair = (
        np.ones(len(side), bool) if lookup(quantity).counts_falls else truth(side["stable_strict"])
    )
    return np.where(np.isfinite(found) & fair, found, np.nan)
