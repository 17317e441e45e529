"""What a report is computed from: one table of planned trials, and how to get at their logs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import pandas as pd

from gaitlab.log import TrialLog
from gaitlab.report.scores import EMPTY, ScoredCell, cell_of
from gaitlab.report.variants import Value, Variant
from gaitlab.simulation.trial import Trial

ONE_ROW = "all"  # column of a table whose rows are not asked for


@dataclass(frozen=True, kw_only=True, eq=False)
class Results:
    """Every planned trial with its outcome.

    Attributes:
        title: Heading of the report.
        question: One sentence.
        rows: Column of `trials` that the rows of a table hold, `gait.step_length` for instance.
        columns: Column of `trials` that the columns of a table hold, `surface` for instance.
        variants: In the order of the tables.
        reading: Which reading of a reference table's rows holds; empty for its first.
        trials: One row a planned trial, in the order of the plan. Columns as of the store, every
            varied parameter under its dotted path, and `variant`, the label; the state of a trial
            that is not in the store is MISSING.
        units: SI unit of every varied parameter by its dotted path.
        metrics: Metrics to draw for each surface; empty for the usual ones.
        maps: Pairs of columns of `trials` over which to map the stable share; empty to choose.
        log: The log of a trial by its id.
        trial: The trial itself by its id.
    """

    title: str
    question: str
    rows: str
    columns: str
    variants: tuple[Variant, ...]
    reading: str
    trials: pd.DataFrame
    log: Callable[[str], TrialLog]
    trial: Callable[[str], Trial]
    units: Mapping[str, str] = field(default_factory=dict)
    metrics: tuple[str, ...] = ()
    maps: tuple[tuple[str, ...], ...] = ()

    @cached_property
    def row_values(self) -> tuple[Value, ...]:
        """Values of the rows: numbers rising, negative ones last; names as planned."""
        values = tuple(dict.fromkeys(self.trials[self.rows]))
        if any(isinstance(value, str) for value in values):
            return values
        return tuple(sorted(values, key=lambda value: (value < 0, abs(value))))

    @cached_property
    def column_values(self) -> tuple[Value, ...]:
        """Values of the columns, in the order of the plan."""
        return tuple(dict.fromkeys(self.trials[self.columns]))

    def of(self, variant: Variant) -> pd.DataFrame:
        """Trials of one variant."""
        return self.trials[self.trials["variant"] == variant.label]

    def at(self, variant: Variant, row: Value, column: Value) -> pd.DataFrame:
        """Trials of one cell."""
        trials = self.of(variant)
        return trials[(trials[self.rows] == row) & (trials[self.columns] == column)]

    def cell(self, variant: Variant, row: Value, column: Value) -> ScoredCell:
        """One cell, counted; empty when it was not planned."""
        return self._cells.get((variant.label, row, column), EMPTY)

    @cached_property
    def _cells(self) -> dict[tuple[str, Value, Value], ScoredCell]:
        place = ["variant", self.rows, self.columns]
        counted = dict.fromkeys((*place, "state", "stable", "stable_strict", "fell_standing"))
        known = [name for name in counted if name in self.trials.columns]
        groups = self.trials[known].groupby(place, sort=False)
        return {key: cell_of(group) for key, group in groups}

    def column_cells(self, variant: Variant, column: Value) -> list[ScoredCell]:
        """The planned cells of one column."""
        cells = (self.cell(variant, row, column) for row in self.row_values)
        return [cell for cell in cells if cell.planned]

    def by_column(self, variant: Variant) -> list[list[ScoredCell]]:
        """The planned cells of every column."""
        return [self.column_cells(variant, column) for column in self.column_values]

    def done_of(self, variant: Variant) -> pd.DataFrame:
        """Trials of one variant that were simulated."""
        return self.done[self.done["variant"] == variant.label]

    @cached_property
    def done(self) -> pd.DataFrame:
        """Trials that were simulated."""
        return self.trials[self.trials["state"] == "DONE"]
