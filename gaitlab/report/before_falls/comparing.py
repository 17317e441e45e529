"""Like compared with like: the same gait cycle of walks that fell and of others that did not.

Three comparisons: walks of one cell that fell against those that stayed up; falls on a ground
against the same step and seed on the firmest ground; walks of one variant against the same step,
seed and ground of another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitlab.report.before_falls.measures import MEASURES
from gaitlab.statistics import (
    Interval,
    mean_interval,
    stratified_difference_interval,
)

CONFIDENCE = 0.99  # of one interval; a page shows hundreds of them
LEAST = 3  # walks on either side of a cell; fewer have hardly a scatter
ENOUGH = 5  # walks on either side of all cells; the interval is a normal one


@dataclass(frozen=True, kw_only=True, eq=False)
class Contrast:
    """One measure on two sides, in SI units.

    Attributes:
        measure: Its key in `MEASURES`.
        first: Values of the first side. Shape (n,).
        second: Values of the second side. Shape (m,).
        means: Of both sides, each cell or pair with the same weight.
        interval: 99 % interval of the difference.
        groups: Cells, or pairs, that the difference is made from.
    """

    measure: str
    first: np.ndarray
    second: np.ndarray
    means: tuple[float, float]
    interval: Interval
    groups: int

    @property
    def difference(self) -> float:
        """First less second."""
        return self.means[0] - self.means[1]

    @property
    def clear(self) -> bool:
        """Whether the interval leaves zero out."""
        return bool(self.groups) and not self.interval.low <= 0.0 <= self.interval.high

    @property
    def scatters(self) -> bool:
        """Whether the values differ at all; an interval of equal ones has no width to trust."""
        return bool(np.ptp(np.concatenate([self.first, self.second])) > 0.0)

    @property
    def size(self) -> float:
        """Difference over the scatter of the two sides, unsigned; infinite without scatter."""
        scatter = np.sqrt(0.5 * (np.var(self.first) + np.var(self.second)))
        return float(abs(self.difference) / scatter) if scatter > 0.0 else np.inf


def fell_and_stayed(trials: pd.DataFrame, cell: Sequence[str]) -> pd.DataFrame:
    """The walks of every cell in which some fell and some did not, at the same gait cycle.

    A fall is looked at where it last stood well, a walk that stayed up where the falls of its
    cell did in the median.

    Args:
        trials: `trial_id`, `fell`, `cycles` and the columns of `cell`.
        cell: Columns that make a cell.

    Returns:
        `trial_id`, `cycles`, `stratum` and `side`, 0 for a fall.
    """
    parts = []
    for number, (_, group) in enumerate(trials.groupby(list(cell), sort=False)):
        down, up = group[group["fell"]], group[~group["fell"]]
        if len(down) and len(up):
            middle = float(np.sort(down["cycles"])[(len(down) - 1) // 2])
            parts.append(down.assign(stratum=number, side=0))
            parts.append(up.assign(stratum=number, side=1, cycles=middle))
    return _asked(parts)


def same_seed(first: pd.DataFrame, second: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Pairs that agree in the keys, looked at where the first of the two last stood well.

    Args:
        first: `trial_id`, `cycles` and the keys.
        second: Likewise.
        keys: Columns that make a pair; unique on either side.

    Returns:
        As of `fell_and_stayed`, a stratum a pair.
    """
    names = [*keys, "trial_id", "cycles"]
    pairs = first[names].merge(second[names], on=list(keys), suffixes=("_0", "_1"))
    cycles = np.minimum(pairs["cycles_0"], pairs["cycles_1"])
    parts = [
        pd.DataFrame({"trial_id": pairs[f"trial_id_{side}"], "cycles": cycles}).assign(
            stratum=np.arange(len(pairs)), side=side
        )
        for side in (0, 1)
    ]
    return _asked(parts)


def _asked(parts: Sequence[pd.DataFrame]) -> pd.DataFrame:
    names = ["trial_id", "cycles", "stratum", "side"]
    if not parts:
        parts = [pd.DataFrame(columns=names)]
    joined = pd.concat([part[names] for part in parts], ignore_index=True)
    return joined.astype({"cycles": float})


def contrasts(asked: pd.DataFrame, found: pd.DataFrame, *, paired: bool) -> dict[str, Contrast]:
    """Every measure of a comparison.

    Args:
        asked: As of `fell_and_stayed` or `same_seed`.
        found: As of `windows`.
        paired: Whether a stratum is a pair.
    """
    values = asked.merge(found, on=["trial_id", "cycles"], how="left")
    compare = _paired if paired else _stratified
    return {name: compare(name, values[["stratum", "side", name]].dropna()) for name in MEASURES}


def _paired(name: str, values: pd.DataFrame) -> Contrast:
    table = values.pivot(index="stratum", columns="side", values=name).reindex(columns=[0, 1])
    table = table.dropna()
    first, second = (table[side].to_numpy(float) for side in (0, 1))
    gaps = first - second
    return Contrast(
        measure=name,
        first=first,
        second=second,
        means=_means([(first, second)] if len(gaps) else []),
        interval=_possible(name, mean_interval(gaps.tolist(), CONFIDENCE)),
        groups=len(gaps),
    )


def _stratified(name: str, values: pd.DataFrame) -> Contrast:
    strata = []
    for _, group in values.groupby("stratum"):
        sides = [group.loc[group["side"] == side, name].to_numpy(float) for side in (0, 1)]
        if min(len(side) for side in sides) >= LEAST:
            strata.append((sides[0], sides[1]))
    if any(sum(len(pair[side]) for pair in strata) < ENOUGH for side in (0, 1)):
        strata = []
    first, second = (
        np.concatenate([pair[side] for pair in strata]) if strata else np.zeros(0)
        for side in (0, 1)
    )
    return Contrast(
        measure=name,
        first=first,
        second=second,
        means=_means(strata),
        interval=_possible(name, stratified_difference_interval(strata, CONFIDENCE)),
        groups=len(strata),
    )


def _means(strata: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """Mean over the strata of the means of both sides."""
    if not strata:
        return np.nan, np.nan
    first, second = (float(np.mean([np.mean(pair[k]) for pair in strata])) for k in (0, 1))
    return first, second


def _possible(name: str, found: Interval) -> Interval:
    """The part of an interval that the measure allows."""
    widest = MEASURES[name].widest
    return Interval(max(found.low, -widest), min(found.high, widest))
