"""What a designed sweep found: at every point of its box, both variants' stable shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from gaitlab.errors import UsageError
from gaitlab.experiment import Axis, Design, Experiment, Value
from gaitlab.report.results import Results
from gaitlab.report.scores import SCORED
from gaitlab.report.variants import is_off, label_of

SWITCH = (str, bool)  # types of a value that tells variants apart


class Sides(NamedTuple):
    """Something of the variant without and of the one with the switches on."""

    without: np.ndarray
    with_it: np.ndarray

    @property
    def improvement(self) -> np.ndarray:
        """What switching on gains."""
        return self.with_it - self.without


@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """The points whose walks are all scored, in the order of the design.

    Attributes:
        design: Box and points.
        labels: What the variant without and the one with the switches on are called.
        places: Of each point along the edges of the box, 0 at the low ends. Shape (n, k).
        walks: Of each variant at each point.
        by_ground: Stable shares of the points on each ground. Shapes (n,).
        by_seed: Stable shares of the points with each seed, the mean over the grounds. Shapes
            (n, seeds).
        left_out: Points with a walk that failed or was not simulated yet.
    """

    design: Design
    labels: tuple[str, str]
    places: np.ndarray
    walks: int
    by_ground: Mapping[str, Sides]
    by_seed: Sides
    left_out: int

    @property
    def shares(self) -> Sides:
        """Stable shares of the points, the mean over the grounds. Shapes (n,)."""
        sides = zip(*self.by_ground.values(), strict=True)
        return Sides(*(np.mean(side, axis=0) for side in sides))


def sweep_of(experiment: Experiment, results: Results) -> Sweep:
    """The sweep of an experiment with a design.

    Its variants are the first and the last row of the axis that holds switches: everything off,
    and everything on.

    Raises:
        UsageError: If the experiment has no design or varies no switch.
    """
    design, axis = _design(experiment), _switches(experiment)
    ends = [dict(zip(axis.paths, row, strict=True)) for row in (axis.rows[0], axis.rows[-1])]
    switched = [path for path, value in ends[0].items() if is_off(value)]
    points = _points(design, results.trials)
    trials = results.trials.assign(point=points, scored=results.trials["state"].isin(SCORED))
    trials = trials.assign(up=trials["stable"].eq(True))
    sides = [trials[_where(trials, values)] for values in ends]
    complete = pd.concat(sides).groupby("point")["scored"].all()
    kept = np.flatnonzero(complete.to_numpy())
    return Sweep(
        design=design,
        labels=(label_of(ends[0], switched), label_of(ends[1], switched)),
        places=_places(design)[complete.index[kept]],
        walks=len(sides[0]) // max(1, len(complete)),
        by_ground={
            str(ground): Sides(*(_shares(side, ground, complete.index[kept]) for side in sides))
            for ground in results.trials["surface"].unique()
        },
        by_seed=Sides(*(_by_seed(side, complete.index[kept]) for side in sides)),
        left_out=design.points - len(kept),
    )


def compares_switches(experiment: Experiment) -> bool:
    """Whether an experiment has a design and, beside it, a switch."""
    return experiment.design is not None and _switched_axis(experiment) is not None


def _design(experiment: Experiment) -> Design:
    if experiment.design is None:
        raise UsageError(
            f"{experiment.name} has no `design:`, so that nothing is swept; name a member that has"
        )
    return experiment.design


def _switches(experiment: Experiment) -> Axis:
    axis = _switched_axis(experiment)
    if axis is None:
        raise UsageError(
            f"{experiment.name} varies no switch beside its design; list two gaits under zip or "
            "grid, `gait.heel_strike: [none, add]` for instance"
        )
    return axis


def _switched_axis(experiment: Experiment) -> Axis | None:
    """The first axis that is not swept and whose first path takes names."""
    swept = {path for item in _design(experiment).box for path in item.paths}
    others = (axis for axis in experiment.axes if not swept & set(axis.paths))
    named = (a for a in others if len(a.rows) > 1 and isinstance(a.rows[0][0], SWITCH))
    return next(named, None)


def _points(design: Design, trials: pd.DataFrame) -> np.ndarray:
    """Number of the point of every trial."""
    axis = design.axis()
    number = {row: index for index, row in enumerate(axis.rows)}
    rows = trials[list(axis.paths)].itertuples(index=False, name=None)
    return np.array([number[row] for row in rows])


def _places(design: Design) -> np.ndarray:
    axis = design.axis()
    columns = [axis.paths.index(item.range.path) for item in design.box]
    pairs = list(zip(design.box, columns, strict=True))
    return np.array([[item.place(float(row[c])) for item, c in pairs] for row in axis.rows])


def _where(trials: pd.DataFrame, values: Mapping[str, Value]) -> np.ndarray:
    matches = [trials[path].eq(value).to_numpy() for path, value in values.items()]
    return np.asarray(np.logical_and.reduce(matches))


def _shares(trials: pd.DataFrame, ground: object, points: pd.Index) -> np.ndarray:
    chosen = trials[trials["surface"] == ground]
    return np.asarray(chosen.groupby("point")["up"].mean().reindex(points), dtype=float)


def _by_seed(trials: pd.DataFrame, points: pd.Index) -> np.ndarray:
    means = trials.groupby(["point", "seed", "surface"])["up"].mean()
    table = means.groupby(["point", "seed"]).mean().unstack("seed")
    return np.asarray(table.reindex(points), dtype=float)
