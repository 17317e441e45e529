"""The best and the worst trial of a page, and the command that shows each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pandas as pd

from gaitlab.report.markdown import code, escape, fenced, table
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.words import NOTHING, place_text

SHORTEST = 8  # hex digits of a trial's name


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
        _row(results, what, trial, name) for (what, trial), name in zip(found, short, strict=True)
    ]
    if len(results.variants) < 2:
        header.remove("variant")
        rows = [row[:2] + row[3:] for row in rows]
    lines = [f"gaitlab replay {name}{options} --output {name}.gif" for name in short]
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
        yield "earliest fall", _first(down, "late", rising=True)
    elif len(up) > 1:
        yield "shortest walk", _first(up, "distance", rising=True)


def _first(trials: pd.DataFrame, column: str, *, rising: bool) -> pd.Series:
    """First trial in the order of a column; of equals the first of the plan."""
    keyed = trials.assign(key=pd.to_numeric(trials[column]))
    return keyed.sort_values("key", ascending=rising, kind="stable", na_position="last").iloc[0]


def shortened(names: Sequence[str], known: pd.Series) -> list[str]:
    """The first digits of each name, as many as tell it from every known one."""
    others = [str(name) for name in known]
    return [_short(name, others) for name in names]


def _short(name: str, others: Sequence[str]) -> str:
    for length in range(SHORTEST, len(name)):
        if sum(other.startswith(name[:length]) for other in others) < 2:
            return name[:length]
    return name


def _row(results: Results, what: str, trial: pd.Series, name: str) -> list[str]:
    return [
        what,
        code(name),
        escape(str(trial["variant"])),
        escape(place_text(results, trial[results.rows], trial[results.columns])),
        str(int(trial["seed"])),
        _number(trial["distance"]),
        _number(trial["time_to_fall"]),
    ]


def _number(value: object) -> str:
    number = pd.to_numeric(value, errors="coerce")
    return NOTHING if pd.isna(number) else f"{float(number):.3g}"
