"""Which trials a page shows: the representative ones of one cell, and the best and the worst."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile

import pandas as pd

from gaitlab.log import TrialLog
from gaitlab.report.markdown import code, escape, fenced, table
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import NOTHING, place_text
from gaitlab.simulation.trial import Trial

MOST_WALKS = 2  # variants whose walks are drawn, side by side
SHORTEST = 8  # hex digits of a trial's name


@dataclass(frozen=True, kw_only=True, eq=False)
class RepresentativeTrial:
    """The seeds of one cell, and the one that stands for them.

    Attributes:
        label: The variant; empty when there is one alone.
        seed: Seed of the shown trial.
        trial: The shown trial.
        log: Its log.
        amplitude: Its pitch amplitude, in [rad]; NaN if not defined.
        others: Ids of the other seeds that were simulated.
        falls: Seeds that fell.
    """

    label: str
    seed: int
    trial: Trial
    log: TrialLog
    amplitude: float
    others: Sequence[str]
    falls: int

    @property
    def n(self) -> int:
        """Seeds that were simulated."""
        return len(self.others) + 1

    @property
    def title(self) -> str:
        """Variant, what happened and which seed is drawn thick."""
        head = f"{self.label}: " if self.label else ""
        return f"{head}{self.falls} of {self.n} seeds fell; thick: seed {self.seed}"


def representative(trials: pd.DataFrame) -> str:
    """Id of the seed of median distance; of two in the middle the shorter."""
    ordered = trials.sort_values(["distance", "seed"], kind="stable")
    return str(ordered["trial_id"].iloc[(len(ordered) - 1) // 2])


def worst(trials: pd.DataFrame) -> pd.Series:
    """The seed that fell first or, where none fell, walked least; of equals the first planned."""
    trials = trials.assign(late=pd.to_numeric(trials["time_to_fall"]))
    down = trials[truth(trials["fell"])]
    return (
        _first(down, "late", rising=True) if len(down) else _first(trials, "distance", rising=True)
    )


def representative_cell(results: Results) -> tuple[Value, Value] | None:
    """Row and column whose walks say most; None if nothing was simulated.

    The cell in which most variants were simulated and their stable shares differ most; of equals,
    the one in which the shares are nearest to one half, then the first.
    """
    best: tuple[tuple[float, float, float], tuple[Value, Value]] | None = None
    for column in results.column_values:
        for row in results.row_values:
            cells = [results.cell(variant, row, column) for variant in results.variants]
            shares = [cell.share() for cell in cells if cell.n and cell.feasible]
            if not shares:
                continue
            doubt = -sum(abs(share - 0.5) for share in shares) / len(shares)
            rank = (float(len(shares)), round(max(shares) - min(shares), 9), round(doubt, 9))
            if best is None or rank > best[0]:
                best = (rank, (row, column))
    return best and best[1]


def walks_of(results: Results, row: Value, column: Value) -> list[RepresentativeTrial]:
    """The walks of one cell: of the variants that fall least and most there, in their order."""
    shares = {
        variant.label: results.cell(variant, row, column).share()
        for variant in results.variants
        if (results.at(variant, row, column)["state"] == "DONE").any()
    }
    ordered = sorted(shares, key=lambda label: shares[label])
    chosen = {*ordered[:1], *ordered[-1:]} if len(ordered) > MOST_WALKS else set(ordered)
    return [
        _walk(results, variant, row, column)
        for variant in results.variants
        if variant.label in chosen
    ]


def _walk(results: Results, variant: Variant, row: Value, column: Value) -> RepresentativeTrial:
    trials = results.at(variant, row, column)
    trials = trials[trials["state"] == "DONE"]
    shown = representative(trials)
    chosen = trials[trials["trial_id"] == shown].iloc[0]
    return RepresentativeTrial(
        label=variant.label if len(results.variants) > 1 else "",
        seed=int(chosen["seed"]),
        trial=results.trial(shown),
        log=results.log(shown),
        amplitude=float(chosen.get("pitch_amplitude", float("nan"))),
        others=tuple(str(name) for name in trials["trial_id"] if name != shown),
        falls=int(truth(trials["fell"]).sum()),
    )


def extremes_blocks(results: Results, options: str = "") -> list[str]:
    """Best and worst trial with the commands that replay them; empty if nothing was simulated.

    Args:
        results: What was simulated.
        options: What the commands need besides the trial, ` --store DIR` for instance.
    """
    found = list(extremes(results))
    if not found:
        return []
    names = [str(trial["trial_id"]) for _, trial in found]
    short = shortened(names, results.trials["trial_id"])
    header = ["", "trial", "variant", "cell", "seed", "distance [m]", "time to fall [s]"]
    rows = [
        [
            what,
            code(name),
            escape(str(trial["variant"])),
            escape(place_text(results, trial[results.rows], trial[results.columns])),
            str(int(trial["seed"])),
            _number(trial["distance"]),
            _number(trial["time_to_fall"]),
        ]
        for (what, trial), name in zip(found, short, strict=True)
    ]
    if len(results.variants) < 2:
        header.remove("variant")
        rows = [row[:2] + row[3:] for row in rows]
    lines = [f"gaitlab replay {name}{options} --output {name}.html" for name in short]
    watch = f"To watch them:\n\n{fenced(chr(10).join(lines), 'sh')}"
    return [table(header, rows, "lll"), watch]


def extremes(results: Results) -> Iterator[tuple[str, pd.Series]]:
    """The best and the worst trial of the page, each with what makes it so.

    Best is the farthest walk without a fall, worst the earliest fall; when nobody fell, the
    shortest walk, and when everybody fell, the latest fall is the best.
    """
    done = results.done.assign(late=pd.to_numeric(results.done["time_to_fall"]))
    fell = truth(done["fell"])
    up, down = done[~fell], done[fell]
    if len(up):
        yield "farthest walk without a fall", _first(up, "distance", rising=False)
    elif len(down):
        yield "latest fall", _first(down, "late", rising=False)
    if len(down):
        yield "earliest fall", worst(done)
    elif len(up) > 1:
        yield "shortest walk", worst(done)


def _first(trials: pd.DataFrame, column: str, *, rising: bool) -> pd.Series:
    """First trial in the order of a column; of equals the first of the plan."""
    keyed = trials.assign(key=pd.to_numeric(trials[column]))
    return keyed.sort_values("key", ascending=rising, kind="stable", na_position="last").iloc[0]


def shortened(names: Sequence[str], known: Iterable[str]) -> list[str]:
    """The first digits of each name, as many as tell it from every known one."""
    ordered = sorted({*names, *map(str, known)})
    return [_short(name, ordered) for name in names]


def _short(name: str, ordered: Sequence[str]) -> str:
    at = bisect_left(ordered, name)
    neighbours = (*ordered[max(0, at - 1) : at], *ordered[at + 1 : at + 2])
    alike = (takewhile(bool, map(str.__eq__, name, other)) for other in neighbours)
    shared = max((len(list(same)) for same in alike), default=0)
    return name[: max(SHORTEST, shared + 1)]


def _number(value: object) -> str:
    number = pd.to_numeric(value, errors="coerce")
    return NOTHING if pd.isna(number) else f"{float(number):.3g}"
