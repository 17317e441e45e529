"""One fall and the same seed walking with something changed: chosen by rule, drawn from logs."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pandas as pd

from gaitlab.picture.figure_style import save
from gaitlab.replay.cut import cut_of
from gaitlab.replay.replay import write_replay
from gaitlab.replay.take import Recorded
from gaitlab.report.before_falls.reading import body_log
from gaitlab.report.figures.balance import Column, balance_figure
from gaitlab.report.representative import Walk
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Value, Variant
from gaitlab.store import Store

BEFORE = 1.5  # s of the strip before the fall is established
PANELS = 6
PANEL = (250, 290)  # pixels; a strip of two rows stays below 400 kB
LINES = 5  # other seeds drawn thin


class Pair(NamedTuple):
    """Two walks of one cell and seed.

    Attributes:
        fall: Row of the trial that falls.
        other: Row of the trial with the other variant.
        rule: True if the other stays up; False if it is only the one that falls latest after.
    """

    fall: pd.Series
    other: pd.Series
    rule: bool


def telling_pair(results: Results, first: Variant, second: Variant) -> Pair | None:
    """The first seed of the first cell in which one variant falls and the other stays up.

    Cells in the order of the tables, row by row: the shortest step first, forward before backward,
    the grounds in their order. If there is none, the pair in which the second falls latest after
    the first; None if the first never falls or no seed was simulated with both.
    """
    nearest: tuple[float, Pair] | None = None
    for row in results.row_values:
        for column in results.column_values:
            for fall, other in _pairs(results, first, second, row, column):
                if not truth(pd.Series([other["fell"]]))[0]:
                    return Pair(fall, other, True)
                later = float(other["time_to_fall"]) - float(fall["time_to_fall"])
                if nearest is None or later > nearest[0]:
                    nearest = (later, Pair(fall, other, False))
    return None if nearest is None else nearest[1]


def _pairs(
    results: Results, first: Variant, second: Variant, row: Value, column: Value
) -> list[tuple[pd.Series, pd.Series]]:
    """Falls of the first variant in a cell, each with the same seed of the second, by seed."""
    one, two = (results.at(v, row, column) for v in (first, second))
    fell = one[(one["state"] == "DONE") & truth(one["fell"])].sort_values("seed", kind="stable")
    done = two[two["state"] == "DONE"].drop_duplicates("seed").set_index("seed", drop=False)
    return [
        (fall, done.loc[fall["seed"]]) for _, fall in fell.iterrows() if fall["seed"] in done.index
    ]


def write_strip(results: Results, pair: Pair, path: Path) -> None:
    """A strip of both walks at the same instants, ending when the fall is established."""
    names = [str(row["trial_id"]) for row in (pair.fall, pair.other)]
    shown = [Recorded(name, results.trial(name), results.log(name)) for name in names]
    log = shown[0].log
    end = float(log["time"][len(log) - 1 if log.fall_index is None else log.fall_index])
    end -= log.header.startup_time
    cut = cut_of([log], begin=max(end - BEFORE, -log.header.startup_time + log.header.dt), end=end)
    write_replay(shown, path, cut, size=PANEL, panels=PANELS)


def save_balance(
    results: Results, store: Store, pair: Pair, variants: tuple[Variant, Variant], folder: Path
) -> None:
    """Pitch, roll, ZMP and support of both against time, the other seeds of the cell thin."""
    columns = []
    for variant, shown in zip(variants, (pair.fall, pair.other), strict=True):
        cell = results.at(variant, shown[results.rows], shown[results.columns])
        cell = cell[cell["state"] == "DONE"]
        others = [str(name) for name in cell["trial_id"] if name != shown["trial_id"]]
        walk = Walk(
            label=variant.label,
            seed=int(shown["seed"]),
            trial=results.trial(str(shown["trial_id"])),
            log=results.log(str(shown["trial_id"])),
            amplitude=float(shown.get("pitch_amplitude", float("nan"))),
            others=tuple(others),
            falls=int(truth(cell["fell"]).sum()),
        )
        columns.append(Column(walk=walk, others=[body_log(store, n) for n in others[:LINES]]))
    save(balance_figure(columns), folder, "falls_balance")
